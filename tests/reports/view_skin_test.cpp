// SPDX-License-Identifier: MIT
#include "reports/view_skin.hpp"

#include "model/dynamics/network_builder.hpp"
#include "model/dynamics/skin.hpp"
#include "reference/solids.hpp"
#include "reports/view_still.hpp"
#include "tests/check.hpp"
#include "tests/reports/view_sample.hpp"

namespace {

using namespace palpate;

/// A patch of skin 4 mm above a block of 20 mm, four times as wide.
ViewSample beneath_patch(int steps) {
  ViewSample sample = pressed_block({6, 6, 6}, 3);
  sample.scene.tissue.skin = std::make_shared<const Skin>(
      reference::patch_surface({0.04, 0.04}, steps, [](double, double) { return -0.004; }), true);
  return sample;
}

TEST("without a skin there is none to show") {
  std::vector<std::string> notes;
  CHECK(!view_of_skin(pressed_block({3, 3, 3}, 2).scene, notes) && notes.empty());
}

TEST("the skin around the tissue is shown, and what lies within two spacings of it follows") {
  const ViewSample sample = beneath_patch(40);
  std::vector<std::string> notes;
  const auto skin = view_of_skin(sample.scene, notes);
  // 20 mm to either side, and the squares that touch its rim.
  CHECK(skin && !skin->of_cells && skin->triangles.size() >= 2 * 20 * 20 && skin->triangles.size() <= 2 * 22 * 22);
  CHECK(notes.size() == 1 && notes[0].find(" of 3200 faces of the skin are shown") != std::string::npos);
  for (std::size_t n = 0; n < skin->vertices.size(); ++n) {
    const Eigen::Vector3d at = skin->rest.col(static_cast<Eigen::Index>(n));
    const double beside = (at.head<2>().cwiseAbs().array() - 0.01).max(0.0).matrix().norm();
    const bool near = std::hypot(beside, 0.004) <= 0.008 * (1.0 + 1e-9);
    CHECK(skin->vertices[n].empty() != near);
    double sum = 0.0;
    for (const ViewSurface::Support& support : skin->vertices[n]) { sum += support.weight; }
    CHECK_NEAR(sum, near ? 1.0 : 0.0, 1e-15);
  }
  const auto view = make_view({sample.scene, *sample.problem, sample.trace, sample.moments, {*skin}});
  CHECK(view && view->surfaces.size() == 1 && view->surfaces[0].vertices.size() == skin->vertices.size());
  ViewSample bare = pressed_block({6, 6, 6}, 3);
  CHECK(still_at_rest(*view).size() > still_at_rest(*bare.view()).size());
}

TEST("a skin of too many faces is left out, and a note says so") {
  std::vector<std::string> notes;
  CHECK(!view_of_skin(beneath_patch(400).scene, notes));
  CHECK(notes.size() == 1 && notes[0].find("the skin is not shown: ") != std::string::npos);
}

}  // namespace
