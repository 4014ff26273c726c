// SPDX-License-Identifier: MIT
/// Comparison of a recording with copies that have one fault each: values of every measure, and the
/// verdict.

#include <iterator>

#include "device/pressure_link/frame.hpp"
#include "validation/claims/clinical_fixture.hpp"
#include "validation/claims/groups.hpp"
#include "validation/claims/tool_fixture.hpp"
#include "validation/comparison/group_comparison.hpp"
#include "validation/comparison/link_recording.hpp"

namespace palpate::clinical {

namespace {

using namespace comparison;

struct Trial {
  std::string name{};
  std::vector<double> simulated{};
  ComparisonOptions options{};
  std::vector<Status> right{};
  std::string why{};
};

std::vector<double> scaled(std::vector<double> values, double gain, double offset) {
  for (double& v : values) { v = gain * v + offset; }
  return values;
}

/// Faults of size: the tolerance of the peak is 10.2 %, that of the plateau 7 mmHg.
std::vector<Trial> faults_of_size(const std::vector<double>& same) {
  const std::vector<Status> fine{Status::pass, Status::inconclusive};
  const std::string peak = "tolerance of the peak 10.2 %";
  const std::string plateau = "tolerance of the plateau 7 mmHg";
  return {
      {"unchanged", same, {}, fine, "the same law, and the recording's noise"},
      {"gain +5 %", scaled(same, 1.05, 0.0), {}, fine, peak},
      {"gain +20 %", scaled(same, 1.2, 0.0), {}, {Status::fail}, peak},
      {"offset +2 mmHg", scaled(same, 1.0, 2.0 * pascals_per_mmhg), {}, fine, plateau},
      {"offset +12 mmHg", scaled(same, 1.0, 12.0 * pascals_per_mmhg), {}, {Status::fail}, plateau}};
}

std::vector<Trial> faults_of_the_event(const std::vector<double>& time) {
  const PressureLaw law;
  const std::vector<double> late = pressures({.delay = 1.0}, time);
  ComparisonOptions by_start;
  by_start.alignment = AlignmentRule::start;
  return {{"delay 1 s, clocks shared", late, by_start, {Status::fail}, "tolerance of times 0.5 s"},
          {"delay 1 s, clocks apart",
           late,
           {},
           {Status::pass, Status::inconclusive},
           "aligned by the event; the lag is reported"},
          {"drop 5x slower",
           pressures({.fall_constant = 5.0 * law.fall_constant}, time),
           {},
           {Status::fail},
           "tolerance of the drop time: a factor of 2"},
          {"no loss of resistance",
           pressures({.plateau = law.peak}, time),
           {},
           {Status::fail},
           "no event"},
          {"false loss, 33 %",
           pressures({.plateau = 0.67 * law.peak}, time),
           {},
           {Status::fail},
           "no drop of 40 %"}};
}

std::vector<Trial> trials(const std::vector<double>& time) {
  const std::vector<double> same = pressures({}, time);
  ComparisonOptions pump;
  pump.simulated_regime = Recording::Regime::pump;
  std::vector<Trial> all = faults_of_size(same);
  std::ranges::move(faults_of_the_event(time), std::back_inserter(all));
  const std::vector<double> constant(time.size(), 30.0 * pascals_per_mmhg);
  all.push_back({"constant", constant, {}, {Status::error}, "nothing happens in it"});
  all.push_back({"pump instead of thumb",
                 same,
                 pump,
                 {Status::error},
                 "two regimes of pressure are never compared"});
  return all;
}

Figure figure_of(const std::vector<double>& time, const std::vector<double>& recorded) {
  Figure figure = plot("traces", "A recording and faults of a simulation",
                       "Recorded with noise of 1 mmHg; each copy has one fault.", {"time (s)"},
                       {"pressure (mmHg)"});
  const auto add = [&](const std::string& label, const std::vector<double>& pressure) {
    figure.add(label, time, scaled(pressure, 1.0 / pascals_per_mmhg, 0.0));
  };
  add("recorded", recorded);
  for (const Trial& trial : faults_of_the_event(time)) {
    if (trial.name != "delay 1 s, clocks apart") { add(trial.name, trial.simulated); }
  }
  return figure;
}

void measure_verdicts(const CaseContext& context, Outcome& outcome) {
  const std::vector<double> time = instants(14.0, 120.0);
  std::vector<double> noisy = pressures({}, time);
  device::Seeded seeded(20);
  add_noise(noisy, pascals_per_mmhg, seeded);
  const Recording recording = recording_of(time, noisy);
  Table& table =
      outcome.table("verdicts", "One fault at a time",
                    "Ratings follow the trace, the verdict follows features. Noise of 1 mmHg.",
                    {"fault", "NRMSE", "Sprague-Geers M", "Sprague-Geers P", "ISO rating",
                     "lag (s)", "verdict", "first reason"});
  for (Trial& trial : trials(time)) {
    damage(context, trial.simulated);
    const Comparison found = compare(recording, trace_of(time, trial.simulated), trial.options);
    const bool sampled = found.errors.samples > 0;
    table.rows.push_back(
        {trial.name, sampled ? found.errors.nrmse : not_measured,
         sampled ? found.errors.magnitude : not_measured,
         sampled ? found.errors.phase : not_measured,
         found.rating ? found.rating->overall : not_measured, found.alignment.lag,
         verdict_word(found.outcome.status),
         found.outcome.reasons.empty() ? std::string() : found.outcome.reasons.front()});
    const bool right = std::ranges::find(trial.right, found.outcome.status) != trial.right.end();
    outcome.judge_equal("right_verdict: " + trial.name, right ? 1.0 : 0.0, 1.0, trial.why);
  }
  outcome.figures.push_back(figure_of(time, noisy));
}

/// Faults that a limit on a rating would not detect.
void measure_blindness(const CaseContext& context, Outcome& outcome) {
  const std::vector<double> time = instants(14.0, 120.0);
  const PressureLaw law;
  const std::vector<double> same = pressures(law, time);
  const auto against = [&](std::vector<double> simulated) {
    damage(context, simulated);
    return compare(recording_of(time, same), trace_of(time, std::move(simulated)));
  };
  const Comparison slow = against(pressures({.fall_constant = 5.0 * law.fall_constant}, time));
  outcome.judge_at_least("iso_rating_of_a_drop_5x_slower",
                         slow.rating ? slow.rating->overall : not_measured, 0.80,
                         "ISO/TS 18571 calls more than 0.80 good: blind to the event");
  const Tolerance peak = tolerance_of(Feature::peak, {});
  outcome.judge_at_most(
      "sprague_geers_of_a_drop_5x_slower", slow.errors.combined, peak.relative,
      "the tolerance of the peak, 10.2 %: a gate of that width on the measure would let it pass");
  const Comparison loud = against(scaled(same, 1.2, 0.0));
  outcome.judge_at_most("sprague_geers_phase_of_a_gain", loud.errors.phase, 1e-7,
                        "theory: a factor has no phase (arc cosine of 1 to rounding)");
  const Comparison late = against(pressures({.delay = 1.0}, time));
  outcome.judge_near("reported_lag_of_a_delay", late.alignment.lag, -1.0, 1.0 / 120.0,
                     "the delay that was put in, to one sample", "s");
}

// Corridor and bootstrap over subjects that differ by an individual factor.

Samples subject(const std::vector<double>& time, double factor) {
  Samples samples{.step = time[1] - time[0], .value = pressures({}, time)};
  for (double& v : samples.value) { v *= factor; }
  return samples;
}

double drawn_factor(device::Seeded& seeded) { return 1.0 + 0.1 * seeded.normal(); }

/// Checks that a further subject is in the corridor with the nominal probability.
void measure_corridor(const CaseContext& context, Outcome& outcome) {
  const std::vector<double> time = instants(10.0, 10.0);
  constexpr std::size_t trials = 1000;
  for (const std::size_t count : {3UL, 8UL}) {
    device::Seeded seeded(count);
    std::size_t inside = 0;
    for (std::size_t n = 0; n < trials; ++n) {
      std::vector<Samples> subjects;
      for (std::size_t m = 0; m < count; ++m) {
        subjects.push_back(subject(time, drawn_factor(seeded)));
      }
      Samples further = subject(time, drawn_factor(seeded));
      damage(context, further.value);
      const CorridorBuilt built = build_corridor(subjects);
      inside += built.corridor && coverage(*built.corridor, further).holds ? 1 : 0;
    }
    const Interval expected = expected_share(0.95, trials);
    outcome.judge_between("further_subjects_inside_of_" + std::to_string(count),
                          static_cast<double>(inside) / trials, expected.lower, expected.upper,
                          "Student: 0.95 of further subjects; binomial, 0.999");
  }
  const std::vector<Samples> one{subject(time, 1.0)};
  outcome.judge_at_most("corridors_of_one_subject", build_corridor(one).corridor ? 1.0 : 0.0, 0.0,
                        "one subject has no spread: refused");
}

/// Coverage of the bootstrap for ten subjects: below its nominal level, as theory predicts.
void measure_bootstrap(const CaseContext& context, Outcome& outcome) {
  constexpr std::size_t trials = 400;
  constexpr std::size_t count = 10;
  device::Seeded seeded(77);
  std::size_t covered = 0;
  for (std::size_t n = 0; n < trials; ++n) {
    std::vector<double> values;
    for (std::size_t m = 0; m < count; ++m) { values.push_back(drawn_factor(seeded)); }
    damage(context, values);
    const auto interval = bootstrap_mean(values, {.draws = 500, .seed = n + 1});
    covered += interval && interval->holds(1.0) ? 1 : 0;
  }
  constexpr double normal_factor = 1.959964;  // 0.95 of a normal distribution
  const double theory = student_share(normal_factor * std::sqrt((count - 1.0) / count), count - 1);
  const Interval expected = expected_share(theory, trials);
  outcome.judge_between(
      "share_of_bootstrap_intervals_that_hold_the_mean", static_cast<double>(covered) / trials,
      expected.lower, expected.upper,
      "theory: Student's t at 1.96 sqrt(9/10), 0.90 instead of 0.95; binomial, 0.999");
}

// A simulated insertion recorded through the pressure link and compared with itself.

constexpr double quantum = 0.1 * pascals_per_mmhg;  // [Pa] of the link

/// A needle advances into the epidural space and rests there as long as the rule requires.
Scene resting_insertion() {
  Scene scene = tools::seven_soft_layers();
  scene.simulation = {.duration = 8.5, .step = 1e-3, .integrator = "velocity-verlet"};
  scene.drive = Drive{.speed = 0.01, .depth = 0.0215};
  scene.syringe = Syringe{};
  return scene;
}

Recording through_the_link(const Trace& run) {
  const std::vector<std::uint8_t> bytes =
      link_bytes(link_frames(recording_of(run.time, run.values("syringe.pressure_pa"))));
  return recording_of_link(bytes, run.time.size()).recording;
}

/// Largest rise over one frame period [Pa]: the largest error of a peak by sampling.
double largest_rise(const Recording& recording) {
  Largest largest;
  for (std::size_t n = 1; n < recording.pressure.size(); ++n) {
    largest.add(recording.pressure[n] - recording.pressure[n - 1]);
  }
  return largest.value();
}

/// Compares without a filter, because it rounds a corner more at 120 Hz than at 1 kHz. The event
/// aligns the clocks to within the sampling of each trace.
void judge_event(const Comparison& found, const Recording& recording, Outcome& outcome) {
  const double period = 1.0 / recording.sample_rate;
  outcome.judge_at_most("lag_by_the_event", std::abs(found.alignment.lag) / period, 1.0,
                        "sampling: an event is placed to within a frame period, 1/120 s");
  const FeatureComparison& peak = found.features.at(static_cast<std::size_t>(Feature::peak));
  outcome.judge_at_most("error_of_the_peak", std::abs(peak.error) / pascals_per_mmhg,
                        (0.5 * quantum + largest_rise(recording)) / pascals_per_mmhg,
                        "half of 0.1 mmHg, and what the pressure rises between two samples",
                        "mmHg");
}

void measure_round_trip(const CaseContext& context, Outcome& outcome) {
  const Trace run = roll_out(context, resting_insertion(), {});
  const Recording recording =
      through_the_link(context.mutation == nullptr ? run : roll_out({}, resting_insertion(), {}));
  const Trace simulated = trace_of(run.time, run.values("syringe.pressure_pa"));
  outcome.judge_at_most("missing_samples", recording.defects.missing + recording.defects.bad_frames,
                        0.0, "an undamaged line loses nothing");
  const Comparison found = compare(recording, simulated, {.alignment = AlignmentRule::start});
  outcome.judge_at_most(
      "largest_difference_of_samples",
      largest_difference(found.recorded_raw.value, found.simulated_raw.value) / pascals_per_mmhg,
      0.5 * (1.0 + 1e-6) * quantum / pascals_per_mmhg,
      "the link rounds to 0.1 mmHg: half of that, and rounding", "mmHg");
  outcome.judge_true("verdict_agrees", found.outcome.status == Status::pass,
                     "a recording of the simulation is the simulation");
  const Comparison by_event =
      compare(recording, simulated, {.alignment = AlignmentRule::event, .cutoff = 0.0});
  if (by_event.features.empty()) {
    outcome.judge_at_most("lag_by_the_event", not_measured, 1.0, "sampling");
  } else {
    judge_event(by_event, recording, outcome);
  }
  outcome.notes = found.outcome.reasons;
}

}  // namespace

std::vector<Case> comparison_cases() {
  return {
      {"clinical/verdicts", "clinical",
       "Every fault beyond its tolerance is called a difference, noise and small ones are not, and "
       "what cannot be compared is not.",
       measure_verdicts, 0.3},
      {"clinical/blind-spots", "clinical",
       "Measures of whole traces call a fall that is five times too slow good; they may not judge.",
       measure_blindness, 0.1},
      {"clinical/subjects/corridor", "clinical",
       "The corridor of a few subjects holds a further one as often as it says; of one there is "
       "none.",
       measure_corridor, 0.2},
      {"clinical/subjects/bootstrap", "clinical",
       "Bootstrap intervals over subjects are as narrow as is known of them, and are said to be.",
       measure_bootstrap, 0.2},
      {"clinical/round-trip", "clinical",
       "A simulated insertion that is recorded through the pressure link agrees with itself, to "
       "within what the link rounds and samples.",
       measure_round_trip, 0.5}};
}

}  // namespace palpate::clinical
