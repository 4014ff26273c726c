// SPDX-License-Identifier: MIT

#include "model/problem/recording.hpp"
#include "tests/validation/planted_faults.hpp"

namespace PALPATE_FILE {

using namespace palpate;

Mutation in_pressure(std::string name, std::function<void(std::vector<double>&)> change) {
  return {.name = std::move(name), .trace = [change](Trace& trace) {
            if (trace.find("syringe.pressure_pa") != nullptr) {
              change(trace.values("syringe.pressure_pa"));
            }
          }};
}

Mutation gain(const std::string& name, double factor) {
  return in_pressure("pressure " + name, [factor](std::vector<double>& pressure) {
    for (double& p : pressure) { p *= factor; }
  });
}

Mutation late(const std::string& name, std::ptrdiff_t samples) {
  return in_pressure("pressure late by " + name, [samples](std::vector<double>& pressure) {
    std::shift_right(pressure.begin(), pressure.end(), samples);
  });
}

const Mutation no_number = in_pressure(
    "NaN", [](std::vector<double>& pressure) { pressure[pressure.size() / 2] = quiet_nan; });

TEST("every fault planted in a pressure fails the cases that compare it") {
  // With every second sample repeated the noise has another colour, and uncertainties are wrong.
  const Mutation repeated = in_pressure("samples repeated", [](std::vector<double>& pressure) {
    for (std::size_t n = 1; n < pressure.size(); n += 2) { pressure[n] = pressure[n - 1]; }
  });
  const Mutation offset = in_pressure("0.06 mmHg too high", [](std::vector<double>& pressure) {
    // more than the link rounds
    for (double& p : pressure) { p += 0.06 * pascals_per_mmhg; }
  });
  const Mutation monotone = in_pressure("never falls", [](std::vector<double>& pressure) {
    for (std::size_t n = 1; n < pressure.size(); ++n) {
      pressure[n] = std::max(pressure[n], pressure[n - 1]);
    }
  });
  // A pressure that fades without a loss of resistance raises false alarms.
  const Mutation faded =
      in_pressure("fades after half the time", [](std::vector<double>& pressure) {
        for (std::size_t n = pressure.size() / 2; n < pressure.size(); ++n) { pressure[n] *= 0.05; }
      });
  const Mutation lagging = in_pressure("first-order lag", [](std::vector<double>& pressure) {
    for (std::size_t n = 1; n < pressure.size(); ++n) {
      pressure[n] = pressure[n - 1] + 0.02 * (pressure[n] - pressure[n - 1]);
    }
  });
  check_red(
      "clinical/",
      {{gain("+3 %", 1.03),
        {"measures/closed-forms", "measures/fault-table", "measures/filter",
         "features/closed-form"}},
       {repeated, {"features/uncertainty"}},
       {gain("+50 %", 1.5), {"verdicts", "subjects/corridor", "subjects/bootstrap"}},
       {late("one sample", 1), {"measures/fault-table", "measures/filter", "features/closed-form"}},
       {offset, {"round-trip"}},
       {late("two frame periods", 17), {"round-trip"}},  // ticks of 1 ms
       {monotone, {"detection", "verdicts", "features/closed-form", "blind-spots", "round-trip"}},
       {faded, {"detection"}},
       {lagging, {"verdicts", "features/closed-form", "measures/filter"}},
       {no_number, {"measures/filter", "round-trip"}}});
}

TEST("a rating refuses a sample that is not a number") {
  check_status("clinical/measures/fault-table", &no_number, Status::error);
}

TEST("every fault planted in the simulation of a calibration fails its cases") {
  // Intervals miss the true cutting force of the flavum.
  const Mutation flavum{.name = "flavum cut with 2/3 of its force",
                        .model = [](Scene& scene, SpringNetwork&) {
                          for (Material& material : scene.materials) {
                            if (material.name == "flavum") { material.cutting_force *= 2.0 / 3.0; }
                          }
                        }};
  // A thumb that never presses harder hides the difference between the groups.
  const Mutation thumb{.name = "thumb at 11 N", .model = [](Scene& scene, SpringNetwork&) {
                         if (scene.syringe) { scene.syringe->thumb_force = 11.0; }
                       }};
  check_red("clinical/calibration/",
            {{flavum, {"coverage"}}, {gain("-10 %", 0.9), {"coverage"}}, {thumb, {"groups"}}});
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

}  // namespace PALPATE_FILE
