// SPDX-License-Identifier: MIT

#include "tests/validation/planted_faults.hpp"

namespace PALPATE_FILE {

using namespace palpate;

TEST("every erratum does what its equations predict, and the summary has a line for each") {
  const std::vector<std::string> name{"errata/summary"};
  const Outcome summary = run_case(select_cases(all_cases(), name, true).front(), {.quick = true});
  CHECK(summary.status == Status::pass);
  REQUIRE(summary.tables.size() == 1);
  CHECK(summary.tables[0].rows.size() == 7);
}

TEST("every planted fault fails the case of each erratum") {
  const std::vector<std::string> most{"sign",       "reversed",     "direction",
                                      "half-force", "no-time-step", "all-printed"};
  // This case costs as much as all others together, so not every fault runs it.
  std::vector<std::string> all = most;
  all.emplace_back("lagged-velocity");
  // Most important faults: an erratum that is switched on without effect, or has an effect when it
  // is off.
  const Mutation corrected{.name = "erratum ignored", .model = [](Scene& scene, SpringNetwork&) {
                             scene.simulation.printed = {};
                           }};
  const Mutation halved{.name = "half force always", .model = [](Scene& scene, SpringNetwork&) {
                          scene.simulation.printed.half_force = true;
                        }};
  check_red("errata/", {{reversed_damping(), most},
                        {stiffer(), all},
                        {missing_spring(), most},
                        {double_steps(), most},
                        {not_a_number(), all},
                        {corrected, all},
                        {halved, most}});
}

}  // namespace PALPATE_FILE
