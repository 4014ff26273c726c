// SPDX-License-Identifier: MIT
#include "validation/calibration/calibration.hpp"

#include <cmath>

#include "tests/check.hpp"
#include "tests/validation/calibration/samples.hpp"

using namespace palpate;
using namespace palpate::calibration;

namespace {

std::vector<Subject> seen_in(const Scene& scene) { return {{.name = "one", .seen = lawful(scene)}}; }

TEST("a calibration ends with a scene whose simulation is what was seen") {
  Scene truth = three_layers();
  truth.syringe->thumb_force = 9.0;
  const Scene scene = three_layers();
  std::vector<std::string> stages;
  const Calibration found =
      calibrate(scene, parameters_of(scene), seen_in(truth),
                {.progress = [&](const char* stage) { stages.emplace_back(stage); }, .simulate = lawful});
  CHECK(found.held() && stages.size() == 4);
  // The gain of 1 % against a prior of 0.35: (0.01 / 0.35)^2 of the way is left, below 0.1 %.
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
  CHECK(found.shortcut_cost() > 5.0 && !found.held());
}

}  // namespace
