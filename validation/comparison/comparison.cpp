// SPDX-License-Identifier: MIT
#include "validation/comparison/comparison.hpp"

#include <algorithm>
#include <cmath>

#include "validation/comparison/feature_verdict.hpp"
#include "validation/comparison/feature_words.hpp"
#include "validation/comparison/zero_phase.hpp"
#include "validation/number_words.hpp"

namespace palpate::comparison {

namespace {

Comparison refuse(Comparison comparison, const std::string& reason) {
  comparison.verdict = Verdict::not_comparable;
  comparison.reasons = {reason};
  return comparison;
}

RawTrace recorded_trace(const Recording& recording, QuantityKind quantity) {
  return {recording.time, quantity == QuantityKind::pressure ? recording.pressure : recording.force,
          recording.depth};
}

RawTrace simulated_trace(const Trace& trace, const ComparisonOptions& options) {
  const Column* value = trace.find(column_of(options));
  const Column* depth = trace.find(options.depth_column);
  RawTrace raw{.time = trace.time};
  if (value != nullptr) { raw.value = value->values; }
  if (depth != nullptr) { raw.depth = depth->values; }
  return raw;
}

/// The same cut-off for both: a quarter of the lower rate leaves every filter its shape.
double common_cutoff(const RawTrace& a, const RawTrace& b, double wanted) {
  const double slowest = std::max(usual_interval(a.time), usual_interval(b.time));
  return std::min(wanted, 0.25 / slowest);
}

std::string regime_refusal(const Recording& recording, const ComparisonOptions& options) {
  if (options.quantity != QuantityKind::pressure || recording.regime == options.simulated_regime) {
    return {};
  }
  const auto text = [](Recording::Regime regime) {
    return std::string(regime == Recording::Regime::thumb ? "thumb" : "pump");
  };
  return "wrong regime: recorded with a " + text(recording.regime) + " on the plunger, simulated with a " +
         text(options.simulated_regime);
}

Samples moved(Samples samples, double by) {
  samples.start += by;
  return samples;
}

/// Both on the grid of the recording's samples where they overlap, on the simulation's clock.
void lay_on_grid(const PreparedTrace& recorded, const PreparedTrace& simulated,
                 const ComparisonOptions& options, Comparison& comparison) {
  const double lag = comparison.alignment.lag;
  const Samples& r = recorded.input.raw;
  const Samples& s = simulated.input.raw;
  const double begin = std::max(r.start - lag, s.start);
  const double end = std::min(r.end() - lag, s.end());
  const double step = std::max({r.step, 1.0 / options.grid_rate,
                                (end - begin) / static_cast<double>(options.most_samples)});
  const Grid grid = grid_between(begin, end, r.start - lag, step);
  comparison.recorded = resample(moved(recorded.input.filtered, -lag), grid);
  comparison.recorded_raw = resample(moved(r, -lag), grid);
  comparison.simulated = resample(simulated.input.filtered, grid);
  comparison.simulated_raw = resample(s, grid);
}

constexpr std::size_t least_common = 20;  // samples of both

std::string overlap_refusal(double overlap, std::size_t samples, const ComparisonOptions& options) {
  if (samples == 0) { return "no overlap in time"; }
  return "no overlap in time but for " + short_number(overlap) + " s in " + std::to_string(samples) +
         " samples; " + short_number(options.least_overlap) + " s in " + std::to_string(least_common) +
         " are needed";
}

std::vector<double> jointly(const Samples& a, const Samples& b) {
  std::vector<double> both(a.size());
  for (std::size_t n = 0; n < both.size(); ++n) { both[n] = a.value[n] + b.value[n]; }
  return both;
}

std::optional<IsoRating> rate_stretch(const Samples& simulated, const Samples& recorded,
                                      const Stretch& stretch) {
  if (stretch.size() < 10) { return std::nullopt; }
  const auto part = [&](const Samples& s) {
    return std::span<const double>(s.value).subspan(stretch.begin, stretch.size());
  };
  return rate(part(simulated), part(recorded));
}

void explain(Comparison& comparison) {
  const std::vector<double> both = jointly(comparison.recorded, comparison.simulated);
  const Stretch stretch = longest_stretch(both);
  comparison.errors = trace_errors(comparison.simulated.value, comparison.recorded.value);
  comparison.rating = rate_stretch(comparison.simulated, comparison.recorded, stretch);
  comparison.unfiltered_rating = rate_stretch(comparison.simulated_raw, comparison.recorded_raw, stretch);
  comparison.rated = static_cast<double>(stretch.size()) / static_cast<double>(both.size());
}

void conclude(Comparison& comparison) {
  comparison.verdict = Verdict::not_judged;
  std::vector<Reason> reasons;
  for (const FeatureVerdict& one : comparison.features) {
    comparison.verdict = worse(comparison.verdict, one.verdict);
    if (one.verdict != Verdict::agrees && one.verdict != Verdict::not_judged) {
      reasons.push_back({one.verdict, sentence_of(one)});
    }
  }
  comparison.reasons = worst_first(std::move(reasons));
  if (comparison.verdict == Verdict::not_judged) {
    comparison = refuse(std::move(comparison), "no feature is in both");
  }
}

}  // namespace

std::string column_of(const ComparisonOptions& options) {
  if (!options.column.empty()) { return options.column; }
  return options.quantity == QuantityKind::pressure ? "syringe.pressure_pa" : "tool.force_n";
}

Comparison compare(const Recording& recording, const Trace& simulated, const ComparisonOptions& options) {
  Comparison comparison{.recording = recording.name, .group = recording.group,
                        .subject = recording.subject, .kind = recording.kind,
                        .unit = std::string(unit_of(options.quantity))};
  if (const std::string wrong = regime_refusal(recording, options); !wrong.empty()) {
    return refuse(comparison, wrong);
  }
  if (simulated.find(column_of(options)) == nullptr) {
    return refuse(comparison, "the simulated trace has no column " + column_of(options));
  }
  if (options.quantity == QuantityKind::force && recording.force.empty()) {
    return refuse(comparison, "force along the needle was not recorded");
  }
  const RawTrace recorded_raw = recorded_trace(recording, options.quantity);
  const RawTrace simulated_raw = simulated_trace(simulated, options);
  comparison.cutoff = common_cutoff(recorded_raw, simulated_raw, options.cutoff);
  const PreparedTrace r = prepare(recorded_raw, comparison.cutoff, options.features);
  const PreparedTrace s = prepare(simulated_raw, comparison.cutoff, options.features);
  if (!r.refusal.empty()) { return refuse(comparison, "the recording " + r.refusal); }
  if (!s.refusal.empty()) { return refuse(comparison, "the simulated trace " + s.refusal); }
  comparison.alignment = align(r, s, options.alignment);
  if (!comparison.alignment.refusal.empty()) { return refuse(comparison, comparison.alignment.refusal); }
  lay_on_grid(r, s, options, comparison);
  const std::vector<double> both = finite_only(jointly(comparison.recorded, comparison.simulated));
  comparison.overlap = comparison.recorded.step * static_cast<double>(both.size());
  if (both.size() < least_common || comparison.overlap < options.least_overlap) {
    return refuse(comparison, overlap_refusal(comparison.overlap, both.size(), options));
  }
  comparison.recorded_features = r.features;
  comparison.simulated_features = s.features;
  comparison.features = judge_features(comparison, options);
  explain(comparison);
  conclude(comparison);
  return comparison;
}

}  // namespace palpate::comparison
