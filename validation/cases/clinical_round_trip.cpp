// SPDX-License-Identifier: MIT
/// A simulated insertion recorded through the pressure link, and compared with itself.
#include <algorithm>
#include <cmath>

#include "device/pressure_link/frame.hpp"
#include "model/dynamics/pressure_units.hpp"
#include "validation/cases/clinical_parts.hpp"
#include "validation/cases/clinical_traces.hpp"
#include "validation/cases/tool_setting.hpp"
#include "validation/comparison/comparison.hpp"
#include "validation/insertion.hpp"
#include "validation/link_recording.hpp"

namespace palpate::clinical {

namespace {

using namespace comparison;

constexpr double quantum = 0.1 * pascals_per_mmhg;  // [Pa] of the link

/// A needle that advances into the epidural space and rests there for as long as the rule asks.
Scene resting_insertion() {
  Scene scene = tools::seven_soft_layers();
  scene.simulation = {.duration = 8.5, .step = 1e-3, .integrator = "velocity-verlet"};
  scene.drive = Drive{.speed = 0.01, .depth = 0.0215};
  scene.syringe = Syringe{};
  return scene;
}

Recording through_the_link(const Insertion& run) {
  const std::vector<std::uint8_t> bytes = link_bytes(link_frames(recording_of(run.time, run.pressure)));
  return recording_of_link(bytes, run.time.size()).recording;
}

/// Largest rise of the pressure over one frame period [Pa]: what sampling may take from a peak.
double largest_rise(const Recording& recording) {
  double largest = 0.0;
  for (std::size_t n = 1; n < recording.pressure.size(); ++n) {
    largest = std::max(largest, recording.pressure[n] - recording.pressure[n - 1]);
  }
  return largest;
}

void judge_samples(const Comparison& found, Outcome& outcome) {
  outcome.judge({.name = "largest_difference_of_samples",
                 .value = largest_difference(found.recorded_raw.value, found.simulated_raw.value) /
                          pascals_per_mmhg,
                 .unit = "mmHg",
                 .upper = 0.5 * (1.0 + 1e-6) * quantum / pascals_per_mmhg,
                 .bound_from = "the link rounds to 0.1 mmHg: half of that, and rounding"});
  outcome.judge({.name = "verdict_agrees",
                 .value = found.verdict == Verdict::agrees ? 1.0 : 0.0,
                 .lower = 1.0,
                 .bound_from = "a recording of the simulation is the simulation"});
}

/// Without a filter, which makes a little less of a corner at 120 Hz than at 1 kHz. Clocks are laid over each
/// other by the event, which either trace places to within its own sampling.
void judge_event(const Comparison& found, const Recording& recording, Outcome& outcome) {
  const double period = 1.0 / recording.sample_rate;
  outcome.judge({.name = "lag_by_the_event",
                 .value = std::abs(found.alignment.lag) / period,
                 .unit = "1",
                 .upper = 1.0,
                 .bound_from = "sampling: an event is placed to within a frame period, 1/120 s"});
  const FeatureVerdict& peak = found.features.at(static_cast<std::size_t>(Feature::peak));
  outcome.judge({.name = "error_of_the_peak",
                 .value = std::abs(peak.error) / pascals_per_mmhg,
                 .unit = "mmHg",
                 .upper = (0.5 * quantum + largest_rise(recording)) / pascals_per_mmhg,
                 .bound_from = "half of 0.1 mmHg, and what the pressure rises between two samples"});
}

void measure_round_trip(const CaseContext& context, Outcome& outcome) {
  const Insertion run = insert_tool(context, resting_insertion());
  const Recording recording = through_the_link(run);
  std::vector<double> pressure = run.pressure;
  damage(context, pressure);
  const Trace simulated = trace_of(run.time, pressure);
  outcome.judge({.name = "missing_samples",
                 .value = static_cast<double>(recording.defects.missing + recording.defects.bad_frames),
                 .upper = 0.0,
                 .bound_from = "an undamaged line loses nothing"});
  const Comparison found = compare(recording, simulated, {.alignment = AlignmentRule::start});
  judge_samples(found, outcome);
  const Comparison by_event =
      compare(recording, simulated, {.alignment = AlignmentRule::event, .cutoff = 0.0});
  if (by_event.features.empty()) {
    outcome.judge(
        {.name = "lag_by_the_event", .value = not_measured, .upper = 1.0, .bound_from = "sampling"});
  } else {
    judge_event(by_event, recording, outcome);
  }
  outcome.notes = found.reasons;
}

}  // namespace

std::vector<Case> round_trip_cases() {
  return {{.name = "clinical/round-trip",
           .suite = "clinical",
           .claim = "A simulated insertion that is recorded through the pressure link agrees with itself, to "
                    "within what the link rounds and samples.",
           .measure = measure_round_trip,
           .weight = 0.5}};
}

}  // namespace palpate::clinical
