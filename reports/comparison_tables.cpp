// SPDX-License-Identifier: MIT
#include "reports/comparison_tables.hpp"

#include "fixtures/io/recording_fields.hpp"
#include "reports/comparison_words.hpp"
#include "reports/html_page.hpp"
#include "reports/markup.hpp"
#include "validation/comparison/feature_verdict.hpp"
#include "validation/comparison/field_unit.hpp"

namespace palpate {

using namespace comparison;

namespace {

/// The badges of cases, by what a verdict means for the exit code.
std::string_view badge_class(Verdict verdict) {
  switch (verdict) {
    case Verdict::agrees:
      return "pass";
    case Verdict::differs:
    case Verdict::not_comparable:
      return "fail";
    case Verdict::not_distinguishable:
    case Verdict::not_judged:
      break;
  }
  return "skip";
}

/// Columns of numbers begin with '#'.
std::string head_of(std::initializer_list<std::string_view> columns) {
  std::string head = "<thead><tr>";
  for (const std::string_view column : columns) {
    const bool number = column.starts_with('#');
    head += std::string("<th scope=\"col\"") + (number ? " class=\"number\">" : ">") +
            std::string(column.substr(number ? 1 : 0)) + "</th>";
  }
  return head + "</tr></thead><tbody>\n";
}

/// A cell that says what it is where the page is too narrow for a table's head.
std::string labelled(const char* label, const std::string& markup, const char* name = "") {
  return "<td data-label=\"" + std::string(label) + "\"" +
         (*name == '\0' ? "" : " class=\"" + std::string(name) + "\"") + ">" + markup + "</td>";
}

std::string value_of(const FeatureVerdict& one, const Measured& measured) {
  return measured.value ? shown(one.feature, *measured.value, one.unit) : "-";
}

std::string allowed_of(const FeatureVerdict& one) {
  if (one.feature == Feature::loss_of_resistance) { return "the same"; }
  if (one.verdict == Verdict::not_judged) { return "-"; }
  return shown_interval(one.feature, {one.lower, one.upper}, one.unit);
}

std::string why_of(const FeatureVerdict& one) {
  if (!one.reason.empty()) { return one.reason; }
  if (one.feature == Feature::loss_of_resistance) { return one.tolerance.origin; }
  return shown(one.tolerance, one.unit) + (one.below_uncertainty ? "; error below u_val" : "");
}

std::string feature_row(const FeatureVerdict& one) {
  const bool numbers = one.feature != Feature::loss_of_resistance;
  const std::string error = numbers ? shown(one.feature, one.error, one.unit) : "-";
  const std::string uncertainty = shown_uncertainty(one);
  return "<tr><th scope=\"row\">" + in_words(one.feature) + "</th>" +
         labelled("verdict", html_badge(one.verdict)) +
         labelled("recorded", value_of(one, one.recorded), "number") +
         labelled("simulated", value_of(one, one.simulated), "number") + labelled("error", error, "number") +
         labelled("± U", uncertainty.empty() ? "-" : uncertainty, "number") +
         labelled("allowed", allowed_of(one), "number") +
         labelled("tolerance", escape_markup(why_of(one)), "why") + "</tr>\n";
}

std::string inside_of(const GroupSummary& group, const CorridorRule& rule) {
  if (!group.corridor) { return group.corridor_refusal; }
  return short_number(100.0 * group.coverage.inside, 3) + " % of samples; " +
         short_number(100.0 * rule.least_inside, 3) + " % needed";
}

std::string agreed_of(const GroupSummary& group) {
  if (group.recordings == group.not_comparable) { return "none compared"; }
  return std::to_string(group.subjects_agree) + " of " + std::to_string(group.subjects) + " (" +
         short_number(100.0 * group.agree_interval.lower, 3) + " to " +
         short_number(100.0 * group.agree_interval.upper, 3) + " %)";
}

std::string group_row(const GroupSummary& group, const CorridorRule& rule) {
  const auto count = [](std::size_t number) { return std::to_string(number); };
  return "<tr><th scope=\"row\">" + escape_markup(name_of_group(group.group)) + "</th>" +
         labelled("verdict", html_badge(group.verdict)) + labelled("subjects", count(group.subjects)) +
         labelled("subjects who agree", agreed_of(group)) + labelled("recordings", count(group.recordings)) +
         labelled("of them measured", count(group.measured)) + labelled("agree", count(group.agree)) +
         labelled("differ", count(group.differ)) +
         labelled("not distinguishable", count(group.not_distinguishable)) +
         labelled("not comparable", count(group.not_comparable)) +
         labelled("in the corridor", escape_markup(inside_of(group, rule)), "why") + "</tr>\n";
}

/// With a peak where there is one, as clinicians ask for it first.
std::string outcome_of(const Comparison& one) {
  if (one.verdict == Verdict::not_comparable) { return one.reasons.empty() ? "" : one.reasons.front(); }
  const FeatureVerdict& peak = one.features.at(static_cast<std::size_t>(Feature::peak));
  return "peak " + value_of(peak, peak.recorded) + " recorded, " + value_of(peak, peak.simulated) +
         " simulated";
}

std::string recording_row(const ComparedRecording& input, const Comparison& one) {
  const Recording& recording = input.input.recording;
  const double length = recording.time.empty() ? 0.0 : recording.time.back() - recording.time.front();
  return "<tr><th scope=\"row\">" + escape_markup(recording.name) + "</th>" +
         labelled("verdict", html_badge(one.verdict)) +
         labelled("kind", std::string(io::word_of(recording.kind))) +
         labelled("group", escape_markup(name_of_group(recording.group))) +
         labelled("subject", escape_markup(recording.subject.empty() ? "not said" : recording.subject)) +
         labelled("technique",
                  escape_markup(recording.technique.empty() ? "not said" : recording.technique)) +
         labelled("length", quantity(length, "s") + " at " + quantity(recording.sample_rate, "Hz")) +
         labelled("outcome", escape_markup(outcome_of(one))) +
         labelled("source", escape_markup(recording.source.empty() ? "not said" : recording.source), "why") +
         "</tr>\n";
}

std::string verdict_table(const std::string& head, const std::string& rows) {
  return "<div class=\"scroll\"><table class=\"quantities labelled\">" + head + rows +
         "</tbody></table></div>\n";
}

}  // namespace

std::string html_badge(Verdict verdict) {
  return "<span class=\"badge " + std::string(badge_class(verdict)) + "\">" +
         std::string(comparison::name_of(verdict)) + "</span>";
}

std::string html_features(const std::vector<FeatureVerdict>& features) {
  std::string rows;
  for (const FeatureVerdict& one : features) { rows += feature_row(one); }
  return verdict_table(
      head_of({"feature", "verdict", "#recorded", "#simulated", "#error", "#± U", "#allowed", "tolerance"}),
      rows);
}

std::string html_recordings(const ComparisonReport& report) {
  std::string rows;
  for (std::size_t n = 0; n < report.recordings.size(); ++n) {
    rows += recording_row(report.recordings[n], report.found.recordings[n]);
  }
  const std::string table = verdict_table(
      head_of({"recording", "verdict", "kind", "group", "subject", "technique", "length", "outcome",
               "source"}),
      rows);
  constexpr std::size_t many = 6;
  const std::size_t count = report.recordings.size();
  return count < many ? table
                      : "<details><summary>" + std::to_string(count) + " recordings</summary>" + table +
                            "</details>\n";
}

std::string html_groups(const ComparisonReport& report) {
  std::string rows;
  for (const GroupSummary& group : report.found.groups) { rows += group_row(group, report.options.corridor); }
  return verdict_table(
      head_of({"group", "verdict", "subjects", "who agree (95 %)", "recordings", "of them measured", "agree",
               "differ", "not distinguishable", "not comparable", "in the corridor"}),
      rows);
}

Table subjects_table(const GroupSummary& group) {
  Table table{
      .title = "Features over the subjects of " + name_of_group(group.group),
      .caption = "Several recordings of one subject count as their mean. Intervals of the mean: percentile "
                 "bootstrap, seeded; of few subjects they are too narrow.",
      .columns = {"feature", "subjects", "mean", "SD", "95 % interval of the mean", "simulated"}};
  for (const FeatureSummary& one : group.features) {
    const auto value = [&](double number) { return shown(one.feature, number, one.unit); };
    const bool event = one.feature == Feature::loss_of_resistance;
    const std::string mean = event ? quantity(100.0 * one.mean, "% found") : value(one.mean);
    table.rows.push_back(
        {in_words(one.feature), std::to_string(one.count), mean, event ? "-" : value(one.deviation),
         one.interval && !event ? shown_interval(one.feature, *one.interval, one.unit) : std::string("-"),
         one.simulated ? value(*one.simulated) : std::string("-")});
  }
  return table;
}

Table ratings_table(const ComparisonReport& report) {
  const FieldUnit unit = field_unit(unit_of(report.options.comparison.quantity));
  Table table{.title = "Ratings and distances of whole traces",
              .caption =
                  "They explain and never judge. ISO/TS 18571: R = 0.4 Z + 0.2 (phase + magnitude + slope), "
                  "of the filtered traces; E at the features, with u_val, is in their tables.",
              .columns = {"recording", "ISO R", "grade", "corridor Z", "phase", "magnitude", "slope",
                          "R unfiltered", "Sprague-Geers M", "P", "C", "RMSE (" + unit.name + ")", "NRMSE"}};
  for (const Comparison& one : report.found.recordings) {
    if (one.verdict == Verdict::not_comparable) { continue; }
    const IsoRating rating = one.rating.value_or(IsoRating{.corridor = not_measured,
                                                           .phase = not_measured,
                                                           .magnitude = not_measured,
                                                           .slope = not_measured,
                                                           .overall = not_measured});
    const double unfiltered = one.unfiltered_rating ? one.unfiltered_rating->overall : not_measured;
    table.rows.push_back({one.recording, rating.overall,
                          one.rating ? std::string(grade_of(rating.overall)) : std::string("not rated"),
                          rating.corridor, rating.phase, rating.magnitude, rating.slope, unfiltered,
                          one.errors.magnitude, one.errors.phase, one.errors.combined,
                          unit.factor * one.errors.rmse, one.errors.nrmse});
  }
  return table;
}

Table defects_table(const ComparisonReport& report) {
  Table table{.title = "What was found wrong with the recordings",
              .caption = "Nothing of it was mended: a gap stays a gap, and no figure counts it.",
              .columns = {"recording", "samples", "found", "warnings"}};
  for (const ComparedRecording& one : report.recordings) {
    std::string warnings;
    for (const std::string& warning : one.input.warnings) {
      warnings += (warnings.empty() ? "" : "; ") + warning;
    }
    const Recording& recording = one.input.recording;
    table.rows.push_back({recording.name,
                          std::to_string(recording.time.size()), shown(recording.defects),
                          warnings.empty() ? std::string("none") : warnings});
  }
  return table;
}

Table tolerances_table(const ComparisonReport& report) {
  Table table{.title = "Tolerances in force",
              .caption = "Of a recorded value; --tolerance replaces them.",
              .columns = {"feature", "allowed", "where it comes from"}};
  const QuantityKind quantity = report.options.comparison.quantity;
  for (std::size_t n = 0; n < feature_count; ++n) {
    const auto feature = static_cast<Feature>(n);
    const Tolerance tolerance = tolerance_of(feature, report.options.comparison);
    table.rows.push_back(
        {in_words(feature), shown(tolerance, unit_of(feature, unit_of(quantity))), tolerance.origin});
  }
  return table;
}

Table credibility_table(const ComparisonReport& report) {
  Table table{.title = "Credibility factors after ASME V&V 40-2018",
              .caption = "What would be enough, and what there is. Nothing that was not shown is counted.",
              .columns = {"activity", "factor", "goal", "shown", "evidence"}};
  for (const CredibilityFactor& factor : report.credibility) {
    table.rows.push_back({factor.activity, factor.factor, factor.goal,
                          std::string(comparison::name_of(factor.shown)), factor.evidence});
  }
  return table;
}

}  // namespace palpate
