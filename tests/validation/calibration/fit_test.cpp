// SPDX-License-Identifier: MIT
#include "validation/calibration/fit.hpp"

#include <algorithm>
#include <cmath>

#include "tests/check.hpp"
#include "tests/validation/calibration/samples.hpp"

using namespace palpate;
using namespace palpate::calibration;

namespace {

const FittedParameter& of(const Fit& fit, std::string_view key) {
  return *std::ranges::find_if(fit.parameters,
                               [&](const FittedParameter& p) { return p.parameter.key == key; });
}

Scene stronger_thumb() {
  Scene truth = three_layers();
  truth.syringe->thumb_force *= 1.3;
  truth.materials[1].cutting_force *= 0.7;
  truth.syringe->compliance *= 1.8;
  return truth;
}

TEST("exact data give back what made them, and name what nothing depends on") {
  const Scene scene = three_layers();
  Forward forward(scene, parameters_of(scene), 2, nullptr, lawful);
  const Fit found = fit(forward, lawful_data(stronger_thumb(), 1e-3));
  CHECK(found.converged && found.misfit_after < 0.1 && found.misfit_before > 1e4);
  // A prior of 0.35 pulls data of 0.001 by (0.001 / 0.35)^2 of the way, 3e-6; 1e-4 is the step tolerance.
  CHECK_NEAR(of(found, "syringe.thumb_force").value / 14.3, 1.0, 1e-4);
  CHECK_NEAR(of(found, "material.ligament.cutting_force").value / 3.5, 1.0, 1e-4);
  CHECK_NEAR(of(found, "syringe.compliance").value / 3.6e-12, 1.0, 1e-4);
  CHECK(of(found, "material.ligament.friction").telling == Telling::insensitive);
  CHECK(of(found, "material.ligament.friction").value == 80.0);
  CHECK(of(found, "layer.0.thickness").telling == Telling::told);
}

TEST("intervals are those of the law: the thumb force is known as well as the peak") {
  const Scene scene = three_layers();
  Forward forward(scene, parameters_of(scene), 1, nullptr, lawful);
  const Fit found = fit(forward, lawful_data(scene, 0.01));
  const FittedParameter& thumb = of(found, "syringe.thumb_force");
  const double told = thumb.parameter.spread / 0.01;  // slope over uncertainty
  // Forward differences of an exponential over a tenth of a spread of 0.35: half of 0.035 high.
  CHECK_NEAR(thumb.deviation * std::sqrt(1.0 + told * told), 1.0, 0.03);
  CHECK(thumb.interval.holds(11.0) && !thumb.interval.holds(11.3));
}

TEST("a bound that data push against is said") {
  const Scene scene = three_layers();
  std::vector<Parameter> parameters = parameters_of(scene);
  for (Parameter& p : parameters) {
    if (p.key == "syringe.thumb_force") { p.upper = 12.0; }
  }
  Forward forward(scene, parameters, 1, nullptr, lawful);
  const Fit found = fit(forward, lawful_data(stronger_thumb(), 1e-2));
  CHECK(of(found, "syringe.thumb_force").at_bound && of(found, "syringe.thumb_force").value <= 12.0);
  CHECK(found.widening > 1.0);  // 14.3 N cannot be reached: more than chance
}

TEST("data that tell nothing leave everything at its prior") {
  const Scene scene = three_layers();
  Forward forward(scene, parameters_of(scene), 1, nullptr, lawful);
  const Fit found = fit(forward, lawful_data(stronger_thumb(), 50.0));
  CHECK(found.told.empty() && found.values() == forward.priors());
}

}  // namespace
