// SPDX-License-Identifier: MIT
#include "validation/calibration/parameter.hpp"

#include <algorithm>
#include <cmath>

#include "tests/check.hpp"
#include "tests/validation/calibration/samples.hpp"

using namespace palpate;
using namespace palpate::calibration;

namespace {

const Parameter* find(const std::vector<Parameter>& all, std::string_view key) {
  const auto found = std::ranges::find(all, key, &Parameter::key);
  return found == all.end() ? nullptr : &*found;
}

TEST("a scene offers the layers before the epidural space, the fat's thickness and the syringe") {
  const std::vector<Parameter> all = parameters_of(three_layers());
  CHECK(all.size() == 3 + 3 + 1 + 4);
  CHECK(find(all, "material.ligament.cutting_force") != nullptr && find(all, "layer.0.thickness") != nullptr);
  CHECK(find(all, "material.epidural-space.youngs_modulus") == nullptr);
  CHECK(find(all, "material.ligament.cutting_force")->prior == 5.0);
}

TEST("one spread is one spread of the logarithm, and default bounds are four") {
  Parameter p{.key = "x", .prior = 2.0, .spread = 0.5};
  set_default_bounds(p);
  CHECK_NEAR(p.value(1.0), 2.0 * std::exp(0.5), 1e-14);  // rounding
  CHECK_NEAR(p.standardised(p.value(-2.5)), -2.5, 1e-14);
  CHECK_NEAR(p.standardised(p.upper), 4.0, 1e-14);
}

TEST("a thicker layer sends the needle as much deeper, and the scene lasts until it is there") {
  const Scene scene = three_layers();
  const std::vector<Parameter> all = parameters_of(scene);
  const Scene changed = with_values(scene, {*find(all, "layer.0.thickness")}, {0.015});
  CHECK_NEAR(*changed.drive->depth, 0.038, 1e-15);  // rounding
  CHECK_NEAR(changed.simulation.duration, 9.0, 1e-12);
  const auto keys = changes(scene, changed);
  CHECK(keys.size() == 3 && keys[0].first == "layer.0.thickness" && keys[1].first == "drive.depth");
  CHECK(changes(scene, scene).empty());
}

TEST("a scene that cannot be compared says why") {
  CHECK(why_not_calibrated(three_layers()).empty());
  Scene scene = three_layers();
  scene.syringe.reset();
  CHECK(why_not_calibrated(scene).starts_with("syringe"));
  scene = three_layers();
  scene.drive->depth = 0.029;
  CHECK(why_not_calibrated(scene).starts_with("drive.depth"));
  scene = three_layers();
  scene.tissue.layers.pop_back();
  CHECK(why_not_calibrated(scene).starts_with("layer"));
}

}  // namespace
