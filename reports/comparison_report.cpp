// SPDX-License-Identifier: MIT

#include "reports/comparison_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "fixtures/io/csv_file.hpp"
#include "fixtures/io/problems.hpp"
#include "fixtures/io/recording_file.hpp"
#include "model/problem/input_error.hpp"
#include "reports/html/html_page.hpp"
#include "reports/plot/trace_figures.hpp"
#include "reports/results/results_json.hpp"

namespace palpate {

using namespace comparison;

namespace {

void append_part(std::string& text, const std::string& part) {
  text += (text.empty() ? "" : ", ") + part;
}

std::size_t count_of(const ComparisonReport& report, Recording::Kind kind) {
  const auto of = [](const RecordingFile& one) { return one.input.recording.kind; };
  return static_cast<std::size_t>(std::ranges::count(report.recordings, kind, of));
}

std::size_t count_of(const ComparisonReport& report, Status status) {
  const auto of = [](const Comparison& one) { return one.outcome.status; };
  return static_cast<std::size_t>(std::ranges::count(report.found.recordings, status, of));
}

bool only_phantoms(const ComparisonReport& report) {
  return count_of(report, Recording::Kind::measured_phantom) == report.recordings.size();
}

/// Kinds of recording with their counts: "3 measured recordings".
std::string kinds_of(const ComparisonReport& report) {
  std::string text;
  const auto add = [&](Recording::Kind kind, const std::string& one, const std::string& many) {
    const std::size_t count = count_of(report, kind);
    if (count > 0) { text += (text.empty() ? "" : " and ") + counted(count, one, many); }
  };
  const std::string rebuilt(io::reconstruction_note);
  add(Recording::Kind::measured, "measured recording", "measured recordings");
  add(Recording::Kind::measured_phantom, "recording of a measured phantom",
      "recordings of a measured phantom");
  add(Recording::Kind::reconstructed, "recording " + rebuilt, "recordings " + rebuilt);
  return text;
}

std::size_t subjects_compared(const ComparisonReport& report) {
  std::size_t count = 0;
  for (const GroupSummary& group : report.found.groups) { count += group.subjects; }
  return count;
}

std::string name_of_group(const std::string& group) {
  return group.empty() ? "without a group" : group;
}

std::string honesty(const Recording& recording) {
  if (recording.kind == Recording::Kind::measured) { return {}; }
  if (recording.kind == Recording::Kind::measured_phantom) {
    return " Recorded: measured phantom, no patient.";
  }
  return " Recorded: " + std::string(io::reconstruction_note) + ", not measured.";
}

std::vector<double> scaled(std::span<const double> values, double factor, double offset = 0.0) {
  std::vector<double> out;
  out.reserve(values.size());
  for (const double value : values) { out.push_back(factor * value + offset); }
  return out;
}

std::vector<double> times_of(const Samples& samples) {
  std::vector<double> time;
  time.reserve(samples.size());
  for (std::size_t n = 0; n < samples.size(); ++n) { time.push_back(samples.time(n)); }
  return time;
}

std::vector<double> difference(const Samples& a, const Samples& b, double factor) {
  std::vector<double> out(a.size());
  for (std::size_t n = 0; n < out.size(); ++n) { out[n] = factor * (a.value[n] - b.value[n]); }
  return out;
}

FieldUnit unit_of_report(const ComparisonReport& report) {
  return field_unit(comparison::unit_of(report.options.comparison.quantity));
}

std::string label_of(const std::string& what, std::string_view unit) {
  return what + " (" + std::string(unit) + ")";
}

/// Figure of one recording and the simulation; every series is labelled with its origin.
struct Overlay {
  const ComparisonReport& report;
  std::size_t index;
  Over over;
  Figure figure{};

