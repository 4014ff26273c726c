// SPDX-License-Identifier: MIT

#include "reports/comparison_report.hpp"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <string>

#include "fixtures/io/recording_file.hpp"
#include "reports/html/html_page.hpp"
#include "reports/plot/figure_svg.hpp"
#include "validation/comparison/comparison.hpp"

namespace palpate {

using namespace comparison;

namespace {

std::string counted(std::size_t count, const std::string& one, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

void append_part(std::string& text, const std::string& part) {
  text += (text.empty() ? "" : ", ") + part;
}

std::size_t reconstructed_count(const ComparisonReport& report) {
  return static_cast<std::size_t>(
      std::ranges::count_if(report.recordings, [](const ComparedRecording& one) {
        return one.input.recording.kind == Recording::Kind::reconstructed;
      }));
}

std::size_t verdict_count(const ComparisonReport& report, Verdict verdict) {
  return static_cast<std::size_t>(
      std::ranges::count(report.found.recordings, verdict, &Comparison::verdict));
}

/// Collects counts above zero by their words.
struct DefectWords {
  std::string text{};
  void add(std::size_t count, const char* what) {
    if (count > 0) { append_part(text, std::to_string(count) + " " + what); }
  }
};

}  // namespace

bool any_reconstructed(const ComparisonReport& report) { return reconstructed_count(report) > 0; }

std::string kinds_of(const ComparisonReport& report) {
  const std::size_t rebuilt = reconstructed_count(report);
  const std::size_t measured = report.recordings.size() - rebuilt;
  std::string text;
  if (measured > 0) { text = counted(measured, "measured recording", "measured recordings"); }
  if (rebuilt > 0) {
    text += (text.empty() ? "" : " and ") + counted(rebuilt, "recording ", "recordings ") +
            std::string(io::reconstruction_note);
  }
  return text;
}

std::string subjects_of(const SubjectCorridor& corridor) {
  const std::string subjects = counted(corridor.subjects, "subject", "subjects");
  return corridor.recordings == corridor.subjects
             ? subjects
             : subjects + " (" + counted(corridor.recordings, "recording", "recordings") + ")";
}

std::size_t subjects_compared(const ComparisonReport& report) {
  std::size_t count = 0;
  for (const GroupSummary& group : report.found.groups) { count += group.subjects; }
  return count;
}

std::string name_of_group(const std::string& group) {
  return group.empty() ? "without a group" : group;
}

std::string tally_of(const ComparisonReport& report) {
  std::string text;
  const auto add = [&](Verdict verdict, const char* one, const char* many) {
    const std::size_t count = verdict_count(report, verdict);
    if (count > 0) { append_part(text, counted(count, one, many)); }
  };
  add(Verdict::agrees, "agrees", "agree");
  add(Verdict::not_distinguishable, "is not distinguishable", "are not distinguishable");
  add(Verdict::differs, "differs", "differ");
  add(Verdict::not_comparable, "cannot be compared", "cannot be compared");
  return text;
}

bool holds(const ComparisonReport& report) {
  return report.found.verdict == Verdict::agrees &&
         verdict_count(report, Verdict::not_comparable) == 0;
}

std::string verdict_text(const ComparisonReport& report) {
  std::string text(name_of(report.found.verdict));
  text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  const std::size_t left_out = verdict_count(report, Verdict::not_comparable);
  if (left_out > 0 && report.found.verdict != Verdict::not_comparable) {
    text += ", but " + counted(left_out, "recording", "recordings") + " cannot be compared";
  }
  return text;
}

std::string verdict_sentence(const ComparisonReport& report) {
  if (!report.simulation.failure.empty()) {
    return "The simulation " + report.simulation.failure + ".";
  }
  std::string sentence = "The simulated " +
                         std::string(name_of(report.options.comparison.quantity)) +
                         " was judged against " + kinds_of(report);
  if (report.found.verdict == Verdict::agrees) {
    sentence += ". Every feature that can be judged lies within its tolerance.";
  } else {
    sentence += report.found.reasons.empty() ? "." : ": " + report.found.reasons.front() + ".";
  }
  if (any_reconstructed(report)) {
    sentence += " What was reconstructed is no evidence about patients.";
  }
  return sentence;
}

std::string shown(const RecordingDefects& defects) {
  DefectWords words;
  words.add(defects.missing, "missing samples");
  words.add(defects.gaps, "gaps");
  words.add(defects.bad_frames, "bad frames");
  words.add(defects.not_finite, "samples without a number");
  words.add(defects.out_of_range, "out of range");
  words.add(defects.clipped, "clipped");
  words.add(defects.not_increasing, "rows out of order, left out");
  words.add(defects.battery_low, "with the battery low");
  return words.text.empty() ? "nothing" : words.text;
}

// The tables of a comparison, and those that carry verdicts as markup.

std::string html_badge(comparison::Verdict verdict);

/// Every feature with both values, what is allowed, the verdict and who says so.
std::string html_features(const std::vector<comparison::FeatureVerdict>& features);

/// One line per recording: what it is and how it came out.
std::string html_recordings(const ComparisonReport& report);
/// One line per group with its counts and its corridor.
std::string html_groups(const ComparisonReport& report);

/// Features over the subjects of a group: mean, SD, interval, simulated value.
Table subjects_table(const comparison::GroupSummary& group);
/// ISO 18571 with its parts, Sprague-Geers, RMSE of every recording that could be compared.
Table ratings_table(const ComparisonReport& report);
Table defects_table(const ComparisonReport& report);
Table tolerances_table(const ComparisonReport& report);
Table credibility_table(const ComparisonReport& report);

using namespace comparison;

namespace {

/// The badges of cases, by what a verdict means for the exit code.
std::string_view badge_class(Verdict verdict) {
  switch (verdict) {
    case Verdict::agrees: return "pass";
    case Verdict::differs:
    case Verdict::not_comparable: return "fail";
    case Verdict::not_distinguishable:
    case Verdict::not_judged: break;
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
         labelled("simulated", value_of(one, one.simulated), "number") +
         labelled("error", error, "number") +
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
         labelled("verdict", html_badge(group.verdict)) +
         labelled("subjects", count(group.subjects)) +
         labelled("subjects who agree", agreed_of(group)) +
         labelled("recordings", count(group.recordings)) +
         labelled("of them measured", count(group.measured)) +
         labelled("agree", count(group.agree)) + labelled("differ", count(group.differ)) +
         labelled("not distinguishable", count(group.not_distinguishable)) +
         labelled("not comparable", count(group.not_comparable)) +
         labelled("in the corridor", escape_markup(inside_of(group, rule)), "why") + "</tr>\n";
}

/// With a peak where there is one, as clinicians ask for it first.
std::string outcome_of(const Comparison& one) {
  if (one.verdict == Verdict::not_comparable) {
    return one.reasons.empty() ? "" : one.reasons.front();
  }
  const FeatureVerdict& peak = one.features.at(static_cast<std::size_t>(Feature::peak));
  return "peak " + value_of(peak, peak.recorded) + " recorded, " + value_of(peak, peak.simulated) +
         " simulated";
}

std::string recording_row(const ComparedRecording& input, const Comparison& one) {
  const Recording& recording = input.input.recording;
  const double length =
      recording.time.empty() ? 0.0 : recording.time.back() - recording.time.front();
  return "<tr><th scope=\"row\">" + escape_markup(recording.name) + "</th>" +
         labelled("verdict", html_badge(one.verdict)) +
         labelled("kind", std::string(io::word_of(recording.kind))) +
         labelled("group", escape_markup(name_of_group(recording.group))) +
         labelled("subject",
                  escape_markup(recording.subject.empty() ? "not said" : recording.subject)) +
         labelled("technique",
                  escape_markup(recording.technique.empty() ? "not said" : recording.technique)) +
         labelled("length",
                  quantity(length, "s") + " at " + quantity(recording.sample_rate, "Hz")) +
         labelled("outcome", escape_markup(outcome_of(one))) +
         labelled("source", escape_markup(recording.source.empty() ? "not said" : recording.source),
                  "why") +
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
  return verdict_table(head_of({"feature", "verdict", "#recorded", "#simulated", "#error", "#± U",
                                "#allowed", "tolerance"}),
                       rows);
}

std::string html_recordings(const ComparisonReport& report) {
  std::string rows;
  for (std::size_t n = 0; n < report.recordings.size(); ++n) {
    rows += recording_row(report.recordings[n], report.found.recordings[n]);
  }
  const std::string table =
      verdict_table(head_of({"recording", "verdict", "kind", "group", "subject", "technique",
                             "length", "outcome", "source"}),
                    rows);
  constexpr std::size_t many = 6;
  const std::size_t count = report.recordings.size();
  return count < many ? table
                      : "<details><summary>" + std::to_string(count) + " recordings</summary>" +
                            table + "</details>\n";
}

std::string html_groups(const ComparisonReport& report) {
  std::string rows;
  for (const GroupSummary& group : report.found.groups) {
    rows += group_row(group, report.options.corridor);
  }
  return verdict_table(
      head_of({"group", "verdict", "subjects", "who agree (95 %)", "recordings", "of them measured",
               "agree", "differ", "not distinguishable", "not comparable", "in the corridor"}),
      rows);
}

Table subjects_table(const GroupSummary& group) {
  Table table{
      .title = "Features over the subjects of " + name_of_group(group.group),
      .caption =
          "Several recordings of one subject count as their mean. Intervals of the mean: "
          "percentile "
          "bootstrap, seeded; of few subjects they are too narrow.",
      .columns = {"feature", "subjects", "mean", "SD", "95 % interval of the mean", "simulated"}};
  for (const FeatureSummary& one : group.features) {
    const auto value = [&](double number) { return shown(one.feature, number, one.unit); };
    const bool event = one.feature == Feature::loss_of_resistance;
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
  Table table{.title = "Ratings and distances of whole traces",
              .caption =
                  "They explain and never judge. ISO/TS 18571: R = 0.4 Z + 0.2 (phase + magnitude "
                  "+ slope), "
                  "of the filtered traces; E at the features, with u_val, is in their tables.",
              .columns = {"recording", "ISO R", "grade", "corridor Z", "phase", "magnitude",
                          "slope", "R unfiltered", "Sprague-Geers M", "P", "C",
                          "RMSE (" + unit.name + ")", "NRMSE"}};
  for (const Comparison& one : report.found.recordings) {
    if (one.verdict == Verdict::not_comparable) { continue; }
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
  Table table{.title = "What was found wrong with the recordings",
              .caption = "Nothing of it was mended: a gap stays a gap, and no figure counts it.",
              .columns = {"recording", "samples", "found", "warnings"}};
  for (const ComparedRecording& one : report.recordings) {
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
  Table table{.title = "Tolerances in force",
              .caption = "Of a recorded value; --tolerance replaces them.",
              .columns = {"feature", "allowed", "where it comes from"}};
  const QuantityKind quantity = report.options.comparison.quantity;
  for (std::size_t n = 0; n < feature_count; ++n) {
    const auto feature = static_cast<Feature>(n);
    const Tolerance tolerance = tolerance_of(feature, report.options.comparison);
    table.rows.push_back({in_words(feature), shown(tolerance, unit_of(feature, unit_of(quantity))),
                          tolerance.origin});
  }
  return table;
}

Table credibility_table(const ComparisonReport& report) {
  Table table{
      .title = "Credibility factors after ASME V&V 40-2018",
      .caption = "What would be enough, and what there is. Nothing that was not shown is counted.",
      .columns = {"activity", "factor", "goal", "shown", "evidence"}};
  for (const CredibilityFactor& factor : report.credibility) {
    table.rows.push_back({factor.activity, factor.factor, factor.goal,
                          std::string(comparison::name_of(factor.shown)), factor.evidence});
  }
  return table;
}

using namespace comparison;

namespace {

/// So many recordings are shown with all their figures; of more, each shows one.
constexpr std::size_t few_recordings = 3;
/// Beyond these a recording has tables alone: a page stays below some megabytes.
constexpr std::size_t most_drawn = 60;

/// The figures of one recording or one group, drawn.
struct Exhibits {
  std::vector<Figure> figures{};
  std::vector<std::string> drawings{};
};

struct Drawn {
  std::vector<Exhibits> recordings{};
  std::vector<Exhibits> groups{};
};

bool compared(const Comparison& one) { return one.verdict != Verdict::not_comparable; }

std::vector<Figure> figures_of(const ComparisonReport& report, std::size_t n) {
  if (!compared(report.found.recordings[n]) || n >= most_drawn) { return {}; }
  if (report.recordings.size() <= few_recordings) { return recording_figures(report, n); }
  return {overlay_figure(report, n)};
}

Drawn draw(const ComparisonReport& report) {
  Drawn drawn;
  for (std::size_t n = 0; n < report.recordings.size(); ++n) {
    drawn.recordings.push_back({.figures = figures_of(report, n)});
  }
  for (std::size_t n = 0; n < report.found.groups.size(); ++n) {
    drawn.groups.push_back({.figures = group_figures(report, n)});
  }
  std::vector<const Figure*> all;
  for (const auto* list : {&drawn.recordings, &drawn.groups}) {
    for (const Exhibits& exhibits : *list) {
      for (const Figure& figure : exhibits.figures) { all.push_back(&figure); }
    }
  }
  std::vector<std::string> svgs = draw_figures(all);
  auto next = svgs.begin();
  for (auto* list : {&drawn.recordings, &drawn.groups}) {
    for (Exhibits& exhibits : *list) {
      for (std::size_t n = 0; n < exhibits.figures.size(); ++n) {
        exhibits.drawings.push_back(std::move(*next++));
      }
    }
  }
  return drawn;
}

std::string html_of(const Exhibits& exhibits) {
  if (exhibits.figures.empty()) { return {}; }
  std::string html = "<div class=\"exhibits\">\n";
  for (std::size_t n = 0; n < exhibits.figures.size(); ++n) {
    html += html_figure(exhibits.figures[n], exhibits.drawings[n]);
  }
  return html + "</div>\n";
}

std::string simulation_words(const ComparedSimulation& simulation) {
  const bool scene = simulation.origin == ComparedSimulation::Origin::scene;
  return (scene ? "simulated from " : "read from ") + simulation.file.filename().string() +
         (simulation.title.empty() ? "" : ": " + simulation.title);
}

void add_simulation_facts(std::vector<Fact>& facts, const ComparedSimulation& simulation) {
  const std::vector<double>& time = simulation.trace.time;
  facts.push_back({"simulation", simulation_words(simulation),
                   time.empty() ? ""
                                : quantity(time.back() - time.front(), "s") + " long; FNV-1a " +
                                      simulation.hash});
  if (simulation.run_longer > 0.0) {
    facts.push_back({"run longer by", quantity(simulation.run_longer, "s"),
                     "than the scene says: the loss of resistance counts once its pressure stayed "
                     "low for 5 s"});
  }
}

std::vector<Fact> key_facts(const ComparisonReport& report) {
  const ComparisonOptions& o = report.options.comparison;
  std::vector<Fact> facts{{"recordings", kinds_of(report), tally_of(report)},
                          {"quantity", std::string(comparison::name_of(o.quantity)),
                           "verdicts come from features and corridor; ratings explain"}};
  if (report.recordings.size() > 1) {
    facts.insert(
        facts.begin() + 1,
        {"subjects", std::to_string(subjects_compared(report)),
         "who could be compared; a recording that does not say whose it is counts as one"});
  }
  add_simulation_facts(facts, report.simulation);
  const auto& all = report.found.recordings;
  const auto first = std::ranges::find_if(all, compared);
  if (first == all.end()) { return facts; }
  facts.push_back({"clocks", "aligned " + first->alignment.how,
                   "asked for: " + std::string(comparison::name_of(o.alignment)) +
                       (all.size() > 1 ? "; of the first recording"
                                       : "; lag " + quantity(first->alignment.lag, "s"))});
  const double cutoff = first->cutoff;
  facts.push_back(
      {"filter", cutoff > 0.0 ? quantity(cutoff, "Hz") : "none",
       "low-pass without phase, the same for both; at most a quarter of the lower rate"});
  return facts;
}

/// A sentence under the heading of every recording that is no measurement.
std::string honesty_of(const Recording& recording) {
  if (recording.kind == Recording::Kind::measured) { return {}; }
  return "<p class=\"reason\">" + std::string(io::reconstruction_note) +
         ": not a measurement</p>\n";
}

std::string recording_article(const ComparisonReport& report, std::size_t n,
                              const Exhibits& exhibits) {
  const Comparison& one = report.found.recordings[n];
  const Recording& recording = report.recordings[n].input.recording;
  std::string html = "<article>\n<h3>" + html_badge(one.verdict) + " <span>" +
                     escape_markup(recording.name) + "</span></h3>\n" + honesty_of(recording);
  if (!recording.note.empty()) {
    html += "<p class=\"soft\">" + escape_markup(recording.note) + "</p>\n";
  }
  if (report.recordings.size() > 1 || report.found.reasons.size() == 1) {
    html += html_notes(one.reasons);
  }
  html += html_of(exhibits);
  if (!compared(one)) { return html + "</article>\n"; }
  if (recording.depth.empty()) {
    html += "<p class=\"soft\">Depth was not recorded, so nothing is shown over depth.</p>\n";
  }
  if (report.recordings.size() <= few_recordings) {
    return html + html_features(one.features) + "</article>\n";
  }
  return html + "<details><summary>features, tolerances and verdicts</summary>\n" +
         html_features(one.features) + "</details></article>\n";
}

/// One reason stands in the banner already; many are folded.
std::string reasons_section(const ComparisonReport& report) {
  constexpr std::size_t many = 8;
  const std::vector<std::string>& reasons = report.found.reasons;
  if (reasons.size() < 2) { return {}; }
  const std::string notes = html_notes(reasons);
  return "<h2>Why</h2>\n" + (reasons.size() < many
                                 ? notes
                                 : "<details><summary>" + std::to_string(reasons.size()) +
                                       " reasons</summary>\n" + notes + "</details>\n");
}

std::string groups_section(const ComparisonReport& report, const Drawn& drawn) {
  if (report.recordings.size() < 2) { return {}; }
  std::string html = "<section>\n<h2>Groups of subjects</h2>\n" + html_groups(report);
  for (std::size_t n = 0; n < report.found.groups.size(); ++n) {
    const GroupSummary& group = report.found.groups[n];
    if (group.features.empty()) { continue; }
    html += "<article>\n<h3>" + html_badge(group.verdict) + " <span>" +
            escape_markup(name_of_group(group.group)) + "</span></h3>\n" +
            (report.found.groups.size() > 1 ? html_notes(group.reasons) : "") +
            html_of(drawn.groups[n]);
    if (!group.means.empty()) {
      html += "<p class=\"soft\">The simulated insertion against the means over subjects:</p>\n" +
              html_features(group.means);
    }
    html += html_table(subjects_table(group)) + "</article>\n";
  }
  return html + "</section>\n";
}

std::string recordings_section(const ComparisonReport& report, const Drawn& drawn) {
  std::string html =
      "<section>\n<h2>" +
      std::string(report.recordings.size() == 1 ? "The recording" : "Every recording") + "</h2>\n";
  if (report.recordings.size() > most_drawn) {
    html += "<p class=\"soft\">The first " + std::to_string(most_drawn) +
            " are drawn; of the others there are tables.</p>\n";
  }
  for (std::size_t n = 0; n < report.recordings.size(); ++n) {
    html += recording_article(report, n, drawn.recordings[n]);
  }
  return html + "</section>\n";
}

std::vector<Fact> rule_facts(const ComparisonReport& report) {
  const ComparisonOptions& o = report.options.comparison;
  const LossRule& loss = o.features.loss;
  const auto percent = [](double share) { return quantity(100.0 * share, "%"); };
  return {
      {"loss of resistance",
       "a fall by " + percent(loss.least_drop) + " within " + quantity(loss.longest_fall, "s"),
       "held for " + quantity(loss.hold, "s") + ", steady to " + percent(loss.unsteady) +
           " of the peak"},
      {"uncertainty", "U = " + short_number(o.uncertainties.coverage_factor) + " u_val",
       "u_val² = u_num² + u_input² + u_D²; a feature agrees or differs only if it does so at both "
       "ends of ± "
       "U"},
      {"u_D",
       o.quantity == QuantityKind::pressure ? "zero " + quantity(o.uncertainties.zero, "Pa") +
                                                  ", gain " + percent(o.uncertainties.gain)
                                            : "zero " + quantity(o.uncertainties.zero_force, "N") +
                                                  ", gain " + percent(o.uncertainties.gain),
       "beside noise, sampling and the alignment"},
      {"u_num and u_input",
       percent(o.uncertainties.numerical) + " and " + percent(o.uncertainties.input),
       "as stated on the command line; 0 by default"},
      {"corridor",
       "from " + std::to_string(report.options.corridor.least_subjects) + " subjects of a group",
       "several recordings of one subject count as their mean; " +
           percent(report.options.corridor.least_inside) +
           " of the simulated samples must lie in it"}};
}

std::vector<Fact> provenance_facts(const ComparisonReport& report) {
  std::vector<Fact> facts;
  for (const auto& [name, value] : report.provenance) { facts.push_back({name, value, ""}); }
  for (const ComparedRecording& one : report.recordings) {
    facts.push_back({one.file.filename().string(), "FNV-1a " + one.hash, ""});
  }
  return facts;
}

}  // namespace

std::string to_html(const ComparisonReport& report) {
  const Drawn drawn = draw(report);
  const std::string title = "Recorded and simulated insertion";
  const std::string version =
      report.provenance.contains("version") ? report.provenance.at("version") : "";
  std::string body =
      html_banner({.title = title,
                   .small_print = {report.command, version.empty() ? "" : "version " + version},
                   .held = holds(report),
                   .verdict = verdict_text(report),
                   .detail = verdict_sentence(report)});
  body += "<main>\n<h2>Key facts</h2>\n" + html_facts(key_facts(report));
  body += reasons_section(report) + "<h2>What was compared</h2>\n" + html_recordings(report) +
          groups_section(report, drawn) + recordings_section(report, drawn) +
          "<section>\n<h2>Whole traces</h2>\n" + html_table(ratings_table(report)) +
          "</section>\n<section>\n<h2>What the recordings lack</h2>\n" +
          html_table(defects_table(report)) +
          "</section>\n<section>\n<h2>How it was judged</h2>\n" + html_facts(rule_facts(report)) +
          html_table(tolerances_table(report)) +
          "</section>\n<section>\n<h2>What was shown, and what was not</h2>\n" +
          html_table(credibility_table(report)) + "</section>\n</main>\n" +
          html_provenance(provenance_facts(report), report.command);
  return html_page(title, body, {});
}

}  // namespace palpate
