// SPDX-License-Identifier: MIT

#include "validation/comparison/comparison.hpp"

#include <algorithm>
#include <array>

#include "validation/number_text.hpp"

namespace palpate::comparison {

std::string_view unit_of(QuantityKind kind) { return kind == QuantityKind::pressure ? "Pa" : "N"; }
std::string_view name_of(QuantityKind kind) {
  constexpr std::array<std::string_view, 3> names{"pressure", "force", "insertion"};
  return names[static_cast<std::size_t>(kind)];
}

namespace {

FeatureSet set_of(QuantityKind kind) {
  return kind == QuantityKind::insertion ? FeatureSet::insertion : FeatureSet::loss_of_resistance;
}

/// Defaults for the features of an insertion; nothing published gives the spread of one rig.
std::vector<Tolerance> tolerances_of_insertion() {
  const std::string assumed =
      "assumption; with three recordings of a group, twice their standard deviation replaces it";
  return {{.feature = Feature::puncture, .absolute = 0.5, .origin = "as most recordings show"},
          {.feature = Feature::puncture_force, .relative = 0.20, .origin = assumed},
          {.feature = Feature::puncture_depth, .absolute = 1e-3, .origin = assumed},
          {.feature = Feature::denting_exponent, .absolute = 0.15, .origin = assumed},
          {.feature = Feature::force_left, .relative = 0.25, .origin = assumed},
          {.feature = Feature::largest_force, .relative = 0.20, .origin = assumed},
          {.feature = Feature::second_rise, .absolute = 0.2, .relative = 0.30, .origin = assumed},
          {.feature = Feature::relaxation, .absolute = 0.10, .origin = assumed},
          {.feature = Feature::relaxation_time, .factor = 1.5, .origin = assumed},
          {.feature = Feature::withdrawal_force, .relative = 0.25, .origin = assumed},
          {.feature = Feature::withdrawal_depth, .absolute = 3e-3, .origin = assumed}};
}

}  // namespace

std::span<const Feature> features_of(QuantityKind kind) { return features_of(set_of(kind)); }

double Tolerance::lower(double recorded) const {
  return factor > 1.0 ? recorded / factor : recorded - absolute - relative * std::abs(recorded);
}

double Tolerance::upper(double recorded) const {
  return factor > 1.0 ? recorded * factor : recorded + absolute + relative * std::abs(recorded);
}

std::vector<Tolerance> default_tolerances(QuantityKind kind) {
  if (kind == QuantityKind::insertion) { return tolerances_of_insertion(); }
  const std::string groups =
      "Wee et al. 2017: means of four groups, 376 to 461 mmHg, lie within 10.2 % of their middle "
      "and were not told apart (p = 0.52)";
  const std::string depth = "Segal et al. 1996: depth is predicted to within 8 mm";
  const std::string time = "assumption: half a second, felt as the same moment of an insertion";
  const Tolerance plateau = kind == QuantityKind::pressure
                                ? Tolerance{.feature = Feature::plateau,
                                            .absolute = 7.0 * pascals_per_mmhg,
                                            .origin =
                                                "Kim et al. 1996: epidural pressure of pregnant "
                                                "women sitting has an SD of 7 mmHg"}
                                : Tolerance{.feature = Feature::plateau,
                                            .absolute = 0.5,
                                            .origin = "assumption: no publication gives it"};
  constexpr double of_groups = (461.0 - 376.0) / (461.0 + 376.0);
  return {
      {.feature = Feature::loss_of_resistance, .origin = "both show it, or neither"},
      {.feature = Feature::peak, .relative = of_groups, .origin = groups},
      {.feature = Feature::drop_height,
       .relative = of_groups,
       .origin = groups + ", as of the peak"},
      {.feature = Feature::relative_drop,
       .absolute = 0.20,
       .origin = "Vaira et al. 2019: half the way from false (33 %) to true losses (73 %)"},
      {.feature = Feature::drop_time,
       .factor = 2.0,
       .origin = "assumption: falls take 50 to 200 ms, a factor of two about 100 ms"},
      plateau,
      {.feature = Feature::slope_before,
       .absolute = kind == QuantityKind::pressure ? 5.0 * pascals_per_mmhg : 0.1,
       .relative = 0.30,
       .origin = "assumption: no publication gives it"},
      {.feature = Feature::time_of_peak, .absolute = 0.5, .origin = time},
      {.feature = Feature::time_of_loss, .absolute = 0.5, .origin = time},
      {.feature = Feature::depth_of_peak, .absolute = 8e-3, .origin = depth},
      {.feature = Feature::depth_of_loss, .absolute = 8e-3, .origin = depth},
  };
}

std::string_view verdict_word(Status status) {
  constexpr std::array<std::string_view, 5> names{"agrees", "differs", "not distinguishable",
                                                  "not judged", "not comparable"};
  return names[static_cast<std::size_t>(status)];
}

double ValidationUncertainty::total() const {
  const double sum = numerical + input + data;
  return std::isnan(sum) ? sum : std::hypot(numerical, input, data);  // hypot(0, 0, NaN) may be 0
}

namespace {

/// Returns the time at which a depth is first reached [s]; absent if a gap hides it or it was
/// before the first sample.
std::optional<double> time_at_depth(const Samples& depth, double wanted) {
  for (std::size_t n = 0; n < depth.size(); ++n) {
    if (!(depth.value[n] >= wanted)) { continue; }
    if (depth.value[n] == wanted) { return depth.time(n); }
    if (n == 0 || !std::isfinite(depth.value[n - 1])) { return std::nullopt; }
    const double share = (wanted - depth.value[n - 1]) / (depth.value[n] - depth.value[n - 1]);
    return depth.time(n - 1) + share * depth.step;
  }
  return std::nullopt;
}

std::optional<double> depth_of_event(const Features& features) {
  const Measured& loss = features[Feature::depth_of_loss];
  return loss.value ? loss.value : features[Feature::depth_of_peak].value;
}

Alignment by_depth(const PreparedTrace& recorded, const PreparedTrace& simulated) {
  Alignment alignment{.used = AlignmentRule::depth};
  const std::vector<double> r = finite_only(recorded.input.depth.value);
  const std::vector<double> s = finite_only(simulated.input.depth.value);
  if (r.empty() || s.empty()) {
    alignment.refusal =
        r.empty() ? "the recording has no depth" : "the simulated trace has no depth";
    return alignment;
  }
  const double low = std::max(std::ranges::min(r), std::ranges::min(s));
  const double high = std::min(std::ranges::max(r), std::ranges::max(s));
  if (!(high > low)) {
    alignment.refusal = "recorded and simulated depths do not meet";
    return alignment;
  }
  double depth = depth_of_event(recorded.features).value_or(high + 1.0);
  const bool reached = depth <= high && depth >= low;
  if (!reached) { depth = 0.5 * (low + high); }
  const auto at_r = time_at_depth(recorded.input.depth, depth);
  const auto at_s = time_at_depth(simulated.input.depth, depth);
  const std::string text = formatted("%.1f mm", 1e3 * depth);
  if (!at_r || !at_s) {
    alignment.refusal = std::string("a gap hides when the ") + (at_r ? "simulated" : "recorded") +
                        " tip reached " + text;
    return alignment;
  }
  alignment.how = "by the depth of " + text +
                  (reached ? ", that of the recorded event" : ", the middle of what both passed");
  alignment.lag = *at_r - *at_s;
  alignment.uncertainty =
      std::hypot(recorded.input.depth.step, simulated.input.depth.step) / std::sqrt(12.0);
  return alignment;
}

Alignment by_event(const PreparedTrace& recorded, const PreparedTrace& simulated) {
  Alignment alignment{.used = AlignmentRule::event, .how = "by the loss of resistance"};
  const Measured* r = &recorded.features[Feature::time_of_loss];
  const Measured* s = &simulated.features[Feature::time_of_loss];
  if (!r->value || !s->value) {
    alignment.how = "by the peak, as not both show a loss of resistance";
    r = &recorded.features[Feature::time_of_peak];
    s = &simulated.features[Feature::time_of_peak];
  }
  if (!r->value || !s->value) {
    alignment.refusal = "neither event nor peak is in both";
    return alignment;
  }
  alignment.lag = *r->value - *s->value;
  alignment.uncertainty = std::hypot(r->uncertainty, s->uncertainty);
  return alignment;
}

Alignment by_start(const PreparedTrace& recorded, const PreparedTrace& simulated) {
  return {.used = AlignmentRule::start,
          .how = "by the first samples",
          .lag = recorded.input.raw.start - simulated.input.raw.start};
}

Alignment by_contact(const PreparedTrace& recorded, const PreparedTrace& simulated) {
  Alignment alignment{.used = AlignmentRule::contact, .how = "by the contact"};
  const InsertionPhases& r = recorded.features.phases;
  const InsertionPhases& s = simulated.features.phases;
  if (!r.contact || !s.contact) {
    alignment.refusal = std::string("no contact in the ") +
                        (r.contact ? "simulated trace" : "recording") +
                        ", which needs a depth and a force";
    return alignment;
  }
  alignment.lag = *r.contact_time.value - *s.contact_time.value;
  alignment.uncertainty = std::hypot(r.contact_time.uncertainty, s.contact_time.uncertainty);
  constexpr double same_speed = 0.05;  // relative; a faster curve is another curve over time
  if (std::abs(s.speed - r.speed) > same_speed * r.speed) {
    alignment.how += formatted(", at different speeds (%.3g mm/s recorded, %.3g mm/s simulated)",
                               1e3 * r.speed, 1e3 * s.speed);
  }
  return alignment;
}

}  // namespace

std::string_view name_of(AlignmentRule rule) {
  constexpr std::array<std::string_view, 6> names{"automatic", "depth",   "event",
                                                  "start",     "contact", "clock"};
  return names[static_cast<std::size_t>(rule)];
}

Alignment align(const PreparedTrace& recorded, const PreparedTrace& simulated, AlignmentRule rule) {
  if (rule == AlignmentRule::clock) { return {.used = rule, .how = "as recorded, not shifted"}; }
  if (rule == AlignmentRule::start) { return by_start(recorded, simulated); }
  if (rule == AlignmentRule::contact) { return by_contact(recorded, simulated); }
  if (rule == AlignmentRule::event) { return by_event(recorded, simulated); }
  const Alignment deep = by_depth(recorded, simulated);
  if (rule == AlignmentRule::depth || deep.refusal.empty()) { return deep; }
  const Alignment event = by_event(recorded, simulated);
  Alignment other = event.refusal.empty() ? event : by_start(recorded, simulated);
  const bool both_have_depth =
      !recorded.input.depth.value.empty() && !simulated.input.depth.value.empty();
  if (both_have_depth) {
    other.not_by_depth = deep.refusal;
    other.how += ", not by depth: " + deep.refusal;
  }
  return other;
}

namespace {

/// Returns true for a force of an insertion, which an offset of the sensor moves.
bool is_force(Feature feature) {
  return feature == Feature::puncture_force || feature == Feature::force_left ||
         feature == Feature::largest_force || feature == Feature::withdrawal_force;
}

/// Returns true if a gain of the trace scales the feature.
bool scales(Feature feature) {
  return feature == Feature::peak || feature == Feature::plateau ||
         feature == Feature::drop_height || feature == Feature::slope_before ||
         feature == Feature::second_rise || is_force(feature);
}

/// Returns the change of the feature per unit of offset of the trace.
double moved_by_offset(Feature feature, const Features& features) {
  if (feature == Feature::peak || feature == Feature::plateau || is_force(feature)) { return 1.0; }
  if (feature == Feature::relative_drop) {
    return features.loss.relative_drop / features.loss.peak;
  }
  return 0.0;
}

ValidationUncertainty uncertainty_of(const FeatureComparison& one, const Comparison& comparison,
                                     const ComparisonOptions& options) {
  const double size = std::abs(*one.simulated.value);
  const bool by_model = scales(one.feature);
  const double lag = is_time(one.feature) ? comparison.alignment.uncertainty : 0.0;
  return {.numerical = std::hypot(one.simulated.uncertainty,
                                  by_model ? options.uncertainties.numerical * size : 0.0),
          .input = by_model ? options.uncertainties.input * size : 0.0,
          .data = std::hypot(data_uncertainty(one.feature, comparison.recorded_features, options),
                             lag)};
}

std::string reason_of_absence(const FeatureComparison& one) {
  if (one.recorded.value) { return "simulated: " + one.simulated.reason; }
  if (one.simulated.value) { return "recorded: " + one.recorded.reason; }
  if (one.recorded.reason == one.simulated.reason) { return "in neither: " + one.recorded.reason; }
  return "recorded: " + one.recorded.reason + "; simulated: " + one.simulated.reason;
}

FeatureComparison compare_feature(Feature feature, const Comparison& comparison,
                                  const ComparisonOptions& options) {
  FeatureComparison one{.feature = feature,
                        .recorded = comparison.recorded_features[feature],
                        .simulated = comparison.simulated_features[feature],
                        .tolerance = tolerance_of(feature, options)};
  one.quantity.name = name_of(feature);
  one.quantity.unit = unit_of(feature, comparison.unit);
  if (is_time(feature) && one.recorded.value) { *one.recorded.value -= comparison.alignment.lag; }
  if (is_time(feature) && !comparison.alignment.judges_times()) {
    one.reason =
        "the clocks were aligned by the " + std::string(name_of(comparison.alignment.used));
    if (one.recorded.value && one.simulated.value) {
      one.error = *one.simulated.value - *one.recorded.value;
    }
    return one;
  }
  if (one.recorded.value && one.simulated.value) {
    one.uncertainty = uncertainty_of(one, comparison, options);
    judge_difference(one, *one.recorded.value, *one.simulated.value,
                     options.uncertainties.coverage_factor);
  } else {
    one.reason = reason_of_absence(one);
    // The event is never just absent: it is found, not found or undecided. It explains the
    // features that are missing with it.
    one.status = feature == Feature::loss_of_resistance ? Status::inconclusive : Status::skip;
  }
  return one;
}

}  // namespace

void judge_difference(FeatureComparison& one, double recorded, double simulated,
                      double coverage_factor) {
  one.error = simulated - recorded;
  Quantity& q = one.quantity;
  q.value = simulated;
  q.lower = one.tolerance.lower(recorded);
  q.upper = one.tolerance.upper(recorded);
  q.bound_from = one.tolerance.origin;
  q.uncertainty = coverage_factor * one.uncertainty.total();
  one.below_uncertainty = std::abs(one.error) < one.uncertainty.total();
  const bool finite = std::isfinite(q.value) && std::isfinite(q.lower) && std::isfinite(q.upper) &&
                      std::isfinite(q.uncertainty);
  one.status = finite ? q.status() : Status::error;
}

Reason reason_of(const FeatureComparison& one) {
  const bool told = one.status != Status::pass && one.status != Status::skip;
  return {one.status, told ? sentence_of(one) : std::string()};
}

Tolerance tolerance_of(Feature feature, const ComparisonOptions& options) {
  const auto given = std::ranges::find(options.tolerances, feature, &Tolerance::feature);
  if (given != options.tolerances.end()) { return *given; }
  const std::vector<Tolerance> defaults = default_tolerances(options.quantity);
  return *std::ranges::find(defaults, feature, &Tolerance::feature);
}

double data_uncertainty(Feature feature, const Features& recorded,
                        const ComparisonOptions& options) {
  const Uncertainties& known = options.uncertainties;
  const Measured& measured = recorded[feature];
  const double zero =
      options.quantity == QuantityKind::pressure ? known.transducer.zero : known.zero_force;
  const double gain =
      scales(feature) ? known.transducer.gain * std::abs(measured.value.value_or(0.0)) : 0.0;
  return std::hypot(measured.uncertainty,
                    std::hypot(moved_by_offset(feature, recorded) * zero, gain));
}

std::vector<FeatureComparison> compare_features(const Comparison& comparison,
                                                const ComparisonOptions& options) {
  std::vector<FeatureComparison> all;
  for (const Feature feature : features_of(options.quantity)) {
    all.push_back(compare_feature(feature, comparison, options));
  }
  return all;
}

namespace {

/// Returns the unit for readers; relative drops are in percent.
FieldUnit unit_for(Feature feature, std::string_view unit) {
  const bool share = feature == Feature::relative_drop || feature == Feature::relaxation;
  return share ? FieldUnit{100.0, "%"} : field_unit(unit);
}

/// Returns a number with its unit; shares and exponents of the unit 1 have none.
std::string with_unit(double value, const FieldUnit& unit) {
  return unit.name == "1" ? short_number(value) : quantity(value, unit.name);
}

/// Rounds to a ten-thousandth of the unit, which hides rounding such as 10^-14 mmHg.
double in_unit(double value, const FieldUnit& unit) {
  return std::round(1e4 * unit.factor * value) / 1e4 + 0.0;  // no negative zero
}

}  // namespace

std::string in_words(Feature feature) {
  std::string words(name_of(feature));
  std::ranges::replace(words, '_', ' ');
  return words;
}

std::string shown(Feature feature, double value, std::string_view unit) {
  if (std::isnan(value)) { return "-"; }
  if (is_event(feature)) { return value > 0.5 ? "found" : "not found"; }
  const FieldUnit field = unit_for(feature, unit);
  return with_unit(in_unit(value, field), field);
}

std::string shown_interval(Feature feature, const Interval& interval, std::string_view unit) {
  const FieldUnit field = unit_for(feature, unit);
  return short_number(in_unit(interval.lower, field)) + " to " +
         with_unit(in_unit(interval.upper, field), field);
}

std::string shown_uncertainty(const FeatureComparison& one) {
  const double expanded = one.quantity.uncertainty;
  if (!(expanded > 0.0) || is_event(one.feature)) { return {}; }
  const FieldUnit field = unit_for(one.feature, one.quantity.unit);
  return "±" + short_number(field.factor * expanded, 2) +
         (field.name == "1" ? "" : "\u00a0" + field.name);
}

std::string shown(const Tolerance& tolerance, std::string_view unit) {
  if (tolerance.factor > 1.0) { return "a factor of " + short_number(tolerance.factor); }
  std::string text;
  if (tolerance.relative > 0.0) { text = short_number(100.0 * tolerance.relative, 3) + "\u00a0%"; }
  if (tolerance.absolute > 0.0) {
    text += (text.empty() ? "" : " and ") + shown(tolerance.feature, tolerance.absolute, unit);
  }
  return text.empty() ? "the same" : text;
}

std::string sentence_of(const FeatureComparison& one) {
  const std::string name = in_words(one.feature) + ": ";
  const std::string verdict = ": " + std::string(verdict_word(one.status));
  if (!one.reason.empty()) { return name + one.reason + verdict; }
  if (is_event(one.feature)) {
    return name + shown(one.feature, *one.simulated.value, {}) + " in the simulated trace, " +
           shown(one.feature, *one.recorded.value, {}) + " in the recorded one" + verdict;
  }
  const Quantity& q = one.quantity;
  const std::string known = shown_uncertainty(one);
  return name + shown(one.feature, *one.simulated.value, q.unit) + " simulated, " +
         shown(one.feature, *one.recorded.value, q.unit) + " recorded; " +
         shown_interval(one.feature, {q.lower, q.upper}, q.unit) + " allowed" +
         (known.empty() ? "" : ", known to " + known) + verdict;
}

namespace {

Comparison refuse(Comparison comparison, const std::string& reason) {
  comparison.outcome.status = Status::error;
  comparison.outcome.reasons = {reason};
  return comparison;
}

std::string regime_refusal(const Recording& recording, const ComparisonOptions& options) {
  if (options.quantity != QuantityKind::pressure || recording.regime == options.simulated_regime) {
    return {};
  }
  const auto text = [](Recording::Regime regime) {
    return regime == Recording::Regime::thumb ? "thumb" : "pump";
  };
  return std::string("wrong regime: recorded with a ") + text(recording.regime) +
         " on the plunger, simulated with a " + text(options.simulated_regime);
}

Samples moved(Samples samples, double by) {
  samples.start += by;
  return samples;
}

/// Resamples both to the grid of the recording where they overlap, on the clock of the simulation.
void lay_on_grid(const PreparedTrace& recorded, const PreparedTrace& simulated,
                 const ComparisonOptions& options, Comparison& comparison) {
  const double lag = comparison.alignment.lag;
  const Samples& r = recorded.input.raw;
  const Samples& s = simulated.input.raw;
  double begin = std::max(r.start - lag, s.start);
  // The force before the contact is zero in both traces and is not compared.
  const auto& contact = simulated.features.phases.contact_time.value;
  if (contact) { begin = std::max(begin, *contact); }
  const double end = std::min(r.end() - lag, s.end());
  const double step = std::max(
      {r.step, 1.0 / options.grid_rate, (end - begin) / static_cast<double>(options.most_samples)});
  const Grid grid = grid_between(begin, end, r.start - lag, step);
  comparison.recorded = resample(moved(recorded.input.filtered, -lag), grid);
  comparison.recorded_raw = resample(moved(r, -lag), grid);
  comparison.simulated = resample(simulated.input.filtered, grid);
  comparison.simulated_raw = resample(s, grid);
}

constexpr std::size_t least_common = 20;  // samples of both

std::string overlap_refusal(double overlap, std::size_t samples, const ComparisonOptions& options) {
  if (samples == 0) { return "no overlap in time"; }
  return "no overlap in time but for " + short_number(overlap) + " s in " +
         std::to_string(samples) + " samples; " + short_number(options.least_overlap) + " s in " +
         std::to_string(least_common) + " are needed";
}

/// Returns the force of the advance at depths below the contact; NaN across more than 0.5 mm.
Samples over_depth(const PreparedTrace& prepared) {
  constexpr double step = 1e-4;       // [m]
  constexpr double longest = 0.5e-3;  // [m] without a sample
  Samples advance{.start = 0.0, .step = step};
  const InsertionPhases& phases = prepared.features.phases;
  if (!phases.contact) { return advance; }
  const std::vector<double>& force = prepared.input.filtered.value;
  const std::vector<double>& depth = prepared.input.depth.value;
  const double contact = *phases.contact_depth.value;
  double last_depth = 0.0;
  double last_force = force[*phases.contact];
  for (std::size_t n = *phases.contact; n <= phases.advance_end; ++n) {
    const double here = depth[n] - contact;
    if (!std::isfinite(force[n]) || !(here >= last_depth)) { continue; }
    while (step * static_cast<double>(advance.size()) <= here) {
      const double at = step * static_cast<double>(advance.size());
      const double share = here > last_depth ? (at - last_depth) / (here - last_depth) : 1.0;
      advance.value.push_back(here - last_depth <= longest ? std::lerp(last_force, force[n], share)
                                                           : not_measured);
    }
    last_depth = here;
    last_force = force[n];
  }
  return advance;
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
  comparison.unfiltered_rating =
      rate_stretch(comparison.simulated_raw, comparison.recorded_raw, stretch);
  comparison.rated = static_cast<double>(stretch.size()) / static_cast<double>(both.size());
}

void conclude(Comparison& comparison) {
  std::vector<Reason> parts;
  for (const FeatureComparison& one : comparison.features) {
    parts.push_back(reason_of(one));
    if (one.quantity.judged()) { comparison.outcome.quantities.push_back(one.quantity); }
  }
  palpate::conclude(comparison.outcome, std::move(parts));
  if (comparison.outcome.status == Status::skip) {
    comparison = refuse(std::move(comparison), "no feature is in both");
  }
  comparison.only_curve_differs = comparison.outcome.status == Status::pass && comparison.rating &&
                                  grade_of(comparison.rating->overall) == "poor";
  if (!comparison.only_curve_differs) { return; }
  comparison.outcome.status = Status::fail;
  comparison.outcome.reasons = {
      std::string(only_curve_text) +
      formatted(": rated %.2f of 1, poor (ISO/TS 18571)", comparison.rating->overall)};
}

}  // namespace

const FeatureComparison& Comparison::of(Feature feature) const {
  return *std::ranges::find(features, feature, &FeatureComparison::feature);
}

void judge_again(Comparison& comparison, const ComparisonOptions& options) {
  comparison.features = compare_features(comparison, options);
  comparison.outcome.quantities.clear();
  conclude(comparison);
}

std::string column_of(const ComparisonOptions& options) {
  if (!options.column.empty()) { return options.column; }
  return options.quantity == QuantityKind::pressure ? "syringe.pressure_pa" : "tool.force_n";
}

std::string depth_column_of(const ComparisonOptions& options, const Trace& simulated) {
  if (!options.depth_column.empty()) { return options.depth_column; }
  constexpr const char* along_needle = "tool.insertion_m";
  const bool path =
      options.quantity == QuantityKind::insertion && simulated.find(along_needle) != nullptr;
  return path ? along_needle : "tool.depth_m";
}

Comparison compare(const Recording& recording, const Trace& simulated,
                   const ComparisonOptions& options) {
  Comparison comparison{.recording = recording.name,
                        .group = recording.group,
                        .subject = recording.subject,
                        .kind = recording.kind,
                        .outcome = {.name = recording.name,
                                    .suite = "comparison",
                                    .claim = "The simulated insertion agrees with the recording.",
                                    .status = Status::error},
                        .unit = std::string(unit_of(options.quantity))};
  if (const std::string wrong = regime_refusal(recording, options); !wrong.empty()) {
    return refuse(comparison, wrong);
  }
  if (simulated.find(column_of(options)) == nullptr) {
    return refuse(comparison, "the simulated trace has no column " + column_of(options));
  }
  const bool by_pressure = options.quantity == QuantityKind::pressure;
  if (!by_pressure && recording.force.empty()) {
    return refuse(comparison, "force along the needle was not recorded");
  }
  if (by_pressure && recording.pressure.empty() && !recording.force.empty()) {
    return refuse(comparison, "pressure was not recorded");
  }
  const RawTrace recorded_raw{recording.time, by_pressure ? recording.pressure : recording.force,
                              recording.depth};
  const Column* depth = simulated.find(depth_column_of(options, simulated));
  const RawTrace simulated_raw{simulated.time, simulated.values(column_of(options)),
                               depth != nullptr ? depth->values : std::span<const double>{}};
  // A quarter of the lower rate preserves the shape of the filter.
  const double slowest =
      std::max(usual_interval(recorded_raw.time), usual_interval(simulated_raw.time));
  comparison.cutoff = std::min(options.cutoff, 0.25 / slowest);
  FeatureRule rule = options.features;
  rule.set = set_of(options.quantity);
  const PreparedTrace r = prepare(recorded_raw, comparison.cutoff, rule);
  const PreparedTrace s = prepare(simulated_raw, comparison.cutoff, rule);
  if (!r.refusal.empty()) { return refuse(comparison, "the recording " + r.refusal); }
  if (!s.refusal.empty()) { return refuse(comparison, "the simulated trace " + s.refusal); }
  const bool by_contact =
      options.quantity == QuantityKind::insertion && options.alignment == AlignmentRule::automatic;
  comparison.alignment = align(r, s, by_contact ? AlignmentRule::contact : options.alignment);
  if (!comparison.alignment.refusal.empty()) {
    return refuse(comparison, comparison.alignment.refusal);
  }
  lay_on_grid(r, s, options, comparison);
  const std::vector<double> both = finite_only(jointly(comparison.recorded, comparison.simulated));
  comparison.overlap = comparison.recorded.step * static_cast<double>(both.size());
  if (both.size() < least_common || comparison.overlap < options.least_overlap) {
    return refuse(comparison, overlap_refusal(comparison.overlap, both.size(), options));
  }
  comparison.recorded_advance = over_depth(r);
  comparison.simulated_advance = over_depth(s);
  comparison.recorded_features = r.features;
  comparison.simulated_features = s.features;
  comparison.features = compare_features(comparison, options);
  explain(comparison);
  conclude(comparison);
  return comparison;
}

}  // namespace palpate::comparison
