// SPDX-License-Identifier: MIT
/// A gate that cries wolf is switched off: the same code against itself, in orders of summation that the
/// baseline has not seen.

#include "validation/cases/gate_parts.hpp"
#include "validation/cases/gate_sample.hpp"
#include "validation/gate/gate.hpp"

namespace palpate::gating {

namespace {

constexpr int comparisons = 200;
constexpr std::uint64_t first_seed = 1000;  ///< none of those that told the spread

void measure(const CaseContext& context, Outcome& outcome) {
  const Study study = block_study();
  const gate::Baseline baseline = accepted(context, study);
  int alarms = 0;
  int rounded = 0;
  for (int n = 0; n < comparisons; ++n) {
    const CaseContext other = in_order(context, first_seed + static_cast<std::uint64_t>(n));
    const gate::Verdict verdict = gate::judge(baseline, {.outcomes = {outcome_of(other, study)}});
    alarms += verdict.holds() ? 0 : 1;
    rounded += verdict.tally().identical == 0 ? 1 : 0;
  }
  const gate::Verdict again = gate::judge(baseline, {.outcomes = {outcome_of(context, study)}});
  outcome.judge({.name = "identical_again",
                 .value = static_cast<double>(again.tally().identical),
                 .lower = 1.0,
                 .upper = 1.0,
                 .bound_from = "the same run gives the same bits"});
  outcome.judge({.name = "alarms",
                 .value = static_cast<double>(alarms),
                 .upper = 0.0,
                 .bound_from = "nothing but the order of sums differs"});
  outcome.judge({.name = "rounded_otherwise",
                 .value = static_cast<double>(rounded),
                 .lower = 0.5 * comparisons,
                 .bound_from = "a comparison of equal bits would show nothing"});
}

}  // namespace

Case self_case() {
  return {.name = "gate/self",
          .suite = "model",
          .claim = "A model held against itself 200 times, its sums in another order each time, never falls.",
          .measure = measure,
          .weight = 2.0};
}

}  // namespace palpate::gating
