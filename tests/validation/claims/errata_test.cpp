// SPDX-License-Identifier: MIT

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "tests/check.hpp"
#include "tests/validation/planted_faults.hpp"
#include "validation/claims/groups.hpp"

namespace {

using namespace palpate;

const std::vector<std::string>& names() {
  static const std::vector<std::string> all{
      "errata/sign",         "errata/reversed",        "errata/direction",  "errata/half-force",
      "errata/no-time-step", "errata/lagged-velocity", "errata/all-printed"};
  return all;
}

Outcome outcome_of(const std::string& name, const Mutation* mutation) {
  const std::vector<Case> cases = errata_cases();
  const auto found = std::ranges::find(cases, name, &Case::name);
  if (found == cases.end()) {
    return {.name = name, .status = Status::error, .reasons = {"no case"}};
  }
  return run_case(*found, {.quick = true, .mutation = mutation});
}

/// The longest case also covers every kind of fault, but not in every run, since it costs as much
/// as all others.
enum class Lagged { measured, left_out };

void check_caught(const Mutation& mutation, Lagged lagged = Lagged::left_out) {
  for (const std::string& name : tried(std::span<const std::string>(names()))) {
    if (name == "errata/lagged-velocity" && lagged == Lagged::left_out) { continue; }
    const Status status = outcome_of(name, &mutation).status;
    if (status != Status::fail) {
      std::printf("  %s: %s with \"%s\"\n", name.c_str(), name_of(status).data(),
                  mutation.name.c_str());
    }
    CHECK(status == Status::fail);
  }
}

TEST("every erratum does what its equations predict, and the summary has a line for each") {
  const Outcome summary = outcome_of("errata/summary", nullptr);
  CHECK(summary.status == Status::pass);
  REQUIRE(summary.tables.size() == 1);
  CHECK(summary.tables[0].rows.size() == names().size());
}

TEST("a damper that feeds energy in turns every case red") {
  check_caught({.name = "sign of damping", .model = [](Scene&, SpringNetwork& network) {
                  network.springs.change_each([&](Spring& spring) { spring.viscosity *= -1.0; });
                }});
}

TEST("a stiffness that is 1 % too high turns every case red") {
  check_caught(
      {.name = "stiffness + 1 %",
       .model =
           [](Scene&, SpringNetwork& network) {
             network.springs.change_each([&](Spring& spring) { spring.stiffness *= 1.01; });
           }},
      Lagged::measured);
}

TEST("a missing spring turns every case red") {
  check_caught({.name = "missing spring", .model = [](Scene&, SpringNetwork& network) {
                  network.springs.edit([&](std::vector<Spring>& all) { all.erase(all.begin()); });
                }});
}

TEST("a step taken with twice its length turns every case red") {
  check_caught({.name = "step twice", .step_twice = true});
}

TEST("one coordinate that is not a number turns every case red") {
  check_caught({.name = "NaN",
                .trace =
                    [](Trace& motion) {
                      motion.position(0, motion.position.cols() / 2) =
                          std::numeric_limits<double>::quiet_NaN();
                    }},
               Lagged::measured);
}

/// Most important faults: an erratum that is switched on without effect, or has an effect when it
/// is off.
TEST("an erratum that is ignored turns its case red") {
  const Mutation ignored{.name = "corrected after all", .model = [](Scene& scene, SpringNetwork&) {
                           scene.simulation.printed = {};
                         }};
  check_caught(ignored, Lagged::measured);
}

TEST("a half force where none is asked for turns every case red") {
  check_caught({.name = "always half", .model = [](Scene& scene, SpringNetwork&) {
                  scene.simulation.printed.half_force = true;
                }});
}

}  // namespace
