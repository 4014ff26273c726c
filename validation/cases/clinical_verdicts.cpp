// SPDX-License-Identifier: MIT
/// A recording against copies of itself with one fault each: what every measure sees of it, and the verdict.
#include <algorithm>
#include <iterator>

#include "validation/cases/clinical_parts.hpp"
#include "validation/cases/clinical_traces.hpp"
#include "validation/comparison/feature_verdict.hpp"

namespace palpate::clinical {

namespace {

using namespace comparison;

struct Trial {
  std::string name{};
  std::vector<double> simulated{};
  ComparisonOptions options{};
  std::vector<Verdict> right{};
  std::string why{};
};

std::vector<double> scaled(std::vector<double> values, double gain, double offset) {
  for (double& v : values) { v = gain * v + offset; }
  return values;
}

/// Faults of size: the tolerance of the peak is 10.2 %, that of the plateau 7 mmHg.
std::vector<Trial> faults_of_size(const std::vector<double>& same) {
  using enum Verdict;
  const std::vector<Verdict> fine{agrees, not_distinguishable};
  const std::string peak = "tolerance of the peak 10.2 %";
  const std::string plateau = "tolerance of the plateau 7 mmHg";
  return {{"unchanged", same, {}, fine, "the same law, and the recording's noise"},
          {"gain +5 %", scaled(same, 1.05, 0.0), {}, fine, peak},
          {"gain +20 %", scaled(same, 1.2, 0.0), {}, {differs}, peak},
          {"offset +2 mmHg", scaled(same, 1.0, 2.0 * pascals_per_mmhg), {}, fine, plateau},
          {"offset +12 mmHg", scaled(same, 1.0, 12.0 * pascals_per_mmhg), {}, {differs}, plateau}};
}

std::vector<Trial> faults_of_the_event(const std::vector<double>& time) {
  using enum Verdict;
  const PressureLaw law;
  const std::vector<double> late = pressures({.delay = 1.0}, time);
  ComparisonOptions by_start;
  by_start.alignment = AlignmentRule::start;
  return {{"delay 1 s, clocks shared", late, by_start, {differs}, "tolerance of times 0.5 s"},
          {"delay 1 s, clocks apart", late, {}, {agrees, not_distinguishable},
           "aligned by the event; the lag is reported"},
          {"drop 5x slower", pressures({.fall_constant = 5.0 * law.fall_constant}, time), {}, {differs},
           "tolerance of the drop time: a factor of 2"},
          {"no loss of resistance", pressures({.plateau = law.peak}, time), {}, {differs}, "no event"},
          {"false loss, 33 %", pressures({.plateau = 0.67 * law.peak}, time), {}, {differs},
           "no drop of 40 %"}};
}

std::vector<Trial> trials(const std::vector<double>& time) {
  const std::vector<double> same = pressures({}, time);
  ComparisonOptions pump;
  pump.simulated_regime = Recording::Regime::pump;
  std::vector<Trial> all = faults_of_size(same);
  std::ranges::move(faults_of_the_event(time), std::back_inserter(all));
  const std::vector<double> constant(time.size(), 30.0 * pascals_per_mmhg);
  all.push_back({"constant", constant, {}, {Verdict::not_comparable}, "nothing happens in it"});
  all.push_back({"pump instead of thumb", same, pump, {Verdict::not_comparable},
                 "two regimes of pressure are never compared"});
  return all;
}

Figure figure_of(const std::vector<double>& time, const std::vector<double>& recorded) {
  Figure figure{.id = "traces",
                .title = "A recording and faults of a simulation",
                .caption = "Recorded with noise of 1 mmHg; each copy has one fault.",
                .x = {.label = "time (s)"},
                .y = {.label = "pressure (mmHg)"}};
  const auto add = [&](const std::string& label, const std::vector<double>& pressure) {
    figure.series.push_back({.label = label, .x = time, .y = scaled(pressure, 1.0 / pascals_per_mmhg, 0.0)});
  };
  add("recorded", recorded);
  for (const Trial& trial : faults_of_the_event(time)) {
    if (trial.name != "delay 1 s, clocks apart") { add(trial.name, trial.simulated); }
  }
  return figure;
}

std::vector<Cell> row_of(const Trial& trial, const Comparison& c) {
  const double none = not_measured;
  return {trial.name,
          c.errors.samples > 0 ? c.errors.nrmse : none,
          c.errors.samples > 0 ? c.errors.magnitude : none,
          c.errors.samples > 0 ? c.errors.phase : none,
          c.rating ? c.rating->overall : none,
          c.alignment.lag,
          std::string(name_of(c.verdict)),
          c.reasons.empty() ? std::string() : c.reasons.front()};
}

void measure_verdicts(const CaseContext& context, Outcome& outcome) {
  const std::vector<double> time = instants(14.0, 120.0);
  std::vector<double> noisy = pressures({}, time);
  device::Seeded seeded(20);
  add_noise(noisy, pascals_per_mmhg, seeded);
  const Recording recording = recording_of(time, noisy);
  Table table{.id = "verdicts",
              .title = "One fault at a time",
              .caption =
                  "Ratings follow the whole trace, the verdict follows features with tolerances. Noise of "
                  "1 mmHg on the recording.",
              .columns = {"fault", "NRMSE", "Sprague-Geers M", "Sprague-Geers P", "ISO rating", "lag (s)",
                          "verdict", "first reason"}};
  for (Trial& trial : trials(time)) {
    damage(context, trial.simulated);
    const Comparison found = compare(recording, trace_of(time, trial.simulated), trial.options);
    table.rows.push_back(row_of(trial, found));
    const bool right = std::ranges::find(trial.right, found.verdict) != trial.right.end();
    outcome.judge({.name = "right_verdict: " + trial.name,
                   .value = right ? 1.0 : 0.0,
                   .lower = 1.0,
                   .upper = 1.0,
                   .bound_from = trial.why});
  }
  outcome.figures.push_back(figure_of(time, noisy));
  outcome.tables.push_back(std::move(table));
}

/// A gate on a rating would let these through.
void measure_blindness(const CaseContext& context, Outcome& outcome) {
  const std::vector<double> time = instants(14.0, 120.0);
  const PressureLaw law;
  const std::vector<double> same = pressures(law, time);
  const auto against = [&](std::vector<double> simulated) {
    damage(context, simulated);
    return compare(recording_of(time, same), trace_of(time, std::move(simulated)));
  };
  const Comparison slow = against(pressures({.fall_constant = 5.0 * law.fall_constant}, time));
  outcome.judge({.name = "iso_rating_of_a_drop_5x_slower",
                 .value = slow.rating ? slow.rating->overall : not_measured,
                 .lower = 0.80,
                 .bound_from = "ISO/TS 18571 calls more than 0.80 good: blind to the event"});
  const Tolerance peak = tolerance_of(Feature::peak, {});
  outcome.judge({.name = "sprague_geers_of_a_drop_5x_slower", .value = slow.errors.combined,
                 .upper = peak.relative,
                 .bound_from = "the tolerance of the peak, 10.2 %: a gate of that width on the measure would "
                               "let it pass"});
  const Comparison loud = against(scaled(same, 1.2, 0.0));
  outcome.judge({.name = "sprague_geers_phase_of_a_gain", .value = loud.errors.phase, .upper = 1e-7,
                 .bound_from = "theory: a factor has no phase (arc cosine of 1 to rounding)"});
  const Comparison late = against(pressures({.delay = 1.0}, time));
  outcome.judge({.name = "reported_lag_of_a_delay", .value = late.alignment.lag, .unit = "s",
                 .lower = -1.0 - 1.0 / 120.0, .upper = -1.0 + 1.0 / 120.0,
                 .bound_from = "the delay that was put in, to one sample"});
}

}  // namespace

std::vector<Case> verdict_cases() {
  return {
      {.name = "clinical/verdicts",
       .suite = "clinical",
       .claim =
           "Every fault beyond its tolerance is called a difference, noise and small ones are not, and what "
           "cannot be compared is not.",
       .measure = measure_verdicts,
       .weight = 0.3},
      {.name = "clinical/blind-spots",
       .suite = "clinical",
       .claim = "Measures of whole traces call a fall that is five times too slow good; they may not judge.",
       .measure = measure_blindness,
       .weight = 0.1}};
}

}  // namespace palpate::clinical