  [[nodiscard]] const Recording& recording() const {
    return report.recordings[index].input.recording;
  }
  void add_recorded(const std::string& label, const std::vector<double>& values, double factor,
                    Series::Style style = Series::Style::line) {
    if (values.empty()) { return; }
    const double lag = report.found.recordings[index].alignment.lag;
    figure.series.push_back({.label = label,
                             .style = style,
                             .x = over == Over::time ? scaled(recording().time, 1.0, -lag)
                                                     : scaled(recording().depth, mm),
                             .y = scaled(values, factor)});
  }
  void add_simulated(const std::string& label, const char* column, double factor,
                     Series::Style style = Series::Style::line) {
    add_column(figure, report.simulation.trace, over, column, label, factor, style);
  }
};

std::string over_id(Over over) { return over == Over::time ? "-over-time" : "-over-depth"; }
std::string over_text(Over over) { return over == Over::time ? " over time" : " over depth"; }

std::string clocks(const Comparison& one) {
  return " Clocks aligned " + one.alignment.how + "; recorded - simulated " +
         quantity(one.alignment.lag, "s") + ".";
}

Figure pressure_figure(const ComparisonReport& report, std::size_t n, Over over) {
  Overlay overlay{report, n, over};
  overlay.figure =
      figure_over(report.simulation.trace, over, "pressure" + over_id(over),
                  "Saline pressure" + over_text(over),
                  "As sampled; the tints are the layers that the simulated tip is in." +
                      (over == Over::time ? clocks(report.found.recordings[n]) : "") +
                      honesty(overlay.recording()),
                  "pressure (mmHg)");
  const double factor = 1.0 / pascals_per_mmhg;
  overlay.add_recorded("recorded", overlay.recording().pressure, factor);
  overlay.add_simulated("simulated", "syringe.pressure_pa", factor);
  return std::move(overlay.figure);
}

/// Force along the needle, and force on the plunger (pressure times area).
Figure force_figure(const ComparisonReport& report, std::size_t n, Over over) {
  Overlay overlay{report, n, over};
  const Recording& recording = overlay.recording();
  overlay.figure = figure_over(
      report.simulation.trace, over, "force" + over_id(over), "Reaction force" + over_text(over),
      (recording.pressure.empty()
           ? std::string("Resisting the needle.")
           : "Resisting the needle, and the thumb: recorded pressure times a plunger of " +
                 quantity(1e6 * recording.plunger_area, "mm²") + ".") +
          (recording.force.empty() ? " Force along the needle was not recorded." : "") +
          honesty(recording),
      "force (N)");
  const auto add_plunger = [&] {
    overlay.add_recorded("on the plunger, recorded", recording.pressure, recording.plunger_area,
                         Series::Style::dashed);
  };
  // A recorded series is first, so that it keeps its colour.
  overlay.add_recorded("along the needle, recorded", recording.force, 1.0);
  if (recording.force.empty()) { add_plunger(); }
  overlay.add_simulated("along the needle, simulated", "tool.force_n", 1.0);
  if (!recording.force.empty()) { add_plunger(); }
  overlay.add_simulated("on the plunger, simulated", "syringe.thumb_n", 1.0, Series::Style::dashed);
  return std::move(overlay.figure);
}

Figure residual_figure(const ComparisonReport& report, std::size_t n) {
  const Comparison& one = report.found.recordings[n];
  const FieldUnit unit = unit_of_report(report);
  Figure figure = figure_over(
      report.simulation.trace, Over::time, "residual", "Residual",
      "Simulated less recorded, both filtered, where both are; a gap of the recording stays one." +
          honesty(report.recordings[n].input.recording),
      label_of("simulated - recorded", unit.name));
  figure.series = {
      {.x = times_of(one.recorded), .y = difference(one.simulated, one.recorded, unit.factor)}};
  return figure;
}

std::string honesty_of_group(const GroupSummary& group) {
  if (group.of_phantom()) { return " Recorded: measured phantom, no patient."; }
  const std::size_t rebuilt = group.recordings - group.measured - group.phantoms;
  if (rebuilt == 0) { return {}; }
  return " " + std::to_string(rebuilt) + " of " + std::to_string(group.recordings) +
         " recordings: " + std::string(io::reconstruction_note) + ", not measured.";
}

Series corridor_band(const SubjectCorridor& corridor, std::span<const double> middle,
                     double factor) {
  Series band{.label = "corridor", .style = Series::Style::band, .x = times_of(corridor.mean)};
  for (std::size_t n = 0; n < corridor.mean.size(); ++n) {
    const double half = corridor.half_width.value[n];
    band.y.push_back(factor * (middle[n] - half));
    band.y2.push_back(factor * (middle[n] + half));
  }
  return band;
}

/// Counts of subjects and recordings: "5 subjects", "5 subjects (10 recordings)".
std::string subjects_of(const SubjectCorridor& corridor) {
  const std::string subjects = counted(corridor.subjects, "subject", "subjects");
  return corridor.recordings == corridor.subjects
             ? subjects
             : subjects + " (" + counted(corridor.recordings, "recording", "recordings") + ")";
}

/// Counts of what a group has: subjects, or recordings of a phantom.
std::string subject_words(const GroupSummary& group) {
  return group.of_phantom() ? "recordings" : "subjects";
}

std::string corridor_words(const GroupSummary& group) {
  if (group.of_phantom()) {
    return "Mean ± " + short_number(group.corridor->factor, 3) + " SD of " +
           counted(group.corridor->recordings, "recording", "recordings") +
           ", in which a further one lies with 0.95";
  }
  return "Mean ± " + short_number(group.corridor->factor, 3) + " SD of " +
         subjects_of(*group.corridor) +
         ", in which a recording of a further subject lies with 0.95 (more SD where fewer were "
         "measured)";
}

/// Moves a figure along its horizontal axis.
void shift(Figure& figure, double by) {
  for (Zone& zone : figure.zones) {
    zone.begin += by;
    zone.end += by;
  }
  for (Mark& mark : figure.marks) { mark.x += by; }
}

/// Returns the part of a curve from an origin on, which becomes 0.
Series from_zero(const Series& whole, double origin) {
  Series part{.label = whole.label, .style = whole.style};
  for (std::size_t n = 0; n < whole.x.size(); ++n) {
    if (whole.x[n] >= origin) { part.add(whole.x[n] - origin, whole.y[n]); }
  }
  return part;
}

/// Figures of insertions with the simulated one: force over the depth below the contact and over
/// the time from it. With a group, the corridor and the mean are drawn.
std::vector<Figure> insertion_figures(const ComparisonReport& report,
                                      const std::vector<std::size_t>& members,
                                      const std::string& id, const GroupSummary* group = nullptr) {
  if (members.empty()) { return {}; }
  const Trace& trace = report.simulation.trace;
  const InsertionPhases& simulated =
      report.found.recordings[members.front()].simulated_features.phases;
  const std::string honest = group != nullptr
                                 ? honesty_of_group(*group)
                                 : honesty(report.recordings[members.front()].input.recording);
  std::vector<Figure> figures;
  for (const Over over : {Over::depth, Over::time}) {
    const bool by_depth = over == Over::depth;
    const double factor = by_depth ? mm : 1.0;
    const auto origin_of = [&](const InsertionPhases& phases) {
      const Measured& contact = by_depth ? phases.contact_depth : phases.contact_time;
      return factor * contact.value.value_or(0.0);
    };
    const auto& corridor = by_depth ? group->advance_corridor : group->corridor;
    const bool banded = group != nullptr && corridor.has_value();
    Figure figure = figure_over(
        trace, over, id + (by_depth ? "-force-over-depth" : "-force-over-time"),
        by_depth ? "Force over depth" : "Force over time",
        std::string(by_depth ? "Advance, hold and withdrawal, below the contact; the tints are the "
                               "simulated layers."
                             : "From the contact on.") +
            (banded ? " " + corridor_words(*group) + (by_depth ? ", of the advance." : ".") : "") +
            honest,
        "force (N)");
    figure.x.label = by_depth ? "depth below the contact (mm)" : "time from the contact (s)";
    shift(figure, -origin_of(simulated));
    if (banded) {
      const double start = by_depth ? 0.0 : origin_of(simulated);
      Series band = corridor_band(*corridor, corridor->mean.value, 1.0);
      for (double& x : band.x) { x = factor * x - start; }
      figure.series.push_back(std::move(band));
    }
    const std::string kind(io::in_words(report.recordings[members.front()].input.recording.kind));
    for (const std::size_t n : members) {
      const Recording& recording = report.recordings[n].input.recording;
      const double origin = origin_of(report.found.recordings[n].recorded_features.phases);
      const bool first = n == members.front();
      Series series{.label = !first               ? ""
                             : members.size() > 1 ? kind + ", each"
                                                  : kind,
                    .style = members.size() > 1 ? Series::Style::thin : Series::Style::line};
      series.x = scaled(by_depth ? recording.depth : recording.time, factor);
      series.y = recording.force;
      figure.series.push_back(from_zero(series, origin));
    }
    if (banded) {
      const double start = by_depth ? 0.0 : origin_of(simulated);
      figure.series.push_back({.label = "mean",
                               .style = Series::Style::dashed,
                               .x = scaled(times_of(corridor->mean), factor, -start),
                               .y = corridor->mean.value});
    }
    const ComparisonOptions& options = report.options.comparison;
    const Column* depth = trace.find(depth_column_of(options, trace));
    const std::vector<double>& at = by_depth && depth != nullptr ? depth->values : trace.time;
    figure.series.push_back(from_zero(
        {.label = "simulated", .x = scaled(at, factor), .y = trace.values(column_of(options))},
        origin_of(simulated)));
    figures.push_back(std::move(figure));
  }
  return figures;
}

Badge badge_of(Status status) { return {status, std::string(verdict_word(status))}; }

/// Verdict on a recording or a group.
std::string verdict_of(const Comparison& one) {
  return std::string(one.only_curve_differs ? only_curve_text : verdict_word(one.outcome.status));
}
std::string verdict_of(const GroupSummary& group) {
  return std::string(group.only_curve_differs ? only_curve_text
                                              : verdict_word(group.outcome.status));
}
template <class Judged> Badge badge_of(const Judged& one) {
  return {one.outcome.status, verdict_of(one)};
}

std::string value_of(const FeatureComparison& one, const Measured& measured) {
  return measured.value ? shown(one.feature, *measured.value, one.quantity.unit) : "-";
}

std::string allowed_of(const FeatureComparison& one) {
  if (is_event(one.feature)) { return "the same"; }
  if (one.status == Status::skip) { return "-"; }
  const Quantity& q = one.quantity;
  return shown_interval(one.feature, {q.lower, q.upper}, q.unit);
}

std::string why_of(const FeatureComparison& one) {
  if (!one.reason.empty()) { return one.reason; }
  if (is_event(one.feature)) { return one.tolerance.origin; }
  return shown(one.tolerance, one.quantity.unit) +
         (one.below_uncertainty ? "; error below u_val" : "");
}

LabelledTable features_table(const std::vector<FeatureComparison>& features) {
  LabelledTable table{.columns = {"feature", "verdict", "recorded", "simulated", "error", "± U",
                                  "allowed", "tolerance"},
                      .numbers = 5};
  for (const FeatureComparison& one : features) {
    const bool numbers = !is_event(one.feature);
    const std::string error = numbers ? shown(one.feature, one.error, one.quantity.unit) : "-";
    const std::string uncertainty = shown_uncertainty(one);
    table.rows.push_back({in_words(one.feature), badge_of(one.status), value_of(one, one.recorded),
                          value_of(one, one.simulated), error,
                          uncertainty.empty() ? "-" : uncertainty, allowed_of(one), why_of(one)});
  }
  return table;
}

/// Tolerance of a mean with its origin, or the reason why it is not judged.
std::string tolerance_words(const FeatureComparison& one) {
  if (!one.reason.empty() || is_event(one.feature)) { return why_of(one); }
  if (one.tolerance.origin.starts_with("two standard deviations")) {
    return std::string("two SD") + (one.below_uncertainty ? "; error below u_val" : "");
  }
  return why_of(one) + ": " + one.tolerance.origin;
}

/// Features of a group of insertions: measured mean and SD, simulated value and difference.
LabelledTable insertion_table(const GroupSummary& group) {
  LabelledTable table{.columns = {"feature", "verdict", subject_words(group), "measured", "SD",
                                  "simulated", "difference", "in SD", "allowed", "tolerance"},
                      .numbers = 7};
  for (std::size_t n = 0; n < group.features.size(); ++n) {
    const FeatureSummary& one = group.features[n];
    const bool event = is_event(one.feature);
    const auto value = [&](double number) { return shown(one.feature, number, one.unit); };
    const double difference = one.simulated ? *one.simulated - one.mean : not_measured;
    const bool in_deviations = !event && one.deviation > 0.0 && std::isfinite(difference);
    const FeatureComparison* mean = n < group.means.size() ? &group.means[n] : nullptr;
    table.rows.push_back(
        {in_words(one.feature), mean != nullptr ? badge_of(mean->status) : badge_of(Status::skip),
         std::to_string(one.count), event ? quantity(100.0 * one.mean, "% found") : value(one.mean),
         event ? "-" : value(one.deviation), one.simulated ? value(*one.simulated) : "-",
         event ? "-" : value(difference),
         in_deviations ? short_number(difference / one.deviation, 2) : "-",
         mean != nullptr ? allowed_of(*mean) : "-",
         mean != nullptr ? tolerance_words(*mean) : group.corridor_refusal});
  }
  return table;
}

std::string inside_of(const GroupSummary& group, const CorridorRule& rule) {
  if (!group.corridor) { return group.corridor_refusal; }
  return short_number(100.0 * group.coverage.inside, 3) + " % of samples; " +
         short_number(100.0 * rule.least_inside, 3) + " % needed";
}

std::string agreed_of(const GroupSummary& group) {
  if (group.subjects == 0) { return "none compared"; }
  return std::to_string(group.subjects_agree) + " of " + std::to_string(group.subjects) + " (" +
         short_number(100.0 * group.agree_interval.lower, 3) + " to " +
         short_number(100.0 * group.agree_interval.upper, 3) + " %)";
}

/// Kinds of the recordings of a group: "measured phantom", "3 measured, 2 reconstructed".
std::string kinds_in(const GroupSummary& group) {
  using enum Recording::Kind;
  std::string text;
  for (const auto& [kind, count] :
       {std::pair{measured, group.measured}, std::pair{measured_phantom, group.phantoms},
        std::pair{reconstructed, group.recordings - group.measured - group.phantoms}}) {
    if (count == 0) { continue; }
    const std::string words(io::in_words(kind));
    append_part(text, count == group.recordings ? words : std::to_string(count) + " " + words);
  }
  return text;
}

LabelledTable groups_table(const ComparisonReport& report) {
  const bool phantoms = std::ranges::all_of(
      report.found.groups, [](const GroupSummary& group) { return group.of_phantom(); });
  // Each recording of a phantom counts as a subject of its own.
  LabelledTable table{.columns = {"group", "verdict", phantoms ? "compared" : "subjects",
                                  phantoms ? "of them agree (95 %)" : "subjects who agree (95 %)",
                                  "recordings", "kind", "agree", "differ", "not distinguishable",
                                  "not comparable", "in the corridor"}};
  const auto count = [](auto number) { return std::to_string(number); };
  for (const GroupSummary& group : report.found.groups) {
    table.rows.push_back({name_of_group(group.group), badge_of(group), count(group.subjects),
                          agreed_of(group), count(group.recordings), kinds_in(group),
                          count(group.tally.passed), count(group.tally.failed),
                          count(group.tally.inconclusive), count(group.tally.errors),
                          inside_of(group, report.options.corridor)});
  }
  return table;
}

/// Verdict text, with the peak or the puncture, since readers look at it first.
std::string outcome_of(const Comparison& one) {
  if (one.outcome.status == Status::error) {
    return one.outcome.reasons.empty() ? "" : one.outcome.reasons.front();
  }
  const bool insertion = one.features.front().feature == Feature::puncture;
  const FeatureComparison& peak = one.of(insertion ? Feature::puncture_force : Feature::peak);
  return std::string(insertion ? "puncture " : "peak ") + value_of(peak, peak.recorded) +
         " recorded, " + value_of(peak, peak.simulated) + " simulated";
}

PagePart recordings_part(const ComparisonReport& report) {
  LabelledTable table{.columns = {"recording", "verdict", "kind", "group", "subject", "technique",
                                  "length", "outcome", "source"}};
  const auto or_not_said = [](const std::string& given) {
    return given.empty() ? "not said" : given;
  };
  for (std::size_t n = 0; n < report.recordings.size(); ++n) {
    const Comparison& one = report.found.recordings[n];
    const Recording& recording = report.recordings[n].input.recording;
    const double length =
        recording.time.empty() ? 0.0 : recording.time.back() - recording.time.front();
    table.rows.push_back({recording.name, badge_of(one), std::string(io::in_words(recording.kind)),
                          name_of_group(recording.group), or_not_said(recording.subject),
                          or_not_said(recording.technique),
                          quantity(length, "s") + " at " + quantity(recording.sample_rate, "Hz"),
                          outcome_of(one), or_not_said(recording.source)});
  }
  constexpr std::size_t many = 6;
  const std::size_t rows = table.rows.size();
  return folded_if(rows >= many, std::to_string(rows) + " recordings", std::move(table));
}

Table subjects_table(const GroupSummary& group) {
  Table table =
      make_table("", "Features over the subjects of " + name_of_group(group.group),
                 "Several recordings of one subject count as their mean. Intervals of the mean: "
                 "percentile bootstrap, seeded; of few subjects they are too narrow.",
                 {"feature", "subjects", "mean", "SD", "95 % interval of the mean", "simulated"});
  for (const FeatureSummary& one : group.features) {
    const auto value = [&](double number) { return shown(one.feature, number, one.unit); };
    const bool event = is_event(one.feature);
    const std::string mean = event ? quantity(100.0 * one.mean, "% found") : value(one.mean);
    table.rows.push_back(
        {in_words(one.feature), std::to_string(one.count), mean, event ? "-" : value(one.deviation),
         one.interval && !event ? shown_interval(one.feature, *one.interval, one.unit)
                                : std::string("-"),
         one.simulated ? value(*one.simulated) : std::string("-")});
  }
  return table;
}

Table ratings_table(const ComparisonReport& report) {
  const FieldUnit unit = field_unit(unit_of(report.options.comparison.quantity));
  Table table = make_table(
      "", "Ratings and distances of whole traces",
      "They explain and never judge. ISO/TS 18571: R = 0.4 Z + 0.2 (phase + magnitude + "
      "slope), of the filtered traces; E at the features, with u_val, is in their tables.",
      {"recording", "ISO R", "grade", "corridor Z", "phase", "magnitude", "slope", "R unfiltered",
       "Sprague-Geers M", "P", "C", "RMSE (" + unit.name + ")", "NRMSE"});
  for (const Comparison& one : report.found.recordings) {
    if (one.outcome.status == Status::error) { continue; }
    const IsoRating rating = one.rating.value_or(IsoRating{.corridor = not_measured,
                                                           .phase = not_measured,
                                                           .magnitude = not_measured,
                                                           .slope = not_measured,
                                                           .overall = not_measured});
    const double unfiltered = one.unfiltered_rating ? one.unfiltered_rating->overall : not_measured;
    table.rows.push_back(
        {one.recording, rating.overall,
         one.rating ? std::string(grade_of(rating.overall)) : std::string("not rated"),
         rating.corridor, rating.phase, rating.magnitude, rating.slope, unfiltered,
         one.errors.magnitude, one.errors.phase, one.errors.combined, unit.factor * one.errors.rmse,
         one.errors.nrmse});
  }
  return table;
}

Table defects_table(const ComparisonReport& report) {
  Table table = make_table("", "What was found wrong with the recordings",
                           "Nothing of it was mended: a gap stays a gap, and no figure counts it.",
                           {"recording", "samples", "found", "warnings"});
  for (const RecordingFile& one : report.recordings) {
    std::string warnings;
    for (const std::string& warning : one.input.warnings) {
      warnings += (warnings.empty() ? "" : "; ") + warning;
    }
    const Recording& recording = one.input.recording;
    table.rows.push_back({recording.name, std::to_string(recording.time.size()),
                          shown(recording.defects),
                          warnings.empty() ? std::string("none") : warnings});
  }
  return table;
}

Table tolerances_table(const ComparisonReport& report) {
  Table table =
      make_table("", "Tolerances in force", "Of a recorded value; --tolerance replaces them.",
                 {"feature", "allowed", "where it comes from"});
  const QuantityKind quantity = report.options.comparison.quantity;
  for (const Feature feature : comparison::features_of(quantity)) {
    const Tolerance tolerance = tolerance_of(feature, report.options.comparison);
    table.rows.push_back({in_words(feature),
                          is_event(feature) ? std::string("the same")
                                            : shown(tolerance, unit_of(feature, unit_of(quantity))),
                          tolerance.origin});
  }
  return table;
}

Table credibility_table(const ComparisonReport& report) {
  Table table =
      make_table("", "Credibility factors after ASME V&V 40-2018",
                 "What would be enough, and what there is. Nothing that was not shown is counted.",
                 {"activity", "factor", "goal", "shown", "evidence"});
  for (const CredibilityFactor& factor : report.credibility) {
    table.rows.push_back({factor.activity, factor.factor, factor.goal,
                          std::string(comparison::name_of(factor.shown)), factor.evidence});
  }
  return table;
}

/// Maximum number of recordings for which all figures are shown; with more, each has one figure.
constexpr std::size_t few_recordings = 3;
/// Maximum number of recordings with figures. It limits the page to some megabytes.
constexpr std::size_t most_drawn = 60;

bool compared(const Comparison& one) { return one.outcome.status != Status::error; }

std::vector<Figure> figures_of(const ComparisonReport& report, std::size_t n) {
  if (!compared(report.found.recordings[n]) || n >= most_drawn) { return {}; }
  if (report.recordings.size() <= few_recordings) { return recording_figures(report, n); }
  if (report.options.comparison.quantity == QuantityKind::insertion) {
    return insertion_figures(report, {n}, "recording-" + std::to_string(n));
  }
  return {report.options.comparison.quantity == QuantityKind::pressure
              ? pressure_figure(report, n, Over::time)
              : force_figure(report, n, Over::time)};
}

std::string simulation_words(const ComparedSimulation& simulation) {
  const bool scene = simulation.origin == ComparedSimulation::Origin::scene;
  return (scene ? "simulated from " : "read from ") + simulation.file.filename().string() +
         (simulation.title.empty() ? "" : ": " + simulation.title);
}

std::vector<Fact> key_facts(const ComparisonReport& report) {
  const ComparisonOptions& o = report.options.comparison;
  std::vector<Fact> facts{{"recordings", kinds_of(report), tally_of(report)},
                          {"quantity", std::string(comparison::name_of(o.quantity)),
                           "verdicts come from features and corridor; ratings explain"}};
  if (report.recordings.size() > 1) {
    const std::string count = std::to_string(subjects_compared(report));
    facts.insert(
        facts.begin() + 1,
        only_phantoms(report)
            ? Fact{"recordings that count", count,
                   "every insertion into a phantom enters a new position; those of one needle are "
                   "not averaged"}
            : Fact{"subjects", count,
                   "with a comparable recording; a recording that names no subject is one of its "
                   "own"});
  }
  const std::vector<double>& time = report.simulation.trace.time;
  facts.push_back({"simulation", simulation_words(report.simulation),
                   time.empty() ? ""
                                : quantity(time.back() - time.front(), "s") + " long; FNV-1a " +
                                      report.simulation.hash});
  if (report.simulation.run_longer > 0.0) {
    facts.push_back({"run longer by", quantity(report.simulation.run_longer, "s"),
                     "than the scene says: the loss of resistance counts once its pressure stayed "
                     "low for 5 s"});
  }
  const auto& all = report.found.recordings;
  const auto first = std::ranges::find_if(all, compared);
  if (first == all.end()) { return facts; }
  facts.push_back({"clocks", "aligned " + first->alignment.how,
                   "requested: " + std::string(comparison::name_of(o.alignment)) +
                       (all.size() > 1 ? "; of the first recording"
                                       : "; lag " + quantity(first->alignment.lag, "s"))});
  const double cutoff = first->cutoff;
  facts.push_back(
      {"filter", cutoff > 0.0 ? quantity(cutoff, "Hz") : "none",
       "low-pass without phase, the same for both; at most a quarter of the lower rate"});
  return facts;
}

Section recording_section(const ComparisonReport& report, std::size_t n) {
  const Comparison& one = report.found.recordings[n];
  const Recording& recording = report.recordings[n].input.recording;
  Section section{
      .kind = Section::Kind::article, .heading = recording.name, .badge = badge_of(one)};
  std::vector<PagePart>& parts = section.parts;
  if (recording.kind == Recording::Kind::measured_phantom) {
    parts.emplace_back(Paragraph{"measured phantom: no patient", "reason"});
  }
  if (recording.kind == Recording::Kind::reconstructed) {
    parts.emplace_back(
        Paragraph{std::string(io::reconstruction_note) + ": not a measurement", "reason"});
  }
  if (!recording.note.empty()) { parts.emplace_back(Paragraph{recording.note}); }
  if (report.recordings.size() > 1 || report.found.outcome.reasons.size() == 1) {
    parts.emplace_back(Notes{one.outcome.reasons});
  }
  parts.emplace_back(exhibits_of(figures_of(report, n)));
  if (!compared(one)) { return section; }
  if (recording.depth.empty()) {
    parts.emplace_back(Paragraph{"Depth was not recorded, so nothing is shown over depth."});
  }
  parts.push_back(folded_if(report.recordings.size() > few_recordings,
                            "features, tolerances and verdicts", features_table(one.features)));
  return section;
}

/// Adds the reasons, except the first, which is in the banner. A long list is collapsed.
void add_reasons(const ComparisonReport& report, std::vector<PagePart>& parts) {
  constexpr std::size_t many = 8;
  const std::vector<std::string>& reasons = report.found.outcome.reasons;
  if (reasons.size() < 2) { return; }
  PagePart notes = folded_if(reasons.size() >= many, std::to_string(reasons.size()) + " reasons",
                             Notes{reasons});
  parts.emplace_back(Section{.heading = "Why", .parts = {std::move(notes)}});
}

void add_groups(const ComparisonReport& report, std::vector<PagePart>& parts) {
  if (report.recordings.size() < 2) { return; }
  Section section{.kind = Section::Kind::section,
                  .heading = only_phantoms(report) ? "Groups of recordings" : "Groups of subjects",
                  .parts = {groups_table(report)}};
  for (std::size_t n = 0; n < report.found.groups.size(); ++n) {
    if (!report.found.groups[n].features.empty()) {
      section.parts.emplace_back(group_section(report, n));
    }
  }
  parts.emplace_back(std::move(section));
}

Section recordings_section(const ComparisonReport& report) {
  Section section{.kind = Section::Kind::section,
                  .heading = report.recordings.size() == 1 ? "The recording" : "Every recording"};
  if (report.recordings.size() > most_drawn) {
    section.parts.emplace_back(Paragraph{"The first " + std::to_string(most_drawn) +
                                         " are drawn; of the others there are tables."});
  }
  for (std::size_t n = 0; n < report.recordings.size(); ++n) {
    section.parts.emplace_back(recording_section(report, n));
  }
  return section;
}

Fact puncture_fact(const InsertionRule& rule) {
  return {"first puncture",
          "a drop by " + quantity(100.0 * rule.least_drop, "%") + " within " +
              quantity(mm * rule.drop_distance, "mm") + " of advance",
          "contact at " + quantity(rule.contact.force, "N") + " or " +
              short_number(rule.contact.deviations) + " SD of the noise, kept over " +
              quantity(mm * rule.contact.distance, "mm") + "; exponent from " +
              quantity(100.0 * rule.dent_from, "%") + " of the dent on; relaxation after " +
              quantity(rule.relaxation, "s") + " of the hold"};
}

std::vector<Fact> rule_facts(const ComparisonReport& report) {
  const ComparisonOptions& o = report.options.comparison;
  const LossRule& loss = o.features.loss;
  const auto percent = [](double share) { return quantity(100.0 * share, "%"); };
  Fact event{
      "loss of resistance",
      "a fall by " + percent(loss.least_drop) + " within " + quantity(loss.longest_fall, "s"),
      "held for " + quantity(loss.hold, "s") + ", steady to " + percent(loss.unsteady) +
          " of the peak"};
  const bool insertion = o.quantity == QuantityKind::insertion;
  if (insertion) { event = puncture_fact(o.features.insertion); }
  return {
      event,
      {"uncertainty", "U = " + short_number(o.uncertainties.coverage_factor) + " u_val",
       "u_val² = u_num² + u_input² + u_D²; a feature agrees or differs only if it does so at both "
       "ends of ± U"},
      {"u_D",
       o.quantity == QuantityKind::pressure
           ? "zero " + quantity(o.uncertainties.transducer.zero, "Pa") + ", gain " +
                 percent(o.uncertainties.transducer.gain)
           : "zero " + quantity(o.uncertainties.zero_force, "N") + ", gain " +
                 percent(o.uncertainties.transducer.gain),
       "beside noise, sampling and the alignment"},
      {"u_num and u_input",
       percent(o.uncertainties.numerical) + " and " + percent(o.uncertainties.input),
       "as stated on the command line; 0 by default"},
      {"corridor",
       "from " + std::to_string(report.options.corridor.least_subjects) + " subjects of a group",
       (insertion ? "over the time from the contact; every recording of a phantom counts; "
                  : "several recordings of one subject count as their mean; ") +
           percent(report.options.corridor.least_inside) +
           " of the simulated samples must lie in it"}};
}

std::vector<Fact> provenance_facts(const ComparisonReport& report) {
  std::vector<Fact> facts = facts_of_map(report.provenance);
  for (const RecordingFile& one : report.recordings) {
    facts.push_back({one.file.filename().string(), "FNV-1a " + one.hash, ""});
  }
  return facts;
}

using Json = nlohmann::ordered_json;

/// Writes the attributes or the defects of a recording into an object.
struct FieldWriter {
  Json& json;
  template <class Value, class Words>
  void word(const char* name, Value value, const Words& /*words*/) {
    json[name] = io::word_of(value);
  }
  void text(const char* name, const std::string& value) { json[name] = value; }
  void number(const char* name, double value) { json[name] = json_number(value); }
  void number(const char* name, const std::optional<double>& value) {
    json[name] = json_value(value);
  }
  void count(const char* name, std::size_t value) { json[name] = value; }
};

Json feature_json(const FeatureComparison& one) {
  const Tolerance& tolerance = one.tolerance;
  return object("name", name_of(one.feature), "unit", one.quantity.unit, "recorded",
                one.recorded.value, "simulated", one.simulated.value, "error", one.error, "lower",
                one.quantity.lower, "upper", one.quantity.upper, "tolerance",
                object("absolute", tolerance.absolute, "relative", tolerance.relative, "factor",
                       tolerance.factor, "origin", tolerance.origin),
                "u_num", one.uncertainty.numerical, "u_input", one.uncertainty.input, "u_data",
                one.uncertainty.data, "u_val", one.uncertainty.total(), "expanded_uncertainty",
                one.quantity.uncertainty, "below_uncertainty", one.below_uncertainty, "verdict",
                verdict_word(one.status), "reason", one.reason);
}

Json rating_json(const std::optional<IsoRating>& rating) {
  if (!rating) { return nullptr; }
  return object("corridor", rating->corridor, "phase", rating->phase, "magnitude",
                rating->magnitude, "slope", rating->slope, "overall", rating->overall, "grade",
                grade_of(rating->overall), "shift_samples", rating->shift, "correlation",
                rating->correlation, "note", rating->note);
}

/// Adds the results that exist only for a compared recording.
void add_measures(Json& json, const Comparison& one) {
  const Alignment& alignment = one.alignment;
  const TraceErrors& errors = one.errors;
  add_keys(
      json, "alignment",
      object("used", name_of(alignment.used), "how", alignment.how, "lag_s", alignment.lag,
             "uncertainty_s", alignment.uncertainty, "times_are_judged", alignment.judges_times()),
      "cutoff_hz", one.cutoff, "overlap_s", one.overlap, "features",
      list_of(one.features, feature_json), "distances",
      object("samples", errors.samples, "rmse", errors.rmse, "nrmse", errors.nrmse, "mean",
             errors.mean, "sprague_geers_magnitude", errors.magnitude, "sprague_geers_phase",
             errors.phase, "sprague_geers_combined", errors.combined),
      "rating", rating_json(one.rating), "unfiltered_rating", rating_json(one.unfiltered_rating),
      "rated_share", one.rated);
}

Json recording_json(const RecordingFile& input, const Comparison& one) {
  const Recording& recording = input.input.recording;
  Json json = object("file", input.file.filename().string(), "format", name_of(input.input.format),
                     "fnv1a", input.hash);
  FieldWriter writer{json};
  io::for_each_attribute(recording, writer);
  Json defects = Json::object();
  FieldWriter defect_writer{defects};
  io::for_each_defect(recording.defects, defect_writer);
  add_keys(json, "samples", recording.time.size(), "defects", defects, "warnings",
           input.input.warnings, "verdict", verdict_word(one.outcome.status), "reasons",
           one.outcome.reasons);
  json["verdict"] = verdict_of(one);
  if (one.outcome.status != Status::error) { add_measures(json, one); }
  return json;
}

Json interval_json(const Interval& interval) { return {interval.lower, interval.upper}; }

Json summary_json(const FeatureSummary& one) {
  return object("name", name_of(one.feature), "unit", one.unit, "count", one.count, "mean",
                one.mean, "standard_deviation", one.deviation, "mean_interval_95",
                one.interval ? interval_json(*one.interval) : Json(nullptr), "simulated",
                one.simulated);
}

Json corridor_json(const GroupSummary& group, const CorridorRule& rule) {
  if (!group.corridor) { return object("refused", group.corridor_refusal); }
  const CorridorCoverage& coverage = group.coverage;
  return object("recordings", group.corridor->recordings, "subjects", group.corridor->subjects,
                "half_width_sd", group.corridor->factor, "inside", coverage.inside, "least_inside",
                rule.least_inside, "largest_excursion", coverage.largest_excursion,
                "largest_excursion_at_s", coverage.excursion_time, "holds", coverage.holds);
}

Json simulation_json(const ComparedSimulation& simulation) {
  const std::vector<double>& time = simulation.trace.time;
  return object(
      "origin", simulation.origin == ComparedSimulation::Origin::scene ? "scene" : "trace", "file",
      simulation.file.filename().string(), "fnv1a", simulation.hash, "title", simulation.title,
      "duration_s", time.empty() ? Json(nullptr) : json_number(time.back() - time.front()),
      "run_longer_s", simulation.run_longer, "failure", simulation.failure);
}

Json options_json(const GroupOptions& options) {
  const ComparisonOptions& o = options.comparison;
  const Uncertainties& u = o.uncertainties;
  const LossRule& loss = o.features.loss;
  return object(
      "quantity", name_of(o.quantity), "alignment", name_of(o.alignment), "cutoff_hz", o.cutoff,
      "grid_rate_hz", o.grid_rate, "least_overlap_s", o.least_overlap, "loss_of_resistance",
      object("least_drop", loss.least_drop, "hold_s", loss.hold, "settle_s", loss.settle,
             "longest_fall_s", loss.longest_fall, "unsteady", loss.unsteady, "least_peak",
             loss.least_peak),
      "insertion",
      object("contact_n", o.features.insertion.contact.force, "contact_deviations",
             o.features.insertion.contact.deviations, "contact_distance_m",
             o.features.insertion.contact.distance, "least_drop", o.features.insertion.least_drop,
             "drop_distance_m", o.features.insertion.drop_distance, "dent_from",
             o.features.insertion.dent_from, "rest_s", o.features.insertion.rest, "relaxation_s",
             o.features.insertion.relaxation),
      "u_zero", o.quantity == QuantityKind::pressure ? u.transducer.zero : u.zero_force, "u_gain",
      u.transducer.gain, "u_num", u.numerical, "u_input", u.input, "coverage_factor",
      u.coverage_factor, "bootstrap_draws", options.bootstrap.draws, "bootstrap_seed",
      options.bootstrap.seed);
}

Json credibility_json(const CredibilityFactor& factor) {
  return object("activity", factor.activity, "factor", factor.factor, "goal", factor.goal, "shown",
                name_of(factor.shown), "evidence", factor.evidence, "links", factor.links);
}

struct WrittenUnit {
  std::string_view name;
  std::string_view si;
  double factor;
};
constexpr std::array written_units{WrittenUnit{"mmHg", "Pa", pascals_per_mmhg},
                                   WrittenUnit{"kPa", "Pa", 1e3},
                                   WrittenUnit{"Pa", "Pa", 1.0},
                                   WrittenUnit{"mmHg/s", "Pa/s", pascals_per_mmhg},
                                   WrittenUnit{"kPa/s", "Pa/s", 1e3},
                                   WrittenUnit{"Pa/s", "Pa/s", 1.0},
                                   WrittenUnit{"N", "N", 1.0},
                                   WrittenUnit{"N/s", "N/s", 1.0},
                                   WrittenUnit{"ms", "s", 1e-3},
                                   WrittenUnit{"s", "s", 1.0},
                                   WrittenUnit{"mm", "m", 1e-3},
                                   WrittenUnit{"m", "m", 1.0}};

constexpr const char* allowed_forms =
    "must be such as peak=15%, plateau=7mmHg, slope_before=30%+5mmHg/s or drop_time=x2";

Feature feature_named(const std::string& name, const std::string& text, QuantityKind quantity) {
  std::vector<std::string_view> known;
  for (const Feature feature : comparison::features_of(quantity)) {
    const bool named = comparison::name_of(feature) == name;
    if (named && is_event(feature)) {
      throw InputError("--tolerance " + text + ": " + name +
                       " is found or not, which has no width");
    }
    if (named) { return feature; }
    if (!is_event(feature)) { known.push_back(comparison::name_of(feature)); }
  }
  const std::string_view nearest = io::nearest_word(name, known);
  throw InputError(
      "--tolerance " + text + ": no feature with a width is called \"" + name + "\"; " +
      (nearest.empty() ? std::string(allowed_forms) : "did you mean " + std::string(nearest)));
}

/// Splits a text into a number and the unit after it.
struct Written {
  double number = 0.0;
  std::string unit{};
};

Written split(const std::string& part, const std::string& text) {
  const std::size_t end = part.find_first_not_of("0123456789.eE-+");
  Written written{.unit = end == std::string::npos ? "" : part.substr(end)};
  const bool number = io::parse_number(part.substr(0, end), written.number);
  if (!number || !std::isfinite(written.number) || written.number < 0.0) {
    throw InputError("--tolerance " + text + ": \"" + part + "\"; " + allowed_forms);
  }
  return written;
}

void add_width(const Written& written, const std::string& text, QuantityKind quantity,
               Tolerance& tolerance) {
  if (written.unit == "%") {
    tolerance.relative += 0.01 * written.number;
    return;
  }
  const std::string si = comparison::unit_of(tolerance.feature, unit_of(quantity));
  const auto unit = std::ranges::find_if(written_units, [&](const WrittenUnit& one) {
    return one.name == written.unit && one.si == si;
  });
  const bool bare = written.unit.empty() && si == "1";
  if (!bare && unit == written_units.end()) {
    throw InputError("--tolerance " + text + ": unit \"" + written.unit +
                     "\"; must be % or a unit of " + si);
  }
  tolerance.absolute += written.number * (bare ? 1.0 : unit->factor);
}

}  // namespace

/// Returns true if the comparison fails by curves alone: every group that differs has features that
/// agree.
bool only_curves_differ(const ComparisonReport& report) {
  if (report.found.outcome.status != Status::fail) { return false; }
  return std::ranges::all_of(report.found.groups, [](const GroupSummary& group) {
    return group.outcome.status != Status::fail || group.only_curve_differs;
  });
}

std::string tally_of(const ComparisonReport& report) {
  std::string text;
  const auto add = [&](Status status, const char* one, const char* many) {
    const std::size_t count = count_of(report, status);
    if (count > 0) { append_part(text, counted(count, one, many)); }
  };
  add(Status::pass, "agrees", "agree");
  add(Status::inconclusive, "is not distinguishable", "are not distinguishable");
  add(Status::fail, "differs", "differ");
  add(Status::error, "cannot be compared", "cannot be compared");
  return text;
}

bool holds(const ComparisonReport& report) {
  return report.found.outcome.status == Status::pass && count_of(report, Status::error) == 0;
}

std::string verdict_text(const ComparisonReport& report) {
  std::string text = capitalised(std::string(
      only_curves_differ(report) ? only_curve_text : verdict_word(report.found.outcome.status)));
  const std::size_t left_out = count_of(report, Status::error);
  if (left_out > 0 && report.found.outcome.status != Status::error) {
    text += ", but " + counted(left_out, "recording", "recordings") + " cannot be compared";
  }
  return text;
}

/// Returns the parts of the ratings of curves that are poor where the features agree.
std::string poor_parts(const ComparisonReport& report) {
  std::set<std::string> parts;
  for (const Comparison& one : report.found.recordings) {
    if (!one.rating || one.outcome.status != Status::pass) { continue; }
    const comparison::IsoRating& rating = *one.rating;
    for (const auto& [name, value] : {std::pair{"corridor", rating.corridor},
                                      {"phase", rating.phase},
                                      {"magnitude", rating.magnitude},
                                      {"slope", rating.slope}}) {
      const bool not_rated = value == 0.0 && !rating.note.empty();
      if (!not_rated && comparison::grade_of(value) == "poor") { parts.insert(name); }
    }
  }
  std::string text;
  for (const std::string& part : parts) { append_part(text, part); }
  return text;
}

std::string verdict_sentence(const ComparisonReport& report) {
  if (!report.simulation.failure.empty()) {
    return "The simulation " + report.simulation.failure + ".";
  }
  std::string sentence = "The simulated " +
                         std::string(name_of(report.options.comparison.quantity)) +
                         " was judged against " + kinds_of(report);
  if (report.found.outcome.status == Status::pass) {
    sentence += ". Every feature that can be judged lies within its tolerance.";
    const std::string poor = poor_parts(report);
    if (!poor.empty()) {
      sentence += " ISO/TS 18571 rates the whole curve as poor in " + poor + ".";
    }
  } else {
    sentence += report.found.outcome.reasons.empty()
                    ? "."
                    : ": " + report.found.outcome.reasons.front() + ".";
  }
  if (count_of(report, Recording::Kind::reconstructed) > 0) {
    sentence += " What was reconstructed is no evidence about patients.";
  }
  if (count_of(report, Recording::Kind::measured_phantom) > 0) {
    sentence += " A phantom is no evidence about patients.";
  }
  return sentence;
}

std::string shown(const RecordingDefects& defects) {
  const std::array<std::pair<std::size_t, const char*>, 8> counts{
      {{defects.missing, "missing samples"},
       {defects.gaps, "gaps"},
       {defects.bad_frames, "bad frames"},
       {defects.not_finite, "samples without a number"},
       {defects.out_of_range, "out of range"},
       {defects.clipped, "clipped"},
       {defects.not_increasing, "rows out of order, left out"},
       {defects.battery_low, "with the battery low"}}};
  std::string text;
  for (const auto& [count, what] : counts) {
    if (count > 0) { append_part(text, std::to_string(count) + " " + what); }
  }
  return text.empty() ? "nothing" : text;
}

std::string to_html(const ComparisonReport& report) {
  const std::string version = entry(report.provenance, "version");
  Page page{.banner = {.title = "Recorded and simulated insertion",
                       .small_print = {report.command, version.empty() ? "" : "version " + version},
                       .status = holds(report) ? Status::pass : Status::fail,
                       .verdict = verdict_text(report),
                       .detail = verdict_sentence(report)},
            .provenance = provenance_facts(report),
            .command = report.command};
  std::vector<PagePart>& parts = page.parts;
  const auto add_section = [&parts](const char* heading, std::vector<PagePart> content) {
    parts.emplace_back(
        Section{.kind = Section::Kind::section, .heading = heading, .parts = std::move(content)});
  };
  parts.emplace_back(Section{.heading = "Key facts", .parts = {key_facts(report)}});
  add_reasons(report, parts);
  parts.emplace_back(Section{.heading = "What was compared", .parts = {recordings_part(report)}});
  add_groups(report, parts);
  parts.emplace_back(recordings_section(report));
  add_section("Whole traces", {ratings_table(report)});
  add_section("What the recordings lack", {defects_table(report)});
  add_section("How it was judged", {rule_facts(report), tolerances_table(report)});
  add_section("What was shown, and what was not", {credibility_table(report)});
  return render(page);
}

std::vector<Figure> recording_figures(const ComparisonReport& report, std::size_t recording) {
  std::vector<Figure> figures;
  const bool both_have_depth = !report.recordings[recording].input.recording.depth.empty() &&
                               report.simulation.trace.find("tool.depth_m") != nullptr;
  if (report.options.comparison.quantity == QuantityKind::insertion) {
    figures = insertion_figures(report, {recording}, "recording-" + std::to_string(recording));
    figures.push_back(residual_figure(report, recording));
    return figures;
  }
  const bool has_pressure = !report.recordings[recording].input.recording.pressure.empty();
  for (const Over over : {Over::time, Over::depth}) {
    if (over == Over::depth && !both_have_depth) { continue; }
    if (has_pressure) { figures.push_back(pressure_figure(report, recording, over)); }
    figures.push_back(force_figure(report, recording, over));
  }
  figures.push_back(residual_figure(report, recording));
  return figures;
}

Section group_section(const ComparisonReport& report, std::size_t n) {
  const GroupSummary& group = report.found.groups[n];
  Section section{.kind = Section::Kind::article,
                  .heading = name_of_group(group.group),
                  .badge = badge_of(group)};
  if (report.found.groups.size() > 1) { section.parts.emplace_back(Notes{group.outcome.reasons}); }
  section.parts.emplace_back(exhibits_of(group_figures(report, n)));
  if (report.options.comparison.quantity == QuantityKind::insertion) {
    section.parts.emplace_back(
        Paragraph{"Measured mean and standard deviation (SD) over the recordings, and the "
                  "simulated insertion:"});
    section.parts.emplace_back(insertion_table(group));
    return section;
  }
  if (!group.means.empty()) {
    section.parts.emplace_back(
        Paragraph{"The simulated insertion compared with the means over subjects:"});
    section.parts.emplace_back(features_table(group.means));
  }
  section.parts.emplace_back(subjects_table(group));
  return section;
}

std::vector<Figure> group_figures(const ComparisonReport& report, std::size_t index) {
  const GroupSummary& group = report.found.groups[index];
  if (report.options.comparison.quantity == QuantityKind::insertion) {
    std::vector<std::size_t> members;
    for (std::size_t n = 0; n < report.found.recordings.size(); ++n) {
      const Comparison& one = report.found.recordings[n];
      if (one.group == group.group && one.outcome.status != Status::error) { members.push_back(n); }
    }
    return insertion_figures(report, members, "group-" + std::to_string(index), &group);
  }
  if (!group.corridor) { return {}; }
  const FieldUnit unit = unit_of_report(report);
  const Samples& mean = group.corridor->mean;
  const std::string what(comparison::name_of(report.options.comparison.quantity));
  const Trace& trace = report.simulation.trace;
  const std::string number = std::to_string(index);
  Figure corridor =
      figure_over(trace, Over::time, "corridor-" + number,
                  "Corridor of " + (group.group.empty() ? "the subjects" : group.group),
                  corridor_words(group) + "; all filtered, on the simulation's clock." +
                      honesty_of_group(group),
                  label_of(what, unit.name));
  const Series simulated{.label = "simulated",
                         .x = times_of(group.simulated),
                         .y = scaled(group.simulated.value, unit.factor)};
  corridor.series = {corridor_band(*group.corridor, mean.value, unit.factor),
                     {.label = "mean of the subjects",
                      .style = Series::Style::dashed,
                      .x = times_of(mean),
                      .y = scaled(mean.value, unit.factor)},
                     simulated};
  Figure residual =
      figure_over(trace, Over::time, "corridor-residual-" + number, "Residual against the mean",
                  "Simulated less the mean of the subjects, within the same corridor." +
                      honesty_of_group(group),
                  label_of("simulated - mean", unit.name));
  const std::vector<double> zero(mean.size(), 0.0);
  residual.series = {
      corridor_band(*group.corridor, zero, unit.factor),
      {.label = "residual", .x = simulated.x, .y = difference(group.simulated, mean, unit.factor)}};
  return {corridor, residual};
}

std::string to_json(const ComparisonReport& report) {
  Json recordings = Json::array();
  for (std::size_t n = 0; n < report.recordings.size(); ++n) {
    recordings.push_back(recording_json(report.recordings[n], report.found.recordings.at(n)));
  }
  const QuantityKind quantity = report.options.comparison.quantity;
  const auto of_group = [&](const GroupSummary& group) {
    return object("group", group.group, "recordings", group.recordings, "subjects", group.subjects,
                  "measured", group.measured, "measured_phantom", group.phantoms, "reconstructed",
                  group.recordings - group.measured - group.phantoms, "agree", group.tally.passed,
                  "not_distinguishable", group.tally.inconclusive, "differ", group.tally.failed,
                  "not_comparable", group.tally.errors, "subjects_agree", group.subjects_agree,
                  "agree_share", group.agree_share, "agree_interval_95",
                  group.subjects > 0 ? interval_json(group.agree_interval) : Json(nullptr),
                  "features", list_of(group.features, summary_json), "means_judged",
                  list_of(group.means, feature_json), "corridor",
                  corridor_json(group, report.options.corridor), "verdict", verdict_of(group),
                  "reasons", group.outcome.reasons);
  };
  const std::string_view verdict =
      only_curves_differ(report) ? only_curve_text : verdict_word(report.found.outcome.status);
  return sealed_text(object("schema", 1, "verdict", verdict, "holds", holds(report), "sentence",
                            verdict_sentence(report), "reasons", report.found.outcome.reasons,
                            "quantity", name_of(quantity), "unit", unit_of(quantity), "simulation",
                            simulation_json(report.simulation), "options",
                            options_json(report.options), "recordings", recordings, "groups",
                            list_of(report.found.groups, of_group), "credibility",
                            list_of(report.credibility, credibility_json), "command",
                            report.command, "provenance", report.provenance));
}

Tolerance tolerance_from(const std::string& text, QuantityKind quantity) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals + 1 == text.size()) {
    throw InputError("--tolerance " + text + "; " + allowed_forms);
  }
  Tolerance tolerance{.feature = feature_named(text.substr(0, equals), text, quantity),
                      .origin = "the command line"};
  std::string rest = text.substr(equals + 1);
  if (rest.front() == 'x') {
    tolerance.factor = split(rest.substr(1), text).number;
    if (tolerance.factor > 1.0 && split(rest.substr(1), text).unit.empty()) { return tolerance; }
    throw InputError("--tolerance " + text + "; a factor must be a number > 1");
  }
  while (!rest.empty()) {
    const std::size_t plus = std::min(rest.find('+'), rest.size());
    add_width(split(rest.substr(0, plus), text), text, quantity, tolerance);
    rest.erase(0, std::min(plus + 1, rest.size()));
  }
  return tolerance;
}

std::string tolerance_help(QuantityKind quantity) {
  std::string help;
  for (const Tolerance& one : default_tolerances(quantity)) {
    if (is_event(one.feature)) { continue; }
    const FieldUnit field = field_unit(comparison::unit_of(one.feature, unit_of(quantity)));
    std::string value = one.factor > 1.0 ? "x" + plain_number(one.factor) : "";
    if (one.relative > 0.0) { value = plain_number(100.0 * one.relative, 3) + "%"; }
    if (one.absolute > 0.0) {
      value += (value.empty() ? "" : "+") + plain_number(field.factor * one.absolute, 3) +
               (field.name == "1" ? "" : field.name);
    }
    help += "  " + std::string(comparison::name_of(one.feature)) + "=" + value + "\n";
  }
  return help;
}

}  // namespace palpate
