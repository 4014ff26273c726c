// SPDX-License-Identifier: MIT
/// Faults planted in what is compared must turn the verdicts of group "clinical" red; without a fault the
/// same cases are green.

#include <algorithm>
#include <cmath>

#include "model/dynamics/pressure_units.hpp"
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
  const Mutation fault{.name = "every second sample held", .pressure = [](std::vector<double>& pressure) {
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
  check_red(fault, {"clinical/verdicts", "clinical/subjects/corridor", "clinical/subjects/bootstrap"});
}

TEST("a trace one sample late is seen") {
  const Mutation fault{.name = "one sample late", .pressure = [](std::vector<double>& pressure) {
                         for (std::size_t n = pressure.size() - 1; n > 0; --n) {
                           pressure[n] = pressure[n - 1];
                         }
                       }};
  check_red(fault,
            {"clinical/measures/fault-table", "clinical/measures/filter", "clinical/features/closed-form"});
}

TEST("a simulated pressure that is not the one that was recorded is seen") {
  const Mutation off{.name = "0.06 mmHg too high", .pressure = [](std::vector<double>& pressure) {
                       // more than the link rounds
                       for (double& p : pressure) { p += 0.06 * pascals_per_mmhg; }
                     }};
  check_red(off, {"clinical/round-trip"});
  const Mutation late{.name = "two frame periods late", .pressure = [](std::vector<double>& pressure) {
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
  check_red(fault, {"clinical/verdicts", "clinical/features/closed-form", "clinical/measures/filter"});
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
