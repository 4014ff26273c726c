// SPDX-License-Identifier: MIT
/// Features of pressures whose law is known, and the reasons for those that are not there.
#include <cmath>

#include "validation/cases/clinical_parts.hpp"
#include "validation/cases/clinical_traces.hpp"
#include "validation/comparison/prepared_trace.hpp"

namespace palpate::clinical {

namespace {

using namespace comparison;

constexpr double nine_tenths_to_one_tenth = 2.1972245773362196;  // ln 9

Features features_at(const CaseContext& context, const PressureLaw& law, double rate, double cutoff) {
  const std::vector<double> time = instants(14.0, rate);
  std::vector<double> pressure = pressures(law, time);
  damage(context, pressure);
  return prepare({.time = time, .value = pressure}, cutoff, {}).features;
}

void judge_feature_value(Outcome& outcome, const Features& found, Feature feature, double expected,
                         double within, const std::string& from) {
  outcome.judge({.name = std::string(name_of(feature)), .value = found[feature].value.value_or(not_measured),
                 .unit = unit_of(feature, "Pa"), .lower = expected - within, .upper = expected + within,
                 .bound_from = from});
}

/// At 1 kHz and unfiltered: the law is between its samples by no more than a chord leaves.
void measure_closed_form_features(const CaseContext& context, Outcome& outcome) {
  const PressureLaw law;
  const Features found = features_at(context, law, 1000.0, 0.0);
  const double step = 1e-3;
  const double chord = step * step / (8.0 * law.fall_constant);  // [s] of a crossing of the exponential
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
  judge_feature_value(outcome, found, Feature::drop_time, nine_tenths_to_one_tenth * law.fall_constant,
                      2.0 * chord + 10.0 * depth * law.fall_constant, from);
  judge_feature_value(outcome, found, Feature::time_of_loss, law.loss + law.fall_constant * std::log(2.0),
                      chord + 2.0 * depth * law.fall_constant, from);
  judge_feature_value(outcome, found, Feature::time_of_peak, law.loss, 1e-9,
                      "closed form, a sample lies on it");
  const double slope = (law.peak - law.level) / (law.loss - law.rise);
  judge_feature_value(outcome, found, Feature::slope_before, slope, 1e-9 * slope,
                      "closed form: a straight rise");
}

/// With noise, at the rate of the link: found to within what is stated as its uncertainty.
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
      const double off = m.value.value_or(not_measured) - clean[watched[i]].value.value_or(not_measured);
      square[i] += std::pow(off / m.uncertainty, 2) / trials;
    }
  }
  outcome.judge(
      {.name = "noise_found_over_noise_added",
       .value = noise,
       .lower = 0.95,
       .upper = 1.05,
       .bound_from = "theory; the median of 1600 samples is known to 2 %, and the event adds to it"});
  for (std::size_t i = 0; i < watched.size(); ++i) {
    outcome.judge({.name = "spread_over_uncertainty: " + std::string(name_of(watched[i])),
                   .value = std::sqrt(square[i]),
                   .lower = 0.5,
                   .upper = 1.2225,
                   .bound_from = "1 if the uncertainty is right; up to sqrt(149.4 / 100) over 100 trials (chi"
                                 " square, 0.999), and at most twice too cautious (assumed)"});
  }
}

}  // namespace

std::vector<Case> feature_cases() {
  return {{.name = "clinical/features/closed-form",
           .suite = "clinical",
           .claim = "Every feature of a pressure with a known law is found where the law has it.",
           .measure = measure_closed_form_features,
           .weight = 0.1},
          {.name = "clinical/features/uncertainty",
           .suite = "clinical",
           .claim = "Features of noisy pressures scatter by the uncertainty that is stated with them.",
           .measure = measure_uncertain_features,
           .weight = 0.2}};
}

}  // namespace palpate::clinical
