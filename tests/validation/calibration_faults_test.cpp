// SPDX-License-Identifier: MIT
/// Faults planted in the simulation that a calibration fits must turn its cases red.

#include "tests/validation/planted_faults.hpp"

namespace {

using namespace palpate;

TEST("a needle that cuts the flavum with two thirds of its force makes intervals miss the truth") {
  const Mutation fault{.name = "flavum cut by 2/3", .model = [](Scene& scene, SpringNetwork&) {
                         for (Material& material : scene.materials) {
                           if (material.name == "flavum") { material.cutting_force *= 2.0 / 3.0; }
                         }
                       }};
  check_red(fault, {"clinical/calibration/coverage"});
}

TEST("a pressure of nine tenths makes intervals of the thumb's force miss it") {
  const Mutation fault{.name = "gain -10 %", .pressure = [](std::vector<double>& pressure) {
                         for (double& p : pressure) { p *= 0.9; }
                       }};
  check_red(fault, {"clinical/calibration/coverage"});
}

#ifndef PALPATE_SANITIZED  // of bounds, not of code: half a minute there
TEST("intervals that always hold the truth are too wide, and are outside the bound") {
  const std::vector<std::string> coverage{"clinical/calibration/coverage"};
  const Outcome outcome =
      run_case(select_cases(all_cases(), coverage, true).front(), CaseContext{.quick = true});
  int judged = 0;
  for (const Quantity& each : outcome.quantities) {
    if (!each.name.starts_with("intervals_that_hold")) { continue; }
    CHECK(each.upper < 1.0 && each.lower > 0.85);
    ++judged;
  }
  CHECK(judged == 5);
}
#endif

TEST("a thumb that never presses harder hides the groups") {
  const Mutation fault{.name = "thumb at 11 N", .model = [](Scene& scene, SpringNetwork&) {
                         if (scene.syringe) { scene.syringe->thumb_force = 11.0; }
                       }};
  check_red(fault, {"clinical/calibration/groups"});
}

}  // namespace
