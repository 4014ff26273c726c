// SPDX-License-Identifier: MIT

#include "reports/comparison_report.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <iterator>
#include <string>

#include "fixtures/io/recording_file.hpp"
#include "reports/html/html_page.hpp"
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
  const auto kind = [](const RecordingFile& one) { return one.input.recording.kind; };
  return static_cast<std::size_t>(
      std::ranges::count(report.recordings, Recording::Kind::reconstructed, kind));
}

std::size_t count_of(const ComparisonReport& report, Status status) {
  const auto of = [](const Comparison& one) { return one.outcome.status; };
  return static_cast<std::size_t>(std::ranges::count(report.found.recordings, status, of));
}

/// Kinds of recording with their counts: "3 measured recordings".
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

std::size_t subjects_compared(const ComparisonReport& report) {
  std::size_t count = 0;
  for (const GroupSummary& group : report.found.groups) { count += group.subjects; }
  return count;
}

std::string name_of_group(const std::string& group) {
  return group.empty() ? "without a group" : group;
}

}  // namespace

std::string subjects_of(const SubjectCorridor& corridor) {
  const std::string subjects = counted(corridor.subjects, "subject", "subjects");
  return corridor.recordings == corridor.subjects
             ? subjects
             : subjects + " (" + counted(corridor.recordings, "recording", "recordings") + ")";
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
  std::string text(verdict_word(report.found.outcome.status));
  text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  const std::size_t left_out = count_of(report, Status::error);
  if (left_out > 0 && report.found.outcome.status != Status::error) {
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
  if (report.found.outcome.status == Status::pass) {
    sentence += ". Every feature that can be judged lies within its tolerance.";
  } else {
    sentence += report.found.outcome.reasons.empty()
                    ? "."
                    : ": " + report.found.outcome.reasons.front() + ".";
  }
  if (reconstructed_count(report) > 0) {
    sentence += " What was reconstructed is no evidence about patients.";
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

namespace {

Badge badge_of(Status status) { return {status, std::string(verdict_word(status))}; }

std::string value_of(const FeatureComparison& one, const Measured& measured) {
  return measured.value ? shown(one.feature, *measured.value, one.quantity.unit) : "-";
}

std::string allowed_of(const FeatureComparison& one) {
  if (one.feature == Feature::loss_of_resistance) { return "the same"; }
  if (one.status == Status::skip) { return "-"; }
  const Quantity& q = one.quantity;
  return shown_interval(one.feature, {q.lower, q.upper}, q.unit);
}

std::string why_of(const FeatureComparison& one) {
  if (!one.reason.empty()) { return one.reason; }
  if (one.feature == Feature::loss_of_resistance) { return one.tolerance.origin; }
  return shown(one.tolerance, one.quantity.unit) +
         (one.below_uncertainty ? "; error below u_val" : "");
}

/// Table of features: both values, allowed interval, verdict and tolerance.
LabelledTable features_table(const std::vector<FeatureComparison>& features) {
  LabelledTable table{.columns = {"feature", "verdict", "recorded", "simulated", "error", "± U",
                                  "allowed", "tolerance"},
                      .numbers = 5};
  for (const FeatureComparison& one : features) {
    const bool numbers = one.feature != Feature::loss_of_resistance;
    const std::string error = numbers ? shown(one.feature, one.error, one.quantity.unit) : "-";
    const std::string uncertainty = shown_uncertainty(one);
    table.rows.push_back({in_words(one.feature), badge_of(one.status), value_of(one, one.recorded),
                          value_of(one, one.simulated), error,
                          uncertainty.empty() ? "-" : uncertainty, allowed_of(one), why_of(one)});
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

/// Table of groups: counts and corridor.
LabelledTable groups_table(const ComparisonReport& report) {
  LabelledTable table{.columns = {"group", "verdict", "subjects", "subjects who agree (95 %)",
                                  "recordings", "of them measured", "agree", "differ",
                                  "not distinguishable", "not comparable", "in the corridor"}};
  const auto count = [](auto number) { return std::to_string(number); };
  for (const GroupSummary& group : report.found.groups) {
    table.rows.push_back({name_of_group(group.group), badge_of(group.outcome.status),
                          count(group.subjects), agreed_of(group), count(group.recordings),
                          count(group.measured), count(group.tally.passed),
                          count(group.tally.failed), count(group.tally.inconclusive),
                          count(group.tally.errors), inside_of(group, report.options.corridor)});
  }
  return table;
}

/// Verdict text, with the peak if it was compared, since clinicians look at the peak first.
std::string outcome_of(const Comparison& one) {
  if (one.outcome.status == Status::error) {
    return one.outcome.reasons.empty() ? "" : one.outcome.reasons.front();
  }
  const FeatureComparison& peak = one.features.at(static_cast<std::size_t>(Feature::peak));
  return "peak " + value_of(peak, peak.recorded) + " recorded, " + value_of(peak, peak.simulated) +
         " simulated";
}

/// Table of recordings: properties and verdict.
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
    table.rows.push_back({recording.name, badge_of(one.outcome.status),
                          std::string(io::word_of(recording.kind)), name_of_group(recording.group),
                          or_not_said(recording.subject), or_not_said(recording.technique),
                          quantity(length, "s") + " at " + quantity(recording.sample_rate, "Hz"),
                          outcome_of(one), or_not_said(recording.source)});
  }
  constexpr std::size_t many = 6;
  if (table.rows.size() < many) { return table; }
  return Section{.kind = Section::Kind::folded,
                 .heading = std::to_string(table.rows.size()) + " recordings",
                 .parts = {std::move(table)}};
}

/// Table of features over the subjects of a group: mean, SD, interval, simulated value.
Table subjects_table(const GroupSummary& group) {
  Table table{
      .title = "Features over the subjects of " + name_of_group(group.group),
      .caption =
          "Several recordings of one subject count as their mean. Intervals of the mean: "
          "percentile bootstrap, seeded; of few subjects they are too narrow.",
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

/// Table of ISO 18571 with its parts, Sprague-Geers and RMSE for every compared recording.
Table ratings_table(const ComparisonReport& report) {
  const FieldUnit unit = field_unit(unit_of(report.options.comparison.quantity));
  Table table{
      .title = "Ratings and distances of whole traces",
      .caption =
          "They explain and never judge. ISO/TS 18571: R = 0.4 Z + 0.2 (phase + magnitude + "
          "slope), of the filtered traces; E at the features, with u_val, is in their tables.",
      .columns = {"recording", "ISO R", "grade", "corridor Z", "phase", "magnitude", "slope",
                  "R unfiltered", "Sprague-Geers M", "P", "C", "RMSE (" + unit.name + ")",
                  "NRMSE"}};
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
  Table table{.title = "What was found wrong with the recordings",
              .caption = "Nothing of it was mended: a gap stays a gap, and no figure counts it.",
              .columns = {"recording", "samples", "found", "warnings"}};
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

/// Maximum number of recordings for which all figures are shown; with more, each has one figure.
constexpr std::size_t few_recordings = 3;
/// Maximum number of recordings with figures. It limits the page to some megabytes.
constexpr std::size_t most_drawn = 60;

bool compared(const Comparison& one) { return one.outcome.status != Status::error; }

std::vector<Figure> figures_of(const ComparisonReport& report, std::size_t n) {
  if (!compared(report.found.recordings[n]) || n >= most_drawn) { return {}; }
  if (report.recordings.size() <= few_recordings) { return recording_figures(report, n); }
  return {overlay_figure(report, n)};
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
         "with a comparable recording; a recording that names no subject is one of its own"});
  }
  add_simulation_facts(facts, report.simulation);
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
  Section section{.kind = Section::Kind::article,
                  .heading = recording.name,
                  .badge = badge_of(one.outcome.status)};
  std::vector<PagePart>& parts = section.parts;
  if (recording.kind != Recording::Kind::measured) {
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
  if (report.recordings.size() <= few_recordings) {
    parts.emplace_back(features_table(one.features));
  } else {
    parts.emplace_back(Section{.kind = Section::Kind::folded,
                               .heading = "features, tolerances and verdicts",
                               .parts = {features_table(one.features)}});
  }
  return section;
}

/// Adds the reasons, except the first, which is in the banner. A long list is collapsed.
void add_reasons(const ComparisonReport& report, std::vector<PagePart>& parts) {
  constexpr std::size_t many = 8;
  const std::vector<std::string>& reasons = report.found.outcome.reasons;
  if (reasons.size() < 2) { return; }
  PagePart notes = Notes{reasons};
  if (reasons.size() >= many) {
    notes = Section{.kind = Section::Kind::folded,
                    .heading = std::to_string(reasons.size()) + " reasons",
                    .parts = {Notes{reasons}}};
  }
  parts.emplace_back(Section{.heading = "Why", .parts = {std::move(notes)}});
}

Section group_section(const ComparisonReport& report, std::size_t n) {
  const GroupSummary& group = report.found.groups[n];
  Section section{.kind = Section::Kind::article,
                  .heading = name_of_group(group.group),
                  .badge = badge_of(group.outcome.status)};
  if (report.found.groups.size() > 1) { section.parts.emplace_back(Notes{group.outcome.reasons}); }
  section.parts.emplace_back(exhibits_of(group_figures(report, n)));
  if (!group.means.empty()) {
    section.parts.emplace_back(
        Paragraph{"The simulated insertion compared with the means over subjects:"});
    section.parts.emplace_back(features_table(group.means));
  }
  section.parts.emplace_back(subjects_table(group));
  return section;
}

void add_groups(const ComparisonReport& report, std::vector<PagePart>& parts) {
  if (report.recordings.size() < 2) { return; }
  Section section{.kind = Section::Kind::section,
                  .heading = "Groups of subjects",
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
       "several recordings of one subject count as their mean; " +
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

}  // namespace

std::string to_html(const ComparisonReport& report) {
  const std::string version =
      report.provenance.contains("version") ? report.provenance.at("version") : "";
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

}  // namespace palpate
