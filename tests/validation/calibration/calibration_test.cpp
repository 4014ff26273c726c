// SPDX-License-Identifier: MIT

#include "validation/calibration/calibration.hpp"

#include "tests/check.hpp"
#include "tests/validation/calibration/samples.hpp"

namespace {

using namespace palpate::calibration;
using namespace palpate;

std::vector<ObservedRecording> group(const char* name, double thumb) {
  std::vector<ObservedRecording> subjects;
  for (const double factor : {0.98, 1.0, 1.02}) {
    Scene scene = with_thumb_force(thumb * factor);
    scene.syringe->epidural_resistance *= factor;
    scene.materials[1].cutting_force *= factor;
    subjects.push_back({.recording = {.group = name}, .seen = lawful(scene)});
  }
  return subjects;
}

TEST("the misfit grows as a parabola about the fit, fitted again in the others") {
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
  std::vector<ObservedRecording> all = group("a", 11.0);
  for (const char* name : {"b", "c"}) {
    for (ObservedRecording& subject : group(name, name[0] == 'c' ? 22.0 : 11.0)) {
      all.push_back(std::move(subject));
    }
  }
  Forward forward = lawful_forward();
  const Fit found = fit(forward, pool(all));
  const std::vector<HeldOut> held = leave_groups_out(forward, found, all);
  REQUIRE(held.size() == 3);
  CHECK(held[2].group == "c");
  CHECK(held[2].subjects == 3);
  // One observable of ten, the peak, is half of what it is: sqrt(0.25 / 10). 0.005: the prior's
  // pull.
  CHECK_NEAR(held[2].error_predicted, std::sqrt(0.025), 0.005);
  CHECK(held[2].error_fitted < 0.01);
  CHECK(leave_groups_out(forward, found, group("a", 11.0)).empty());
}

TEST("relative errors leave out what is not there") {
  const Eigen::Vector3d simulated(1.1, 2.0, 5.0);
  const Eigen::Vector3d seen(1.0, std::nan(""), 4.0);
  CHECK_NEAR(root_mean_square(relative_errors(simulated, seen)), std::sqrt((0.01 + 0.0625) / 2.0),
             1e-15);
}

std::vector<ObservedRecording> seen_in(const Scene& scene) {
  return {{.recording = {.name = "one"}, .seen = lawful(scene)}};
}

TEST("a calibration ends with a scene whose simulation is what was seen") {
  const Scene scene = three_layers();
  std::vector<std::string> stages;
  const Calibration found = calibrate(
      scene, parameters_of(scene), seen_in(with_thumb_force(9.0)),
      {.progress = [&](const char* stage) { stages.emplace_back(stage); }, .simulate = lawful});
  CHECK(found.outcome().status == Status::pass);
  CHECK(stages.size() == 4);
  // The gain of 1 % against a prior of 0.35: (0.01 / 0.35)^2 of the difference remains, below 0.1
  // %.
  CHECK_NEAR(found.fitted.syringe->thumb_force / 9.0, 1.0, 1e-3);
  CHECK_NEAR(found.shortcut_cost(), 0.0, 1e-12);  // the law has no shortcuts
}

TEST("shortcuts that cost more than data are uncertain do not hold") {
  const Scene scene = three_layers();
  const auto with_shortcut = [](const Scene& at) {
    ObservedInsertion seen = lawful(at);
    if (at.simulation.step > 1.5e-3) { seen.value[0] *= 1.1; }  // the coarser one alone
    return seen;
  };
  const Calibration found =
      calibrate(scene, parameters_of(scene), seen_in(scene), {.simulate = with_shortcut});
  CHECK(found.shortcut_cost() > 5.0);
  CHECK(found.outcome().status != Status::pass);
}

}  // namespace
