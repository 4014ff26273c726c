// SPDX-License-Identifier: MIT
/// Each measure against closed forms, and all against a second opinion on one trace with six faults.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "validation/cases/clinical_parts.hpp"
#include "validation/cases/clinical_traces.hpp"
#include "validation/comparison/iso_rating.hpp"
#include "validation/comparison/trace_errors.hpp"
#include "validation/comparison/zero_phase.hpp"

namespace palpate::clinical {

namespace {

using namespace comparison;

void judge_near(Outcome& outcome, const std::string& name, double value, double expected, double within,
                const std::string& from) {
  outcome.judge({.name = name, .value = value, .lower = expected - within, .upper = expected + within,
                 .bound_from = from});
}

constexpr double rounding = 1e-12;

/// A square wave of 20 samples a half period.
std::vector<double> square_wave(double size) {
  std::vector<double> wave(200);
  for (std::size_t n = 0; n < wave.size(); ++n) { wave[n] = n / 20 % 2 == 0 ? size : -size; }
  return wave;
}

/// Zeros, and 1 on 30 samples from `begin`.
std::vector<double> pulse(std::size_t begin) {
  std::vector<double> wave(200, 0.0);
  std::fill_n(wave.begin() + static_cast<std::ptrdiff_t>(begin), 30, 1.0);
  return wave;
}

void by_hand_distances(const CaseContext& context, Outcome& outcome) {
  std::vector<double> simulated{2.0, 2.0, 2.0, 2.0};
  const std::vector<double> recorded{1.0, 2.0, 3.0, 4.0};
  damage(context, simulated);
  const TraceErrors errors = trace_errors(simulated, recorded);
  const std::string from = "closed form: 2, 2, 2, 2 against 1, 2, 3, 4";
  judge_near(outcome, "rmse", errors.rmse, std::sqrt(1.5), rounding, from);
  judge_near(outcome, "nrmse", errors.nrmse, std::sqrt(1.5) / 3.0, rounding, from);
  const double magnitude = std::sqrt(16.0 / 30.0) - 1.0;
  const double phase = std::acos(20.0 / std::sqrt(480.0)) * std::numbers::inv_pi;
  judge_near(outcome, "sprague_geers_magnitude", errors.magnitude, magnitude, rounding, from);
  judge_near(outcome, "sprague_geers_phase", errors.phase, phase, rounding, from);
  judge_near(outcome, "sprague_geers_combined", errors.combined, std::hypot(magnitude, phase), rounding,
             from);
}

void by_hand_rating_of_gain(const CaseContext& context, Outcome& outcome) {
  std::vector<double> simulated = square_wave(1.2);
  damage(context, simulated);
  const IsoRating rating = rate(simulated, square_wave(1.0));
  const std::string from = "closed form: a square wave 20 % too large";
  judge_near(outcome, "gain_corridor", rating.corridor, std::pow(0.3 / 0.45, 2), rounding, from);
  judge_near(outcome, "gain_phase", rating.phase, 1.0, rounding, from);
  judge_near(outcome, "gain_magnitude", rating.magnitude, 0.6, rounding, from);
  judge_near(outcome, "gain_slope", rating.slope, 0.9, rounding, from);
}

void by_hand_rating_of_delay(const CaseContext& context, Outcome& outcome) {
  std::vector<double> simulated = pulse(90);
  damage(context, simulated);
  const IsoRating rating = rate(simulated, pulse(80));
  const std::string from = "closed form: a pulse of 30 of 200 samples, 10 late";
  judge_near(outcome, "delay_corridor", rating.corridor, 1.0 - 20.0 / 200.0, rounding, from);
  judge_near(outcome, "delay_phase", rating.phase, 1.0 - 10.0 / 40.0, rounding, from);
  judge_near(outcome, "delay_magnitude", rating.magnitude, 1.0, rounding, from);
  judge_near(outcome, "delay_slope", rating.slope, 1.0, rounding, from);
  judge_near(outcome, "delay_overall", rating.overall, 0.4 * 0.9 + 0.2 * 2.75, rounding, from);
}

void measure_closed_forms(const CaseContext& context, Outcome& outcome) {
  by_hand_distances(context, outcome);
  by_hand_rating_of_gain(context, outcome);
  by_hand_rating_of_delay(context, outcome);
  const std::vector<double> constant(200, 0.3);
  judge_near(outcome, "phase_of_a_constant", rate(constant, square_wave(1.0)).phase, 0.0, 0.0,
             "a constant has no phase, so none may be scored");
}

/// NRMSE, Sprague-Geers M and P, then Z, E_P, E_M, E_S, R.
using Figures = std::array<double, 8>;

struct Fault {
  const char* name;
  std::vector<double> simulated;
  Figures second_opinion;
};

Figures figures_of(const std::vector<double>& simulated, const std::vector<double>& recorded) {
  const TraceErrors e = trace_errors(simulated, recorded);
  const IsoRating r = rate(simulated, recorded);
  return {e.nrmse, e.magnitude, e.phase, r.corridor, r.phase, r.magnitude, r.slope, r.overall};
}

/// Ramp 20 to 60 mmHg, at 6 s a fall to 8 mmHg; 10 s at 100 Hz. The second opinion is a plain program in
/// Python with NumPy, written from the definitions.
std::vector<Fault> faults_of(const std::vector<double>& time) {
  std::vector<double> louder = pressures({}, time);
  std::vector<double> higher = louder;
  for (double& v : louder) { v *= 1.1; }
  for (double& v : higher) { v += 5.0 * pascals_per_mmhg; }
  return {{"gain +10 %",
           louder,
           {0.059746, 0.100000, 0.000000, 0.958687, 1.000000, 0.956109, 0.950000, 0.964697}},
          {"offset +5 mmHg",
           higher,
           {0.096154, 0.138035, 0.024696, 0.857339, 1.000000, 0.833262, 1.000000, 0.909588}},
          {"delay 0.2 s",
           pressures({.delay = 0.2}, time),
           {0.096060, 0.003475, 0.051132, 0.964879, 0.900000, 1.000000, 1.000000, 0.965951}},
          {"delay 1 s",
           pressures({.delay = 1.0}, time),
           {0.290890, 0.017256, 0.155090, 0.737432, 0.500000, 1.000000, 1.000000, 0.794973}},
          {"drop 5x slower",
           pressures({.fall_constant = 0.75}, time),
           {0.141418, 0.065559, 0.070276, 0.885511, 0.840000, 0.972138, 0.620393, 0.840711}},
          {"no loss of resistance",
           pressures({.plateau = PressureLaw{}.peak}, time),
           {0.614003, 0.558699, 0.224540, 0.604652, 0.000000, 0.133669, 0.587423, 0.386079}}};
}

void measure_fault_table(const CaseContext& context, Outcome& outcome) {
  std::vector<double> time = instants(10.0, 100.0);
  time.pop_back();  // 1000 samples
  const std::vector<double> recorded = pressures({}, time);
  Table table{.id = "faults", .title = "What each measure makes of a fault",
              .caption = "Ramp 20 to 60 mmHg, fall to 8 mmHg at 6 s, 10 s at 100 Hz.",
              .columns = {"fault", "NRMSE", "Sprague-Geers M", "Sprague-Geers P", "ISO corridor", "ISO phase",
                          "ISO magnitude", "ISO slope", "ISO rating"}};
  for (Fault& fault : faults_of(time)) {
    damage(context, fault.simulated);
    const Figures found = figures_of(fault.simulated, recorded);
    std::vector<Cell> row{fault.name};
    row.insert(row.end(), found.begin(), found.end());
    table.rows.push_back(std::move(row));
    outcome.judge(
        {.name = "largest_difference: " + std::string(fault.name),
         .value = largest_difference(found, fault.second_opinion),
         .upper = 1e-6,
         .bound_from = "a second implementation (Python, NumPy), to the six digits it was printed with"});
  }
  outcome.tables.push_back(std::move(table));
}

/// A fall from 1 to 0 that begins at 2 s, filtered, at 1 kHz.
Samples filtered_fall(const CaseContext& context, double duration, double cutoff) {
  std::vector<double> fall;
  for (const double t : instants(4.0, 1000.0)) {
    fall.push_back(std::clamp(1.0 - (t - 2.0) / duration, 0.0, 1.0));
  }
  damage(context, fall);
  return zero_phase({.step = 1e-3, .value = fall}, cutoff);
}

/// When the second half of it last passes a level, linear between samples [s].
double last_passage(const Samples& fall, double level) {
  for (std::size_t n = fall.size() - 1; n > 0; --n) {
    if (fall.value[n - 1] >= level) {
      const double share = (fall.value[n - 1] - level) / (fall.value[n - 1] - fall.value[n]);
      return fall.time(n - 1) + share * fall.step;
    }
  }
  return not_measured;
}

/// What the filter does to falls. The impulse response of 1 / (1 + w^4) is a/2 exp(-a|t|) (cos at + sin a|t|)
/// with a = sqrt(2) pi f_c, so a step has passed 1 - exp(-at) cos(at) / 2 at t, and a straight line is
/// overshot most where that is 1 first, by exp(-pi/2) / (4 a T) of its height.
void measure_falls(const CaseContext& context, Outcome& outcome) {
  const double cutoff = 20.0;
  const double a = std::numbers::sqrt2 * std::numbers::pi * cutoff;
  const std::string from =
      "closed form; the bilinear transform bends 60 Hz, three times the cut-off, by (pi f / rate)^2 / 3 = "
      "1.2 %";
  const Samples sudden = filtered_fall(context, 1e-9, cutoff);
  const double nine_tenths = 0.9975762196151974;  // exp(-x) cos x = 1/5
  const double time = 2.0 * nine_tenths / a;
  judge_near(outcome, "time_of_a_sudden_fall", last_passage(sudden, 0.1) - last_passage(sudden, 0.9), time,
             0.012 * time, from);
  for (const double duration : {0.06, 0.25}) {
    const Samples fall = filtered_fall(context, duration, cutoff);
    const double overshoot = std::exp(-0.5 * std::numbers::pi) / (4.0 * a * duration);
    judge_near(outcome, "overshoot_of_a_fall_of_" + std::to_string(std::lround(1e3 * duration)) + "_ms",
               std::ranges::max(fall.value) - 1.0, overshoot, 0.012 * overshoot, from);
  }
}

/// Gain and delay of the filter for a sine, away from its ends.
void measure_filter(const CaseContext& context, Outcome& outcome) {
  const double rate_hz = 200.0;
  const double cutoff = 20.0;
  const std::vector<double> time = instants(5.0, rate_hz);
  for (const double frequency : {2.0, 20.0, 60.0}) {
    std::vector<double> sine;
    for (const double t : time) { sine.push_back(std::sin(2.0 * std::numbers::pi * frequency * t)); }
    damage(context, sine);
    const Samples filtered = zero_phase({.step = 1.0 / rate_hz, .value = sine}, cutoff);
    double in_phase = 0.0;
    double across = 0.0;
    for (std::size_t n = 200; n < 800; ++n) {  // whole periods of each frequency
      in_phase += filtered.value[n] * std::sin(2.0 * std::numbers::pi * frequency * time[n]) / 300.0;
      across += filtered.value[n] * std::cos(2.0 * std::numbers::pi * frequency * time[n]) / 300.0;
    }
    const double w =
        std::tan(std::numbers::pi * frequency / rate_hz) / std::tan(std::numbers::pi * cutoff / rate_hz);
    const std::string at = std::to_string(static_cast<int>(frequency)) + "_hz";
    judge_near(outcome, "gain_at_" + at, in_phase, 1.0 / (1.0 + std::pow(w, 4)), 1e-9,
               "theory: 1 / (1 + w^4); ends a second away");
    judge_near(outcome, "quadrature_at_" + at, across, 0.0, 1e-9, "theory: no phase");
  }
  measure_falls(context, outcome);
}

}  // namespace

std::vector<Case> measure_cases() {
  return {{.name = "clinical/measures/closed-forms",
           .suite = "clinical",
           .claim = "Distances and ratings of traces are what can be worked out by hand.",
           .measure = measure_closed_forms,
           .weight = 0.1},
          {.name = "clinical/measures/fault-table",
           .suite = "clinical",
           .claim = "An implementation written apart from this one gives the same figures for six faults.",
           .measure = measure_fault_table,
           .weight = 0.1},
          {.name = "clinical/measures/filter",
           .suite = "clinical",
           .claim = "The low-pass has the gain of theory, moves nothing in time, and costs a fall what theory "
                    "says.",
           .measure = measure_filter,
           .weight = 0.1}};
}

}  // namespace palpate::clinical
