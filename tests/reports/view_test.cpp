// SPDX-License-Identifier: MIT
#include "reports/view.hpp"

#include <numeric>

#include "model/dynamics/lattice.hpp"
#include "reports/view_thinning.hpp"
#include "tests/check.hpp"
#include "tests/reports/view_sample.hpp"

using namespace palpate;

namespace {

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

/// Two layers with a body of another material in the lower one, along z.
ViewSample layered_block() {
  ViewSample sample;
  sample.scene.tissue.source = Source::layers;
  sample.scene.tissue.block = {.nodes = {5, 5}, .spacing = 0.002};
  sample.scene.materials = {{.name = "a", .youngs_modulus = 1e3}, {.name = "b", .youngs_modulus = 2e3}};
  sample.scene.tissue.layers = {{"skin", "a", 0.004}, {"fat", "b", 0.008}};
  sample.scene.tissue.inclusions = {{Inclusion::Shape::box, {0.0, 0.0, 0.010}, {0.0041, 0.0041, 0.0041}, "a"}};
  const SpringNetwork network = build_network(sample.scene);
  sample.trace = {.time = {0.0}, .frame_time = {0.0}, .frames = {network.rest_position}};
  sample.problem = std::make_unique<NetworkProblem>(network);
  return sample;
}

}  // namespace

TEST("a small network is shown whole, with its skin, springs, forces and largest reaction") {
  const ViewSample sample = pressed_block({6, 6, 5}, 7);
  const auto view = sample.view();
  CHECK(view && view->rest == sample.problem->network().rest_position && view->notes.empty());
  CHECK(view->springs.size() == sample.problem->network().springs.size());
  CHECK(std::accumulate(view->cell.begin(), view->cell.end(), 0) == 5 * 5 * 4);
  CHECK(view->surfaces.size() == 1 && view->surfaces[0].vertices.size() == 36 &&
        view->surfaces[0].triangles.size() == 2 * 25);
  CHECK(view->frames.size() == 7 && view->peak == 6);
  CHECK_NEAR(view->frames[3].applied, 2.0, 1e-15);
  CHECK_NEAR(view->frames[4].displacement, NodeVectors(sample.trace.frames[4] - view->rest), 1e-18);
  CHECK(view->frames[6].reaction > view->frames[5].reaction && view->frames[5].reaction > 0.0);
}

TEST("cells and nodes are told by what fills them") {
  const auto view = layered_block().view();
  CHECK(view && view->labels == std::vector<std::string>({"skin", "fat", "a"}));
  std::vector<int> cells(3, 0);
  for (std::size_t n = 0; n < view->cell.size(); ++n) { cells[view->label[n]] += view->cell[n]; }
  // 4 x 4 cells a plane, 2 planes of skin and 4 of fat; the body fills 2 x 2 x 2 of these.
  CHECK(cells == std::vector<int>({32, 56, 8}));
}

TEST("frames of the trace are thinned to sixty, and moments come between them") {
  ViewSample sample = pressed_block({3, 3, 3}, 200);
  sample.moments.time = {0.0, 0.123};
  sample.moments.positions = {sample.trace.frames[0], sample.trace.frames[12]};
  const auto view = sample.view();
  CHECK(view->frames.size() == 61);
  CHECK(std::ranges::is_sorted(view->frames, {}, &ViewFrame::time));
  CHECK(std::ranges::count(view->frames, 0.123, &ViewFrame::time) == 1);
  CHECK(view->frames.front().time == 0.0 && view->frames.back().time == sample.trace.frame_time.back());
}

TEST("a state that is not finite is not shown, and without any there is no view") {
  ViewSample sample = pressed_block({3, 3, 3}, 3);
  sample.trace.frames[2](1, 4) = std::nan("");
  CHECK(sample.view()->frames.size() == 2);
  sample.trace.frames.clear();
  CHECK(!sample.view());
}

TEST("a large block keeps its surface, its cut and what is near the tool, and says so") {
  const ViewSample sample = pressed_block({40, 40, 40}, 1);
  const SpringNetwork& network = sample.problem->network();
  const ViewFocus focus{.end = {0.0, 0.0, 0.05}, .radius = 0.01};
  const ShownNodes shown = shown_nodes(network, focus, {});
  CHECK(shown.nodes.size() < static_cast<std::size_t>(most_nodes_shown) && contains(shown.note, "of 64"));
  std::vector<std::uint8_t> is_shown(64000, 0);
  for (const int node : shown.nodes) { is_shown[static_cast<std::size_t>(node)] = 1; }
  for (int node = 0; node < 64000; ++node) {
    const GridPlace& place = shown.grid->places()[static_cast<std::size_t>(node)];
    const bool outer = std::ranges::any_of(place, [](int n) { return n == 0 || n == 39; });
    const Eigen::Vector3d x = network.rest_position.col(node);
    const bool near = x.head<2>().norm() < 0.006 && x.z() < 0.05;
    if (outer || near || std::abs(x.y()) < 0.003) { CHECK(is_shown[static_cast<std::size_t>(node)] == 1); }
  }
}

TEST("a block too large even for that is shown by every n-th plane") {
  SpringNetwork network =
      uniform_lattice({.nodes = {150, 150, 60}, .spacing = 0.001, .connectivity = 6}, 1.0, 0.0, 1e-3);
  const ShownNodes shown = shown_nodes(network, {.cut = 0.0}, {7});
  CHECK(shown.nodes.size() <= static_cast<std::size_t>(most_nodes_shown) + 1 &&
        contains(shown.note, "every 2nd plane"));
  CHECK(std::ranges::find(shown.nodes, 7) != shown.nodes.end());
}

TEST("a surface of a person's own follows the nodes that it names, in place of the grid's skin") {
  const ViewSample sample = pressed_block({3, 3, 3}, 2);
  const ViewSurface torso{
      .label = "torso", .rest = NodeVectors::Zero(3, 3), .vertices = {{{0, 0.5}, {1, 0.5}}, {{5, 1.0}}, {{8, 1.0}}}, .triangles = {{0, 1, 2}}};
  const auto view = make_view({sample.scene, *sample.problem, sample.trace, sample.moments, {torso}});
  CHECK(view->surfaces.size() == 1 && view->surfaces[0].label == "torso" && view->surfaces[0].vertices[1][0].node == 5);
}
