// SPDX-License-Identifier: MIT
/// Comparison of each measure with closed forms, and with an independent program on one trace with
/// six faults.

#include <array>
#include <numbers>

#include "validation/claims/clinical_fixture.hpp"
#include "validation/claims/groups.hpp"
#include "validation/comparison/features.hpp"
#include "validation/comparison/iso_rating.hpp"
#include "validation/signal.hpp"
#include "validation/statistics.hpp"

namespace palpate::clinical {

namespace {

using namespace comparison;

constexpr double rounding = 1e-12;

/// Returns a square wave with half periods of 20 samples.
std::vector<double> square_wave(double size) {
  std::vector<double> wave(200);
  for (std::size_t n = 0; n < wave.size(); ++n) { wave[n] = n / 20 % 2 == 0 ? size : -size; }
  return wave;
}

/// Returns zeros with 30 ones from `begin`.
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
  outcome.judge_near("rmse", errors.rmse, std::sqrt(1.5), rounding, from);
  outcome.judge_near("nrmse", errors.nrmse, std::sqrt(1.5) / 3.0, rounding, from);
  const double magnitude = std::sqrt(16.0 / 30.0) - 1.0;
  const double phase = std::acos(20.0 / std::sqrt(480.0)) * std::numbers::inv_pi;
  outcome.judge_near("sprague_geers_magnitude", errors.magnitude, magnitude, rounding, from);
  outcome.judge_near("sprague_geers_phase", errors.phase, phase, rounding, from);
  outcome.judge_near("sprague_geers_combined", errors.combined, std::hypot(magnitude, phase),
                     rounding, from);
}

void by_hand_rating_of_gain(const CaseContext& context, Outcome& outcome) {
  std::vector<double> simulated = square_wave(1.2);
  damage(context, simulated);
  const IsoRating rating = rate(simulated, square_wave(1.0));
  const std::string from = "closed form: a square wave 20 % too large";
  outcome.judge_near("gain_corridor", rating.corridor, std::pow(0.3 / 0.45, 2), rounding, from);
  outcome.judge_near("gain_phase", rating.phase, 1.0, rounding, from);
  outcome.judge_near("gain_magnitude", rating.magnitude, 0.6, rounding, from);
  outcome.judge_near("gain_slope", rating.slope, 0.9, rounding, from);
}

void by_hand_rating_of_delay(const CaseContext& context, Outcome& outcome) {
  std::vector<double> simulated = pulse(90);
  damage(context, simulated);
  const IsoRating rating = rate(simulated, pulse(80));
  const std::string from = "closed form: a pulse of 30 of 200 samples, 10 late";
  outcome.judge_near("delay_corridor", rating.corridor, 1.0 - 20.0 / 200.0, rounding, from);
  outcome.judge_near("delay_phase", rating.phase, 1.0 - 10.0 / 40.0, rounding, from);
  outcome.judge_near("delay_magnitude", rating.magnitude, 1.0, rounding, from);
  outcome.judge_near("delay_slope", rating.slope, 1.0, rounding, from);
  outcome.judge_near("delay_overall", rating.overall, 0.4 * 0.9 + 0.2 * 2.75, rounding, from);
}

void measure_closed_forms(const CaseContext& context, Outcome& outcome) {
  by_hand_distances(context, outcome);
  by_hand_rating_of_gain(context, outcome);
  by_hand_rating_of_delay(context, outcome);
  const std::vector<double> constant(200, 0.3);
  outcome.judge_near("phase_of_a_constant", rate(constant, square_wave(1.0)).phase, 0.0, 0.0,
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

/// Trace of the comparison: ramp from 20 to 60 mmHg, fall to 8 mmHg at 6 s; 10 s at 100 Hz. The
/// independent program is in Python with NumPy, written from the definitions.
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
  Table& table =
      outcome.table("faults", "What each measure makes of a fault",
                    "Ramp 20 to 60 mmHg, fall to 8 mmHg at 6 s, 10 s at 100 Hz.",
                    {"fault", "NRMSE", "Sprague-Geers M", "Sprague-Geers P", "ISO corridor",
                     "ISO phase", "ISO magnitude", "ISO slope", "ISO rating"});
  for (Fault& fault : faults_of(time)) {
    damage(context, fault.simulated);
    const Figures found = figures_of(fault.simulated, recorded);
    std::vector<Cell> row{fault.name};
    row.insert(row.end(), found.begin(), found.end());
    table.rows.push_back(std::move(row));
    outcome.judge_at_most(
        "largest_difference: " + std::string(fault.name),
        largest_difference(found, fault.second_opinion), 1e-6,
        "a second implementation (Python, NumPy), to the six digits it was printed with");
  }
}

/// Returns a filtered fall from 1 to 0 that begins at 2 s, at 1 kHz.
Samples filtered_fall(const CaseContext& context, double duration, double cutoff) {
  std::vector<double> fall;
  for (const double t : instants(4.0, 1000.0)) {
    fall.push_back(std::clamp(1.0 - (t - 2.0) / duration, 0.0, 1.0));
  }
  damage(context, fall);
  return zero_phase({.step = 1e-3, .value = fall}, cutoff);
}

/// Returns the time at which its second half last passes a level, linear between samples [s].
double last_passage(const Samples& fall, double level) {
  for (std::size_t n = fall.size() - 1; n > 0; --n) {
    if (fall.value[n - 1] >= level) {
      const double share = (fall.value[n - 1] - level) / (fall.value[n - 1] - fall.value[n]);
      return fall.time(n - 1) + share * fall.step;
    }
  }
  return not_measured;
}

/// Effect of the filter on falls. The impulse response of 1 / (1 + w^4) is a/2 exp(-a|t|) (cos at +
/// sin a|t|) with a = sqrt(2) pi f_c. A step response is 1 - exp(-at) cos(at) / 2 at t. The largest
/// overshoot of a ramp occurs where this is first 1: exp(-pi/2) / (4 a T) of its height.
void measure_falls(const CaseContext& context, Outcome& outcome) {
  const double cutoff = 20.0;
  const double a = std::numbers::sqrt2 * std::numbers::pi * cutoff;
  const std::string from =
      "closed form; the bilinear transform shifts 60 Hz by (pi f / rate)^2 / 3 = 1.2 %";
  const Samples sudden = filtered_fall(context, 1e-9, cutoff);
  const double nine_tenths = 0.9975762196151974;  // exp(-x) cos x = 1/5
  const double time = 2.0 * nine_tenths / a;
  outcome.judge_near("time_of_a_sudden_fall", last_passage(sudden, 0.1) - last_passage(sudden, 0.9),
                     time, 0.012 * time, from);
  for (const double duration : {0.06, 0.25}) {
    const Samples fall = filtered_fall(context, duration, cutoff);
    const double overshoot = std::exp(-0.5 * std::numbers::pi) / (4.0 * a * duration);
    outcome.judge_near(
        "overshoot_of_a_fall_of_" + std::to_string(std::lround(1e3 * duration)) + "_ms",
        std::ranges::max(fall.value) - 1.0, overshoot, 0.012 * overshoot, from);
  }
}

/// Checks gain and delay of the filter for a sine, away from its ends.
void measure_filter(const CaseContext& context, Outcome& outcome) {
  const double rate_hz = 200.0;
  const double cutoff = 20.0;
  const std::vector<double> time = instants(5.0, rate_hz);
  for (const double frequency : {2.0, 20.0, 60.0}) {
    std::vector<double> sine;
    for (const double t : time) {
      sine.push_back(std::sin(2.0 * std::numbers::pi * frequency * t));
    }
    damage(context, sine);
    const Samples filtered = zero_phase({.step = 1.0 / rate_hz, .value = sine}, cutoff);
    double in_phase = 0.0;
    double across = 0.0;
    for (std::size_t n = 200; n < 800; ++n) {  // whole periods of each frequency
      in_phase +=
          filtered.value[n] * std::sin(2.0 * std::numbers::pi * frequency * time[n]) / 300.0;
      across += filtered.value[n] * std::cos(2.0 * std::numbers::pi * frequency * time[n]) / 300.0;
    }
    const double w = std::tan(std::numbers::pi * frequency / rate_hz) /
                     std::tan(std::numbers::pi * cutoff / rate_hz);
    const std::string at = std::to_string(static_cast<int>(frequency)) + "_hz";
    outcome.judge_near("gain_at_" + at, in_phase, 1.0 / (1.0 + std::pow(w, 4)), 1e-9,
                       "theory: 1 / (1 + w^4); ends a second away");
    outcome.judge_near("quadrature_at_" + at, across, 0.0, 1e-9, "theory: no phase");
  }
  measure_falls(context, outcome);
}

// Features of pressures with a known law, and the reasons for absent features.

constexpr double nine_tenths_to_one_tenth = 2.1972245773362196;  // ln 9

Features features_at(const CaseContext& context, const PressureLaw& law, double rate,
                     double cutoff) {
  const std::vector<double> time = instants(14.0, rate);
  std::vector<double> pressure = pressures(law, time);
  damage(context, pressure);
  return prepare({.time = time, .value = pressure}, cutoff, {}).features;
}

void judge_feature_value(Outcome& outcome, const Features& found, Feature feature, double expected,
                         double within, const std::string& from) {
  outcome.judge_near(std::string(name_of(feature)), found[feature].value.value_or(not_measured),
                     expected, within, from, unit_of(feature, "Pa"));
}

/// At 1 kHz and unfiltered: the law is between its samples by no more than a chord leaves.
void measure_closed_form_features(const CaseContext& context, Outcome& outcome) {
  const PressureLaw law;
  const Features found = features_at(context, law, 1000.0, 0.0);
  const double step = 1e-3;
  const double chord =
      step * step / (8.0 * law.fall_constant);  // [s] of a crossing of the exponential
  const double residue = (law.peak - law.plateau) * std::exp(-1.0 / law.fall_constant);
  const std::string from = "closed form of the law; a chord of 1 ms";
  judge_feature_value(outcome, found, Feature::loss_of_resistance, 1.0, 0.0,
                      "the law drops by 87 % and stays");
  judge_feature_value(outcome, found, Feature::peak, law.peak, 1e-9 * law.peak,
                      "closed form, a sample lies on it");
  judge_feature_value(outcome, found, Feature::plateau, law.plateau, residue,
                      "closed form; what the fall leaves at 1 s");
  judge_feature_value(outcome, found, Feature::drop_height, law.peak - law.plateau, residue,
                      "closed form, likewise");
  judge_feature_value(outcome, found, Feature::relative_drop, 1.0 - law.plateau / law.peak,
                      residue / law.peak, "closed form, likewise");
  const double depth = residue / (law.peak - law.plateau);  // of the levels' place, in heights
  judge_feature_value(outcome, found, Feature::drop_time,
                      nine_tenths_to_one_tenth * law.fall_constant,
                      2.0 * chord + 10.0 * depth * law.fall_constant, from);
  judge_feature_value(outcome, found, Feature::time_of_loss,
                      law.loss + law.fall_constant * std::log(2.0),
                      chord + 2.0 * depth * law.fall_constant, from);
  judge_feature_value(outcome, found, Feature::time_of_peak, law.loss, 1e-9,
                      "closed form, a sample lies on it");
  const double slope = (law.peak - law.level) / (law.loss - law.rise);
  judge_feature_value(outcome, found, Feature::slope_before, slope, 1e-9 * slope,
                      "closed form: a straight rise");
}

/// With noise at the rate of the link: the error is within the stated uncertainty.
void measure_uncertain_features(const CaseContext& context, Outcome& outcome) {
  const PressureLaw law;
  const Features clean = features_at(context, law, 120.0, 20.0);
  const std::vector<double> time = instants(14.0, 120.0);
  constexpr int trials = 100;
  const std::vector<Feature> watched{Feature::plateau, Feature::slope_before, Feature::drop_time,
                                     Feature::time_of_loss};
  std::vector<double> square(watched.size(), 0.0);
  double noise = 0.0;
  for (int n = 0; n < trials; ++n) {
    device::Seeded seeded(static_cast<std::uint64_t>(n) + 1);
    std::vector<double> pressure = pressures(law, time);
    add_noise(pressure, pascals_per_mmhg, seeded);
    damage(context, pressure);
    const Features found = prepare({.time = time, .value = pressure}, 20.0, {}).features;
    noise += found.noise / pascals_per_mmhg / trials;
    for (std::size_t i = 0; i < watched.size(); ++i) {
      const Measured& m = found[watched[i]];
      const double off =
          m.value.value_or(not_measured) - clean[watched[i]].value.value_or(not_measured);
      square[i] += std::pow(off / m.uncertainty, 2) / trials;
    }
  }
  outcome.judge_between(
      "noise_found_over_noise_added", noise, 0.95, 1.05,
      "theory; the median of 1600 samples is known to 2 %, and the event adds to it");
  for (std::size_t i = 0; i < watched.size(); ++i) {
    outcome.judge_between("spread_over_uncertainty: " + std::string(name_of(watched[i])),
                          std::sqrt(square[i]), 0.5, 1.2225,
                          "1 if the uncertainty is right; up to sqrt(149.4 / 100) over 100 trials "
                          "(chi square, 0.999), and at most twice too cautious (assumed)");
  }
}

// Rates of true and false detections of the loss of resistance by the published rule.

/// Insertion techniques with and without a loss of resistance, to test its detection.
enum class Technique { continuous, intermittent };
struct Insertions {
  Technique technique = Technique::continuous;
  double mean_drop = 0.73;       ///< relative to the peak [1]
  double deviation_drop = 0.18;  ///< standard deviation, normal, clamped to 0.02 and 0.98
  bool held = true;              ///< false: the pressure recovers within 4 s
  bool drops = true;             ///< false: no drops other than those between pushes
};
constexpr double sample_rate = 120.0;                       ///< [Hz] of the raw pressure link
constexpr double noise_deviation = 5.0 * pascals_per_mmhg;  ///< [Pa] (assumed)
constexpr double smallest_peak = 300.0 * pascals_per_mmhg;  ///< [Pa]; the largest is twice that
constexpr double length = 30.0;                             // [s]

/// Event of one insertion.
struct Drop {
  double time = 0.0;            // [s]
  double drop = 0.0;            // relative to the peak [1]
  double fall_constant = 0.05;  // [s]
  double back = 0.0;            // [s] after it; 0: never
};

/// Returns the pressure after the event as a share of the peak.
double left_by(const Drop& event, double t) {
  if (t < event.time) { return 1.0; }
  const double fallen =
      1.0 - event.drop * (1.0 - std::exp(-(t - event.time) / event.fall_constant));
  if (event.back <= 0.0 || t < event.time + event.back) { return fallen; }
  return std::min(1.0, fallen + 2.0 * (t - event.time - event.back));  // back within half a second
}

/// Pushes of a thumb between 0 and 1: rise in a fifth of a period, constant, release.
double push(double t, double period, double relax) {
  const double phase = std::fmod(t, period);
  if (phase < 0.2 * period) { return phase / (0.2 * period); }
  if (phase < 0.5 * period) { return 1.0; }
  return 0.15 + 0.85 * std::exp(-(phase - 0.5 * period) / relax);
}

/// Returns a synthetic insertion of 30 s.
Samples seeded_insertion(const Insertions& kind, std::uint64_t seed) {
  device::Seeded seeded(seed);
  const double peak = seeded.uniform(1.0, 2.0) * smallest_peak;
  const double period = seeded.uniform(1.5, 4.0);
  const double relax = seeded.uniform(0.1, 0.4);
  Drop event{.time = seeded.uniform(8.0, 18.0), .fall_constant = seeded.uniform(0.02, 0.09)};
  event.drop = kind.drops
                   ? std::clamp(kind.mean_drop + kind.deviation_drop * seeded.normal(), 0.02, 0.98)
                   : 0.0;
  event.back = kind.held ? 0.0 : seeded.uniform(0.3, 4.0);
  if (kind.technique == Technique::intermittent) {  // the needle enters while it is pushed
    event.time = period * (std::floor(event.time / period) + 0.45);
  }
  Samples samples{.step = 1.0 / sample_rate};
  for (const double t : instants(length, sample_rate)) {
    const double rise = 0.3 + 0.7 * std::min(1.0, t / event.time);
    const bool pushed =
        kind.technique == Technique::intermittent && (t < event.time || !kind.held || !kind.drops);
    samples.value.push_back(peak * rise * left_by(event, t) *
                            (pushed ? push(t, period, relax) : 1.0));
  }
  add_noise(samples.value, noise_deviation, seeded);
  return samples;
}

struct Count {
  std::size_t found = 0;
  std::size_t trials = 0;
  [[nodiscard]] double share() const {
    return static_cast<double>(found) / static_cast<double>(trials);
  }
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

/// Four standard deviations of filtered plateau noise, as a share of the smallest peak.
double lost_to_noise() {
  return 4.0 * noise_deviation * std::sqrt(noise_shares(20.0, sample_rate).passed) / smallest_peak;
}

/// Compares the share found with the share of normally distributed drops above the threshold.
void judge_share(Outcome& outcome, const std::string& name, const Insertions& kind,
                 const Count& count) {
  const double over = (LossRule{}.least_drop - kind.mean_drop) / kind.deviation_drop;
  const double most = normal_above(over);
  const double least = normal_above(over + lost_to_noise() / kind.deviation_drop);
  outcome.judge_between(name, count.share(), expected_share(least, count.trials).lower,
                        expected_share(most, count.trials).upper,
                        "binomial, 0.999, about the share of the distribution above the threshold, "
                        "and above it by four deviations of the noise");
}

/// The rule must reject all of these, so any detection is a fault of the code.
void judge_none(Outcome& outcome, const std::string& name, const Count& count) {
  outcome.judge_at_most(
      name, count.found, 0.0,
      "the rule: nothing that comes back within 5 s; 0 of " + std::to_string(count.trials) +
          " leaves at most " +
          std::to_string(100.0 * share_interval(0, count.trials).upper).substr(0, 4) + " %");
}

Figure examples() {
  using enum Technique;
  Figure figure =
      plot("examples", "Made-up insertions", "One of each kind, as drawn from its seed.",
           {"time (s)"}, {"pressure (mmHg)"});
  const auto add = [&](const std::string& label, const Insertions& kind, std::uint64_t seed) {
    const Samples pressure = seeded_insertion(kind, seed);
    figure.series.push_back({.label = label});
    for (std::size_t n = 0; n < pressure.size(); ++n) {
      figure.series.back().add(pressure.time(n), pressure.value[n] / pascals_per_mmhg);
    }
  };
  add("true, continuous", {}, 1);
  add("true, intermittent", {.technique = intermittent}, 10001);
  add("false, comes back", {.mean_drop = 0.33, .held = false}, 20002);
  return figure;
}

void measure_detection(const CaseContext& context, Outcome& outcome) {
  using enum Technique;
  Table& table =
      outcome.table("detection", "Loss of resistance found",
                    "Made-up insertions, 30 s at 120 Hz, noise of 5 mmHg; drops from normal "
                    "distributions with the published means (73 % true, 33 % false) and 18 %, "
                    "which puts 10 % of true ones under half. 95 % Clopper-Pearson.",
                    {"insertions", "number", "share found", "lower", "upper"});
  const auto add = [&](const std::string& what, const Insertions& kind, std::uint64_t seed) {
    const Count count = count_found(context, kind, seed);
    const Interval interval = share_interval(count.found, count.trials);
    table.rows.push_back({what, count.trials, count.share(), interval.lower, interval.upper});
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
  judge_none(outcome, "false_alarms_of_no_fall",
             add("pressure that stays", {.drops = false}, 50001));
  judge_share(outcome, "false_alarms_of_falls_that_are_held", false_held,
              add("false, but held", false_held, 60001));
  outcome.figures.push_back(examples());
  outcome.notes.push_back(
      "A false loss that is held for 5 s cannot be distinguished from a true one by pressure "
      "alone: about a third of them lie above the threshold.");
}

}  // namespace

std::vector<Case> measure_cases() {
  return {
      {"clinical/measures/closed-forms", "clinical",
       "Distances and ratings of traces are what can be worked out by hand.", measure_closed_forms,
       0.1},
      {"clinical/measures/fault-table", "clinical",
       "An implementation written apart from this one gives the same figures for six faults.",
       measure_fault_table, 0.1},
      {"clinical/measures/filter", "clinical",
       "The low-pass has the gain of theory, moves nothing in time, and costs a fall what theory "
       "says.",
       measure_filter, 0.1},
      {"clinical/features/closed-form", "clinical",
       "Every feature of a pressure with a known law is found where the law has it.",
       measure_closed_form_features, 0.1},
      {"clinical/features/uncertainty", "clinical",
       "Features of noisy pressures scatter by the uncertainty that is stated with them.",
       measure_uncertain_features, 0.2},
      {"clinical/detection", "clinical",
       "The rule finds the losses that drop by more than its threshold, and no push of a thumb.",
       measure_detection, 1.0}};
}

}  // namespace palpate::clinical
