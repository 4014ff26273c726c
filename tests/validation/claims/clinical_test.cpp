// SPDX-License-Identifier: MIT
/// Faults planted in what is compared must turn the verdicts of group "clinical" red; without a
/// fault the same cases are green.

#include <algorithm>
#include <cmath>

#include "model/problem/recording.hpp"
#include "tests/validation/planted_faults.hpp"

namespace {

using namespace palpate;

TEST("a pressure 3 % too high is seen by every measure of size") {
  const Mutation fault{.name = "gain +3 %", .pressure = [](std::vector<double>& pressure) {
                         for (double& p : pressure) { p *= 1.03; }
                       }};
  check_red(fault, {"clinical/measures/closed-forms", "clinical/measures/fault-table",
                    "clinical/measures/filter", "clinical/features/closed-form"});
}

TEST("samples that are held for two make noise of another colour, and uncertainties wrong") {
  const Mutation fault{.name = "every second sample held",
                       .pressure = [](std::vector<double>& pressure) {
                         for (std::size_t n = 1; n < pressure.size(); n += 2) {
                           pressure[n] = pressure[n - 1];
                         }
                       }};
  check_red(fault, {"clinical/features/uncertainty"});
}

TEST("a pressure half as high again leaves verdicts and corridors") {
  const Mutation fault{.name = "gain +50 %", .pressure = [](std::vector<double>& pressure) {
                         for (double& p : pressure) { p *= 1.5; }
                       }};
  check_red(fault,
            {"clinical/verdicts", "clinical/subjects/corridor", "clinical/subjects/bootstrap"});
}

TEST("a trace one sample late is seen") {
  const Mutation fault{.name = "one sample late", .pressure = [](std::vector<double>& pressure) {
                         for (std::size_t n = pressure.size() - 1; n > 0; --n) {
                           pressure[n] = pressure[n - 1];
                         }
                       }};
  check_red(fault, {"clinical/measures/fault-table", "clinical/measures/filter",
                    "clinical/features/closed-form"});
}

TEST("a simulated pressure that is not the one that was recorded is seen") {
  const Mutation off{.name = "0.06 mmHg too high", .pressure = [](std::vector<double>& pressure) {
                       // more than the link rounds
                       for (double& p : pressure) { p += 0.06 * pascals_per_mmhg; }
                     }};
  check_red(off, {"clinical/round-trip"});
  const Mutation late{.name = "two frame periods late",
                      .pressure = [](std::vector<double>& pressure) {
                        std::shift_right(pressure.begin(), pressure.end(), 17);  // ticks of 1 ms
                      }};
  check_red(late, {"clinical/round-trip"});
}

TEST("a pressure that never falls loses its event") {
  const Mutation fault{.name = "never falls", .pressure = [](std::vector<double>& pressure) {
                         for (std::size_t n = 1; n < pressure.size(); ++n) {
                           pressure[n] = std::max(pressure[n], pressure[n - 1]);
                         }
                       }};
  check_red(fault, {"clinical/detection", "clinical/verdicts", "clinical/features/closed-form",
                    "clinical/blind-spots", "clinical/round-trip"});
}

TEST("a pressure that fades on its own raises false alarms") {
  const Mutation fault{.name = "gone after 15 s", .pressure = [](std::vector<double>& pressure) {
                         for (std::size_t n = pressure.size() / 2; n < pressure.size(); ++n) {
                           pressure[n] *= 0.05;
                         }
                       }};
  check_red(fault, {"clinical/detection"});
}

TEST("a fall that a first-order lag draws out is seen") {
  const Mutation fault{.name = "lagging", .pressure = [](std::vector<double>& pressure) {
                         for (std::size_t n = 1; n < pressure.size(); ++n) {
                           pressure[n] = pressure[n - 1] + 0.02 * (pressure[n] - pressure[n - 1]);
                         }
                       }};
  check_red(fault,
            {"clinical/verdicts", "clinical/features/closed-form", "clinical/measures/filter"});
}

TEST("a sample that is not a number is never rated well") {
  const Mutation fault{.name = "NaN", .pressure = [](std::vector<double>& pressure) {
                         pressure[pressure.size() / 2] = std::nan("");
                       }};
  check_status("clinical/measures/filter", &fault, Status::fail);
  check_red(fault, {"clinical/round-trip"});
  check_status("clinical/measures/fault-table", &fault, Status::error);  // a rating refuses it
}

}  // namespace

// Faults planted in the simulation that a calibration fits must turn its cases red.

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
    CHECK(each.upper < 1.0);
    CHECK(each.lower > 0.85);
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
