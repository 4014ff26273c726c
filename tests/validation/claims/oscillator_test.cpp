// SPDX-License-Identifier: MIT

#include "tests/validation/planted_faults.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using Names = std::vector<std::string>;

/// Names "<check>/<scheme>" of all schemes, or of the explicit ones.
Names of_every_scheme(const std::string& check, bool with_implicit = true) {
  Names names;
  for (const std::string scheme :
       {"euler", "euler-cromer", "feynman-newton", "feynman-newton-printed", "leapfrog",
        "velocity-verlet", "rk4", "implicit-euler", "implicit-midpoint"}) {
    if (!with_implicit && scheme.starts_with("implicit")) { continue; }
    names.push_back(check + "/" + scheme);
  }
  return names;
}

Names joined(const std::vector<Names>& lists) {
  Names all;
  for (const Names& list : lists) { all.insert(all.end(), list.begin(), list.end()); }
  return all;
}

const Names single_cases{"regimes",  "figure-6",  "figure-7",       "figure-8",
                         "figure-9", "figure-10", "who-is-closest", "sweep"};

TEST("each contracted case exists and every one passes as it is") {
  const Names names = joined({single_cases, of_every_scheme("order"), of_every_scheme("discrete"),
                              of_every_scheme("stability-limit")});
  CHECK(select_cases(all_cases(), Names{"oscillator"}, true).size() == names.size());
  for (const std::string& name : names) { check_green("oscillator/" + name); }
}

TEST("every planted fault fails the cases of the oscillator") {
  const Names everywhere = joined({of_every_scheme("order"), of_every_scheme("discrete"),
                                   of_every_scheme("stability-limit", false), single_cases});
  const Mutation cut{.name = "half of the samples", .trace = [](Trace& motion) {
                       const Eigen::Index half = motion.position.cols() / 2;
                       motion.position.conservativeResize(Eigen::NoChange, half);
                       motion.velocity.conservativeResize(Eigen::NoChange, half);
                       motion.time.resize(static_cast<std::size_t>(half));
                     }};
  check_red(
      "oscillator/",
      {{reversed_damping(), everywhere},
       {double_steps(), everywhere},
       {stiffer(), everywhere},
       {not_a_number(),
        joined(
            {everywhere, {"stability-limit/implicit-euler", "stability-limit/implicit-midpoint"}})},
       // Stability cases and first-order cases are excluded: a stability limit does not
       // depend on sample times, and a first-order error hides a fault of the same size.
       {late_frames(),
        joined({of_every_scheme("discrete"),
                {"order/leapfrog", "order/velocity-verlet", "order/rk4", "order/implicit-midpoint"},
                single_cases})},
       {cut, everywhere}});
}

TEST("two runs of a case give the same numbers") {
  for (const std::string name : {"oscillator/order/rk4", "oscillator/stability-limit/leapfrog",
                                 "oscillator/who-is-closest"}) {
    const Names pattern{name};
    const Case one = select_cases(all_cases(), pattern, true).front();
    const Outcome first = run_case(one, {.quick = true});
    const Outcome second = run_case(one, {.quick = true});
    REQUIRE(first.quantities.size() == second.quantities.size());
    for (std::size_t n = 0; n < first.quantities.size(); ++n) {
      CHECK_NEAR(first.quantities[n].value, second.quantities[n].value, 1e-300);
    }
    CHECK(first.notes == second.notes);
  }
}

}  // namespace PALPATE_FILE
