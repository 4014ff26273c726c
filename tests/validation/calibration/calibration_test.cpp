// SPDX-License-Identifier: MIT

#include "validation/calibration/calibration.hpp"

#include "tests/check.hpp"
#include "tests/validation/calibration/samples.hpp"

namespace {

using namespace palpate::calibration;
using namespace palpate;

void add_group(std::vector<ObservedRecording>& subjects, const char* name, double thumb) {
  for (const double factor : {0.98, 1.0, 1.02}) {
    Scene scene = with_thumb_force(thumb * factor);
    scene.syringe->epidural_resistance *= factor;
    scene.materials[1].cutting_force *= factor;
    subjects.push_back({.recording = {.group = name}, .seen = lawful(scene)});
  }
}

TEST("the misfit is a parabola around the fit if the other parameters are fitted again") {
  Forward forward = lawful_forward();
  const Fit found = fit(forward, lawful_data(three_layers(), 0.01));
  const calibration::Profile profile = profile_of_worst(forward, found);
  CHECK(profile.value.size() == 9);
  CHECK_NEAR(profile.growth[4], 0.0, 1e-6);  // the fit itself
  // One deviation grows it by 1 where observables are independent; slopes are 2 % high (fit_test).
  CHECK_NEAR(profile.growth[0], 1.0, 0.1);
  CHECK_NEAR(profile.growth[8], 1.0, 0.1);
}

TEST("a group that differs is predicted worse than the fitted ones, by as much as it differs") {
  std::vector<ObservedRecording> all;
  add_group(all, "a", 11.0);
  const std::vector<ObservedRecording> one_group = all;
  add_group(all, "b", 11.0);
  add_group(all, "c", 22.0);
  Forward forward = lawful_forward();
  const Fit found = fit(forward, pool(all));
  const std::vector<HeldOut> held = leave_groups_out(forward, found, all);
  REQUIRE(held.size() == 3);
  CHECK(held[2].group == "c");
  CHECK(held[2].subjects == 3);
  // One observable of ten, the peak, is halved: sqrt(0.25 / 10). 0.005: effect of the prior.
  CHECK_NEAR(held[2].error_predicted, std::sqrt(0.025), 0.005);
  CHECK(held[2].error_fitted < 0.01);
  CHECK(leave_groups_out(forward, found, one_group).empty());
}

TEST("relative errors leave out absent observables") {
  const Eigen::VectorXd errors =
      relative_errors(Eigen::Vector3d(1.1, 2.0, 5.0), Eigen::Vector3d(1.0, std::nan(""), 4.0));
  CHECK_NEAR(root_mean_square(errors), std::sqrt((0.01 + 0.0625) / 2.0), 1e-15);
}

/// Calibration of the scene from one recording of another.
Calibration calibrated_from(const Scene& truth, const CalibrationOptions& options) {
  const std::vector<ObservedRecording> one{{.recording = {.name = "one"}, .seen = lawful(truth)}};
  return calibrate(three_layers(), parameters_of(three_layers()), one, options);
}

TEST("a calibration ends with a scene whose simulation gives the observations") {
  int stages = 0;
  const Calibration found = calibrated_from(
      with_thumb_force(9.0), {.progress = [&](const char*) { ++stages; }, .simulate = lawful});
  CHECK(found.outcome().status == Status::pass);
  CHECK(stages == 4);
  // With a gain of 1 % and a prior of 0.35, (0.01 / 0.35)^2 of the difference remains: < 0.1 %.
  CHECK_NEAR(found.fitted.syringe->thumb_force / 9.0, 1.0, 1e-3);
  CHECK_NEAR(found.shortcut_cost(), 0.0, 1e-12);  // the law has no shortcuts
}

TEST("shortcuts whose error exceeds the uncertainty of the data do not pass") {
  const auto with_shortcut = [](const Scene& at) {
    ObservedInsertion seen = lawful(at);
    if (at.simulation.step > 1.5e-3) { seen.value[0] *= 1.1; }  // the coarser one alone
    return seen;
  };
  const Calibration found = calibrated_from(three_layers(), {.simulate = with_shortcut});
  CHECK(found.shortcut_cost() > 5.0);
  CHECK(found.outcome().status != Status::pass);
}

}  // namespace
