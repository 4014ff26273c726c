// SPDX-License-Identifier: MIT
/// How often the published rule finds a loss of resistance, and finds one where there is none.
#include <cmath>

#include "validation/cases/clinical_parts.hpp"
#include "validation/cases/clinical_traces.hpp"
#include "validation/comparison/loss_of_resistance.hpp"
#include "validation/comparison/statistics.hpp"
#include "validation/comparison/zero_phase.hpp"

namespace palpate::clinical {

namespace {

using namespace comparison;

struct Count {
  std::size_t found = 0;
  std::size_t trials = 0;
  [[nodiscard]] double share() const { return static_cast<double>(found) / static_cast<double>(trials); }
};

Count count_found(const CaseContext& context, const Insertions& kind, std::uint64_t first_seed) {
  Count count{.trials = context.quick ? 100U : 250U};
  for (std::size_t n = 0; n < count.trials; ++n) {
    Samples pressure = seeded_insertion(kind, first_seed + n);
    damage(context, pressure.value);
    count.found += find_loss(zero_phase(pressure, 20.0)).found() ? 1 : 0;
  }
  return count;
}

void add_row(Table& table, const std::string& what, const Count& count) {
  const Interval interval = share_interval(count.found, count.trials);
  table.rows.push_back(
      {what, static_cast<double>(count.trials), count.share(), interval.lower, interval.upper});
}

/// What four deviations of filtered noise on a plateau take from the drop of the smallest peak.
double lost_to_noise() {
  return 4.0 * noise_deviation * std::sqrt(noise_shares(20.0, sample_rate).passed) / smallest_peak;
}

/// Those whose drop, drawn from a normal distribution, is at least the threshold are found.
void judge_share(Outcome& outcome, const std::string& name, const Insertions& kind, const Count& count) {
  const double over = (LossRule{}.least_drop - kind.mean_drop) / kind.deviation_drop;
  const double most = normal_above(over);
  const double least = normal_above(over + lost_to_noise() / kind.deviation_drop);
  outcome.judge({.name = name,
                 .value = count.share(),
                 .lower = expected_share(least, count.trials).lower,
                 .upper = expected_share(most, count.trials).upper,
                 .bound_from = "binomial, 0.999, about the share of the distribution above the threshold, and "
                               "above it by four deviations of the noise"});
}

/// Not one: the rule must leave them out for what they are, so any is a fault of the code.
void judge_none(Outcome& outcome, const std::string& name, const Count& count) {
  outcome.judge({.name = name,
                 .value = static_cast<double>(count.found),
                 .upper = 0.0,
                 .bound_from = "the rule: nothing that comes back within 5 s; 0 of " +
                               std::to_string(count.trials) + " leaves at most " +
                               std::to_string(100.0 * share_interval(0, count.trials).upper).substr(0, 4) +
                               " %"});
}

Figure examples() {
  using enum Technique;
  Figure figure{.id = "examples",
                .title = "Made-up insertions",
                .caption = "One of each kind, as drawn from its seed.",
                .x = {.label = "time (s)"},
                .y = {.label = "pressure (mmHg)"}};
  const auto add = [&](const std::string& label, const Insertions& kind, std::uint64_t seed) {
    const Samples pressure = seeded_insertion(kind, seed);
    figure.series.push_back({.label = label});
    for (std::size_t n = 0; n < pressure.size(); ++n) {
      figure.series.back().x.push_back(pressure.time(n));
      figure.series.back().y.push_back(pressure.value[n] / pascals_per_mmhg);
    }
  };
  add("true, continuous", {}, 1);
  add("true, intermittent", {.technique = intermittent}, 10001);
  add("false, comes back", {.mean_drop = 0.33, .held = false}, 20002);
  return figure;
}

void measure_detection(const CaseContext& context, Outcome& outcome) {
  using enum Technique;
  Table table{.id = "detection",
              .title = "Loss of resistance found",
              .caption =
                  "Made-up insertions, 30 s at 120 Hz, noise of 5 mmHg; drops from normal distributions with "
                  "the published means (73 % true, 33 % false) and 18 %, which puts 10 % of true ones under "
                  "half. 95 % Clopper-Pearson.",
              .columns = {"insertions", "number", "share found", "lower", "upper"}};
  const auto add = [&](const std::string& what, const Insertions& kind, std::uint64_t seed) {
    const Count count = count_found(context, kind, seed);
    add_row(table, what, count);
    return count;
  };
  const Insertions true_one{};
  const Insertions true_pushed{.technique = intermittent};
  const Insertions false_held{.mean_drop = 0.33};
  judge_share(outcome, "sensitivity_continuous", true_one, add("true, continuous", true_one, 1));
  judge_share(outcome, "sensitivity_intermittent", true_pushed,
              add("true, intermittent", true_pushed, 10001));
  judge_none(outcome, "false_alarms_of_falls_that_come_back",
             add("false, comes back", {.mean_drop = 0.33, .held = false}, 20001));
  judge_none(outcome, "false_alarms_of_deep_falls_that_come_back",
             add("deep, comes back", {.mean_drop = 0.73, .held = false}, 30001));
  judge_none(outcome, "false_alarms_of_pushes",
             add("pushes without any loss", {.technique = intermittent, .drops = false}, 40001));
  judge_none(outcome, "false_alarms_of_no_fall", add("pressure that stays", {.drops = false}, 50001));
  judge_share(outcome, "false_alarms_of_falls_that_are_held", false_held,
              add("false, but held", false_held, 60001));
  outcome.tables.push_back(std::move(table));
  outcome.figures.push_back(examples());
  outcome.notes.push_back(
      "A false loss that is held for 5 s cannot be told from a true one by pressure alone: "
      "about a third of them lie above the threshold.");
}

}  // namespace

std::vector<Case> detection_cases() {
  return {{.name = "clinical/detection",
           .suite = "clinical",
           .claim = "The rule finds the losses that drop by more than its threshold, and no push of a thumb.",
           .measure = measure_detection,
           .weight = 1.0}};
}

}  // namespace palpate::clinical
