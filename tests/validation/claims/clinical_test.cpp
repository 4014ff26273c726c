// SPDX-License-Identifier: MIT
/// Tests that faults planted in the compared data fail the verdicts of group "clinical", which pass
/// without a fault.

#include <algorithm>
#include <cmath>

#include "model/problem/recording.hpp"
#include "tests/validation/planted_faults.hpp"

namespace {

using namespace palpate;

Mutation in_pressure(std::string name, std::function<void(std::vector<double>&)> change) {
  return {.name = std::move(name), .trace = [change](Trace& trace) {
            if (trace.find("syringe.pressure_pa") != nullptr) {
              change(trace.values("syringe.pressure_pa"));
            }
          }};
}

TEST("a pressure 3 % too high is seen by every measure of size") {
  const Mutation fault = in_pressure("gain +3 %", [](std::vector<double>& pressure) {
    for (double& p : pressure) { p *= 1.03; }
  });
  check_red(fault, {"clinical/measures/closed-forms", "clinical/measures/fault-table",
                    "clinical/measures/filter", "clinical/features/closed-form"});
}

TEST("samples that are held for two make noise of another colour, and uncertainties wrong") {
  const Mutation fault = in_pressure("every second sample held", [](std::vector<double>& pressure) {
    for (std::size_t n = 1; n < pressure.size(); n += 2) { pressure[n] = pressure[n - 1]; }
  });
  check_red(fault, {"clinical/features/uncertainty"});
}

TEST("a pressure half as high again leaves verdicts and corridors") {
  const Mutation fault = in_pressure("gain +50 %", [](std::vector<double>& pressure) {
    for (double& p : pressure) { p *= 1.5; }
  });
  check_red(fault,
            {"clinical/verdicts", "clinical/subjects/corridor", "clinical/subjects/bootstrap"});
}

TEST("a trace one sample late is seen") {
  const Mutation fault = in_pressure("one sample late", [](std::vector<double>& pressure) {
    for (std::size_t n = pressure.size() - 1; n > 0; --n) { pressure[n] = pressure[n - 1]; }
  });
  check_red(fault, {"clinical/measures/fault-table", "clinical/measures/filter",
                    "clinical/features/closed-form"});
}

TEST("a simulated pressure that is not the one that was recorded is seen") {
  const Mutation off = in_pressure("0.06 mmHg too high", [](std::vector<double>& pressure) {
    // more than the link rounds
    for (double& p : pressure) { p += 0.06 * pascals_per_mmhg; }
  });
  check_red(off, {"clinical/round-trip"});
  const Mutation late = in_pressure("two frame periods late", [](std::vector<double>& pressure) {
    std::shift_right(pressure.begin(), pressure.end(), 17);  // ticks of 1 ms
  });
  check_red(late, {"clinical/round-trip"});
}

TEST("a pressure that never falls loses its event") {
  const Mutation fault = in_pressure("never falls", [](std::vector<double>& pressure) {
    for (std::size_t n = 1; n < pressure.size(); ++n) {
      pressure[n] = std::max(pressure[n], pressure[n - 1]);
    }
  });
  check_red(fault, {"clinical/detection", "clinical/verdicts", "clinical/features/closed-form",
                    "clinical/blind-spots", "clinical/round-trip"});
}

TEST("a pressure that fades on its own raises false alarms") {
  const Mutation fault = in_pressure("gone after 15 s", [](std::vector<double>& pressure) {
    for (std::size_t n = pressure.size() / 2; n < pressure.size(); ++n) { pressure[n] *= 0.05; }
  });
  check_red(fault, {"clinical/detection"});
}

TEST("a fall that a first-order lag draws out is seen") {
  const Mutation fault = in_pressure("lagging", [](std::vector<double>& pressure) {
    for (std::size_t n = 1; n < pressure.size(); ++n) {
      pressure[n] = pressure[n - 1] + 0.02 * (pressure[n] - pressure[n - 1]);
    }
  });
  check_red(fault,
            {"clinical/verdicts", "clinical/features/closed-form", "clinical/measures/filter"});
}

TEST("a sample that is not a number is never rated well") {
  const Mutation fault = in_pressure(
      "NaN", [](std::vector<double>& pressure) { pressure[pressure.size() / 2] = std::nan(""); });
  check_status("clinical/measures/filter", &fault, Status::fail);
  check_red(fault, {"clinical/round-trip"});
  check_status("clinical/measures/fault-table", &fault, Status::error);  // a rating refuses it
}

// Tests that faults planted in the simulation of a calibration fail its cases.

TEST("a needle that cuts the flavum with two thirds of its force makes intervals miss the truth") {
  const Mutation fault{.name = "flavum cut by 2/3", .model = [](Scene& scene, SpringNetwork&) {
                         for (Material& material : scene.materials) {
                           if (material.name == "flavum") { material.cutting_force *= 2.0 / 3.0; }
                         }
                       }};
  check_red(fault, {"clinical/calibration/coverage"});
}

TEST("a pressure of nine tenths makes intervals of the thumb's force miss it") {
  const Mutation fault = in_pressure("gain -10 %", [](std::vector<double>& pressure) {
    for (double& p : pressure) { p *= 0.9; }
  });
  check_red(fault, {"clinical/calibration/coverage"});
}

#ifndef PALPATE_SANITIZED  // tests bounds; takes half a minute
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
