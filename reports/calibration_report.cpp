// SPDX-License-Identifier: MIT

#include "reports/calibration_report.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "fixtures/io/recording_file.hpp"
#include "model/problem/recording.hpp"
#include "reports/html/html_page.hpp"
#include "reports/results/results_json.hpp"

namespace palpate {
namespace {

using namespace calibration;

/// Notes in order, each with its condition.
struct NoteList {
  std::vector<std::string> notes{};
  void add(bool holds, const std::string& text) {
    if (holds) { notes.push_back(text); }
  }
};

template <class Holds> long count_if(const CalibrationReport& report, const Holds& holds) {
  return std::ranges::count_if(report.recordings, holds);
}

void add_notes_on_recordings(const CalibrationReport& report, NoteList& list) {
  const auto with_force = [&report](ForceSource source) {
    return count_if(report, [source](const auto& r) { return r.observed.seen.force == source; });
  };
  list.add(report.reconstructed(),
           "Recordings that were rebuilt from published summary values give back what was put into "
           "them: peaks, plateaus and depths are published, the lines between them and the spread "
           "of subjects are assumed. Forces within a layer follow from such lines.");
  const long plunger = with_force(ForceSource::plunger);
  list.add(plunger > 0,
           "In " + counted(plunger, "continuous recording", "continuous recordings") +
               " pressure times plunger area represents the force along the needle (Eq. 1). This "
               "holds as long as the thumb on the plunger drives the needle.");
  list.add(plunger + with_force(ForceSource::recorded) == 0,
           "No force was recorded, so cutting force and friction are not constrained.");
  // The same thumb force on another area gives another pressure.
  if (const auto& syringe = report.result.fitted.syringe) {
    constexpr double same = 0.01;  // [1] of the area, as uncertain as a pressure gain
    const long others = count_if(report, [&](const auto& each) {
      return std::abs(each.observed.recording.plunger_area / syringe->plunger_area - 1.0) > same;
    });
    list.add(others > 0, counted(others, "recording is", "recordings are") +
                             " of a plunger of another area than the scene's " +
                             short_number(syringe->plunger_area, 4) +
                             " m^2: the thumb's force is then that of the scene's plunger and of "
                             "nobody's thumb.");
  }
  // pool() corrects depths only if all recordings have a BMI.
  const long without =
      count_if(report, [](const auto& each) { return !each.observed.recording.body_mass_index; });
  list.add(without > 0 && !std::cmp_equal(without, report.recordings.size()),
           std::to_string(without) + " of " + std::to_string(report.recordings.size()) +
               " recordings have no BMI: no depth was moved to a common one.");
  list.add(report.result.fit.data.subjects < least_subjects,
           "Fewer than three subjects: intervals hold for these alone.");
  list.add(count_if(report,
                    [](const auto& each) { return each.observed.recording.subject.empty(); }) > 0,
           "A recording that names no subject is treated as one of its own: several of one person "
           "make intervals too narrow.");
}

void add_notes_on_fit(const Calibration& result, NoteList& list) {
  const Fit& fit = result.fit;
  list.add(!fit.converged, "The search did not converge: values are the best that were tried.");
  for (const HeldOut& each : result.held_out) {
    list.add(!each.converged,
             "Without " + (each.group.empty() ? "recordings of no group" : each.group) +
                 " the search did not converge: their prediction is from the best values that "
                 "were tried.");
  }
  for (const FittedParameter& each : fit.parameters) {
    list.add(each.at_bound, each.parameter.key + " lies at its bound: nothing is known beyond it.");
  }
  list.add(fit.widening > 1.0,
           "The misfit is more than chance: the model cannot follow these recordings. Intervals "
           "are widened by " +
               short_number(fit.widening, 3) + ".");
  list.add(!(result.shortcut_cost() < 1.0),
           "The coarser block that was fitted differs from the scene by " +
               short_number(result.shortcut_cost(), 3) + " uncertainties: too coarse.");
  for (const auto& [telling, words] :
       {std::pair{Telling::insensitive,
                  "Left at their prior, as one spread of it moves what was seen by less than that "
                  "is uncertain: "},
        {Telling::wide,
         "Left at their prior, as other parameters do the same to all that was seen: "}}) {
    std::string keys;
    for (const FittedParameter& each : fit.parameters) {
      if (each.telling == telling) { keys += (keys.empty() ? "" : ", ") + each.parameter.key; }
    }
    list.add(!keys.empty(), words + keys + ".");
  }
}

constexpr double milliseconds = 1e3;  // [ms/s]

/// Factor and unit for the display of an observable.
struct Shown {
  double factor = 1.0;
  const char* unit = "";
};
Shown shown(Eigen::Index observable) {
  if (unit_of(observable) == "Pa") { return {1.0 / pascals_per_mmhg, "mmHg"}; }
  if (unit_of(observable) == "N") { return {1.0, "N"}; }
  return observable == index_of(Observable::drop_time) ? Shown{milliseconds, "ms"}
                                                       : Shown{mm, "mm"};
}

std::string with_unit(Eigen::Index observable, double value) {
  return quantity(shown(observable).factor * value, shown(observable).unit);
}

std::string interval_text(const comparison::Interval& interval) {
  return short_number(interval.lower, 3) + " to " + short_number(interval.upper, 3);
}

Table parameter_table(const Fit& fit) {
  Table table = make_table(
      "parameters", "Parameters",
      "Priors and bounds are log-normal about the scene's values; intervals are 95 %. "
      "Sensitivity: what one spread of the prior moves, in uncertainties of the recordings.",
      {"parameter", "unit", "told", "prior", "fitted", "interval", "bounds", "sensitivity"});
  const auto add = [&](const FittedParameter& each) {
    const bool told = each.telling == Telling::told;
    table.rows.push_back(
        {each.parameter.key, each.parameter.unit,
         told ? std::string("told") : "no: " + std::string(name_of(each.telling)),
         each.parameter.prior, told ? Cell(each.value) : Cell(std::string("the prior")),
         interval_text(each.interval), interval_text({each.parameter.lower, each.parameter.upper}),
         each.sensitivity < 0.01 ? "< 0.01" : short_number(each.sensitivity, 3)});
  };
  for (const bool told : {true, false}) {
    for (const FittedParameter& each : fit.parameters) {
      if ((each.telling == Telling::told) == told) { add(each); }
    }
  }
  return table;
}

Table observable_table(const Calibration& result) {
  const Fit& fit = result.fit;
  Table table = make_table(
      "observables", "Recordings and simulation",
      "Means over subjects with their standard uncertainty; the scene before and after, and "
      "the fitted scene without the coarser block and step that the fit uses.",
      {"observable", "subjects", "mean", "uncertainty", "before", "after", "after, whole scene"});
  for (const Eigen::Index row : fit.rows) {
    table.rows.push_back({std::to_string(table.rows.size() + 1) + " " + std::string(name_of(row)),
                          static_cast<double>(fit.data.count[static_cast<std::size_t>(row)]),
                          with_unit(row, fit.data.mean[row]),
                          with_unit(row, std::sqrt(fit.data.covariance(row, row))),
                          with_unit(row, fit.before[row]), with_unit(row, fit.after[row]),
                          with_unit(row, result.whole[row])});
  }
  return table;
}

Table correlation_table(const Fit& fit) {
  Table table =
      make_table("correlation", "Correlation",
                 "Of the logarithms of what was told. Near 1 or -1 two parameters are known "
                 "together alone.",
                 {"parameter"});
  for (std::size_t n = 0; n < fit.told.size(); ++n) {
    table.columns.push_back(std::to_string(n + 1));
  }
  for (std::size_t n = 0; n < fit.told.size(); ++n) {
    std::vector<Cell> row{std::to_string(n + 1) + " " + fit.parameters[fit.told[n]].parameter.key};
    for (std::size_t m = 0; m < fit.told.size(); ++m) {
      const double r = fit.correlation(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(m));
      row.emplace_back(std::round(100.0 * r) / 100.0 + 0.0);  // adding 0.0 avoids a negative zero
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table held_out_table(const std::vector<HeldOut>& held_out) {
  Table table =
      make_table("held-out", "Prediction of each group from the others",
                 "Fitted to all groups but one. Errors are root mean squares over observables, "
                 "relative: of those that were fitted, and of the group that was not.",
                 {"group left out", "subjects", "error, fitted", "error, predicted",
                  "peak recorded", "peak predicted"});
  const Eigen::Index peak = index_of(Observable::pressure_peak);
  for (const HeldOut& each : held_out) {
    table.rows.push_back(
        {each.group.empty() ? "(no group)" : each.group, static_cast<double>(each.subjects),
         short_number(100.0 * each.error_fitted, 3) + " %",
         short_number(100.0 * each.error_predicted, 3) + " %",
         with_unit(peak, each.seen.mean[peak]), with_unit(peak, each.predicted[peak])});
  }
  return table;
}

Table recording_table(const CalibrationReport& report) {
  Table table = make_table("recordings", "Recordings",
                           "Each with where its force along the needle comes from.",
                           {"file", "kind", "group", "technique", "force", "hash"});
  for (const CalibratedRecording& each : report.recordings) {
    table.rows.push_back({each.file, std::string(io::word_of(each.observed.recording.kind)),
                          each.observed.recording.group, each.observed.recording.technique,
                          std::string(name_of(each.observed.seen.force)), each.hash});
  }
  return table;
}

Figure profile_figure(const CalibrationReport& report) {
  const calibration::Profile& profile = report.result.profile;
  const Parameter& p = report.result.fit.parameters[profile.parameter].parameter;
  const auto [low, high] = std::ranges::minmax(profile.value);
  constexpr double threshold = 3.841;  // 0.95 quantile of chi-squared with one degree of freedom
  return {.title = "Profile of " + p.key,
          .caption =
              "Growth of the sum of squares where this parameter, told with the widest interval, "
              "is held and the others are fitted again. Dashed: 95 % if observables were "
              "independent; they are not, and the interval of the table is the wider one.",
          .x = {.label = p.key + " (" + p.unit + ")"},
          .y = {.label = "growth (1)"},
          .series = {{.label = "sum of squares",
                      .style = Series::Style::line_and_points,
                      .x = profile.value,
                      .y = profile.growth},
                     {.label = "3.84",
                      .style = Series::Style::dashed,
                      .x = {low, high},
                      .y = {threshold, threshold}}}};
}

/// Centre of a histogram bin of the depth after the loss of resistance [mm].
double middle_of(std::size_t bin) {
  return 0.5 * mm * (force_bins[bin].begin + force_bins[bin].end);
}

Series bins_of(const char* label, Series::Style style, const Observation& observation) {
  Series series{.label = label, .style = style};
  for (std::size_t n = 0; n < force_bins.size(); ++n) {
    const double force = observation[index_of(Observable::force) + static_cast<Eigen::Index>(n)];
    if (!std::isfinite(force)) { continue; }
    series.x.push_back(middle_of(n));
    series.y.push_back(force);
  }
  return series;
}

Figure force_figure(const Fit& fit) {
  Series band{.label = "recordings, 2 uncertainties", .style = Series::Style::band};
  for (std::size_t n = 0; n < force_bins.size(); ++n) {
    const Eigen::Index row = index_of(Observable::force) + static_cast<Eigen::Index>(n);
    if (!std::isfinite(fit.data.mean[row])) { continue; }
    const double reach = 2.0 * std::sqrt(fit.data.covariance(row, row));
    band.x.push_back(middle_of(n));
    band.y.push_back(fit.data.mean[row] - reach);
    band.y2.push_back(fit.data.mean[row] + reach);
  }
  return {.title = "Force along the needle before the loss of resistance",
          .caption =
              "Means over 2 mm of the way, 1.5 mm in the last, by the distance to where resistance "
              "is lost.",
          .x = {.label = "depth behind the loss of resistance (mm)"},
          .y = {.label = "force (N)"},
          .series = {std::move(band), bins_of("recordings", Series::Style::points, fit.data.mean),
                     bins_of("scene before", Series::Style::dashed, fit.before),
                     bins_of("scene after", Series::Style::line, fit.after)}};
}

Figure misfit_figure(const Fit& fit) {
  Series before{.label = "before", .style = Series::Style::points};
  Series after{.label = "after", .style = Series::Style::points};
  Series allowed{.label = "2 uncertainties", .style = Series::Style::band};
  for (const Eigen::Index row : fit.rows) {
    const double deviation = std::sqrt(fit.data.covariance(row, row));
    const auto place = static_cast<double>(before.x.size() + 1);
    for (auto [series, seen] : {std::pair{&before, &fit.before}, {&after, &fit.after}}) {
      series->x.push_back(place);
      series->y.push_back(((*seen)[row] - fit.data.mean[row]) / deviation);
    }
  }
  const auto end = static_cast<double>(fit.rows.size()) + 0.5;
  allowed.x = {0.5, end};
  allowed.y = {-2.0, -2.0};
  allowed.y2 = {2.0, 2.0};
  return {.title = "Misfit of every observable",
          .caption =
              "Simulated less recorded, in standard uncertainties; observables as the table below "
              "numbers them.",
          .x = {.label = "observable (1)", .minimum = 0.5, .maximum = end},
          .y = {.label = "misfit (1)"},
          .series = {std::move(allowed), std::move(before), std::move(after)}};
}

std::vector<Figure> calibration_figures(const CalibrationReport& report) {
  std::vector<Figure> figures{misfit_figure(report.result.fit)};
  if (std::isfinite(report.result.fit.data.mean[index_of(Observable::force)])) {
    figures.push_back(force_figure(report.result.fit));
  }
  if (report.result.profile.value.size() > 1) { figures.push_back(profile_figure(report)); }
  return figures;
}

using Json = nlohmann::ordered_json;

Json parameter_json(const FittedParameter& each) {
  const Parameter& p = each.parameter;
  return object("key", p.key, "unit", p.unit, "status", name_of(each.telling), "prior", p.prior,
                "prior_log_sd", p.spread, "prior_from", p.origin, "lower_bound", p.lower,
                "upper_bound", p.upper, "value", each.value, "interval_lower", each.interval.lower,
                "interval_upper", each.interval.upper, "interval_factor", each.interval_factor,
                "sensitivity", finite_or_null(each.sensitivity), "deviation_over_prior",
                finite_or_null(each.deviation), "at_bound", each.at_bound);
}

Json held_out_json(const HeldOut& held) {
  const auto observable = [&held](Eigen::Index row) {
    return object("name", name_of(row), "unit", unit_of(row), "mean",
                  finite_or_null(held.seen.mean[row]), "foretold",
                  finite_or_null(held.predicted[row]));
  };
  return object("group", held.group, "subjects", held.subjects, "converged", held.converged,
                "error_fitted", finite_or_null(held.error_fitted), "error_foretold",
                finite_or_null(held.error_predicted), "observables",
                list_of(held.seen.present(), observable));
}

Json recording_json(const CalibratedRecording& calibrated) {
  const Recording& recording = calibrated.observed.recording;
  Json json = object("file", calibrated.file, "name", recording.name, "kind",
                     io::word_of(recording.kind), "group", recording.group, "technique",
                     recording.technique, "force", name_of(calibrated.observed.seen.force),
                     "source", recording.source, "hash", calibrated.hash);
  if (const auto& index = recording.body_mass_index) { json["bmi_kg_per_m2"] = *index; }
  return json;
}

Json correlation_json(const Fit& fit) {
  Json rows = Json::array();
  for (const auto& row : fit.correlation.rowwise()) {
    rows.push_back(std::vector<double>(row.begin(), row.end()));
  }
  const auto key = [&fit](std::size_t n) { return fit.parameters[n].parameter.key; };
  return object("parameters", list_of(fit.told, key), "matrix", rows);
}

std::vector<Fact> facts_of(const CalibrationReport& report) {
  const calibration::Calibration& result = report.result;
  const calibration::Fit& fit = result.fit;
  const std::size_t freedom = fit.data.degrees_of_freedom();
  return {{"scene", report.scene, ""},
          {"search", fit.converged ? "converged" : "did not converge",
           "in " + std::to_string(fit.iterations) + " iterations, " +
               std::to_string(result.simulations) + " simulations of a coarser block"},
          {"cost of the coarser block", quantity(result.shortcut_cost(), ""),
           "largest difference to the whole scene, in uncertainties"},
          {"intervals", freedom == 0 ? "normal" : "Student's t",
           freedom == 0 ? "too few subjects for a spread"
                        : "spread between subjects with " + std::to_string(freedom) +
                              " degrees of freedom"}};
}

std::string kind_banner(const CalibrationReport& report) {
  return counted(report.recordings.size(), "recording, ", "recordings, ") +
         (report.reconstructed() ? "reconstructed, not measured" : "measured");
}

}  // namespace

bool CalibrationReport::reconstructed() const {
  return std::ranges::any_of(recordings, [](const CalibratedRecording& r) {
    return r.observed.recording.kind == Recording::Kind::reconstructed;
  });
}

std::string calibration_verdict(const CalibrationReport& report) {
  const Fit& fit = report.result.fit;
  const std::string told =
      std::to_string(fit.told.size()) + " of " + std::to_string(fit.parameters.size());
  if (fit.told.empty()) {
    return "Nothing fitted: the recordings tell none of " + std::to_string(fit.parameters.size()) +
           " parameters";
  }
  if (report.result.outcome().status == Status::pass) {
    return "Fitted: the recordings tell " + told + " parameters";
  }
  return "Fell short: " + told + " parameters were fitted, and not every check of the fit holds";
}

std::string calibration_detail(const CalibrationReport& report) {
  const Fit& fit = report.result.fit;
  std::string text = "Sum of squares over " + std::to_string(fit.rows.size()) +
                     " observables: " + short_number(fit.misfit_before, 3) + " before, " +
                     short_number(fit.misfit_after, 3) + " after. From " +
                     counted(report.recordings.size(), "recording", "recordings");
  text += report.reconstructed()
              ? ", reconstructed from published summary values: no evidence about patients."
              : ".";
  return text;
}

std::vector<std::string> calibration_warnings(const CalibrationReport& report) {
  NoteList list;
  add_notes_on_recordings(report, list);
  add_notes_on_fit(report.result, list);
  return list.notes;
}

std::string to_json(const CalibrationReport& report) {
  const Calibration& result = report.result;
  const Fit& fit = result.fit;
  const auto observable = [&](Eigen::Index row) {
    return object("name", name_of(row), "unit", unit_of(row), "subjects",
                  fit.data.count[static_cast<std::size_t>(row)], "mean",
                  finite_or_null(fit.data.mean[row]), "uncertainty",
                  finite_or_null(std::sqrt(fit.data.covariance(row, row))), "before",
                  finite_or_null(fit.before[row]), "after", finite_or_null(fit.after[row]),
                  "after_without_shortcuts", finite_or_null(result.whole[row]));
  };
  Json profile = nullptr;
  if (!result.profile.value.empty()) {
    profile = object("key", fit.parameters[result.profile.parameter].parameter.key, "value",
                     result.profile.value, "growth", result.profile.growth);
  }
  return json_text(
      object("schema", 1, "verdict", calibration_verdict(report), "held",
             result.outcome().status == Status::pass, "scene", report.scene, "scene_hash",
             report.scene_hash, "converged", fit.converged, "iterations", fit.iterations,
             "simulations", result.simulations, "misfit_before", fit.misfit_before, "misfit_after",
             fit.misfit_after, "interval_widening", fit.widening, "shortcut_cost",
             finite_or_null(result.shortcut_cost()), "parameters",
             list_of(fit.parameters, parameter_json), "correlation", correlation_json(fit),
             "observables", list_of(fit.rows, observable), "profile", profile,
             "leave_one_group_out", list_of(result.held_out, held_out_json), "recordings",
             list_of(report.recordings, recording_json), "warnings", calibration_warnings(report)),
      2);
}

std::string to_html(const CalibrationReport& report) {
  std::vector<Table> tables{parameter_table(report.result.fit), observable_table(report.result)};
  if (!report.result.held_out.empty()) { tables.push_back(held_out_table(report.result.held_out)); }
  if (!report.result.fit.told.empty()) { tables.push_back(correlation_table(report.result.fit)); }
  tables.push_back(recording_table(report));
  Section exhibits{.kind = Section::Kind::exhibits};
  exhibits.parts.assign(tables.begin() + 1, tables.end());
  std::vector<PagePart> fit{exhibits_of(calibration_figures(report)), std::move(exhibits)};
  if (report.result.held_out.empty()) {
    fit.emplace_back(Notes{{"Groups were not left out in turn: that needs two groups or more."}});
  }
  return render({.banner = {.title = "Calibration of " + report.scene,
                            .small_print = {kind_banner(report)},
                            .status = report.result.outcome().status,
                            .verdict = calibration_verdict(report),
                            .detail = calibration_detail(report)},
                 .parts = {Section{.heading = "Limits of this result",
                                   .parts = {Notes{calibration_warnings(report)}}},
                           Section{.heading = "Key facts", .parts = {facts_of(report)}},
                           Section{.heading = "Fitted parameters", .parts = {tables.front()}},
                           Section{.heading = "Fit and recordings", .parts = std::move(fit)}},
                 .provenance = facts_of_map(report.provenance),
                 .command = report.command});
}

// Calibration with insertions of several conditions.

namespace {

using comparison::FeatureSummary;

/// Number of judged features, and of those within the allowed standard deviations.
struct Share {
  std::size_t all = 0;
  std::size_t within = 0;
  void add(const ConditionCheck& condition) {
    const std::vector<FeatureError> errors = judged_features(condition);
    all += errors.size();
    within += static_cast<std::size_t>(std::ranges::count_if(errors, &FeatureError::within));
  }
  [[nodiscard]] std::string text(const std::string& kind) const {
    return std::to_string(within) + " of " + std::to_string(all) + kind + " features within two SD";
  }
};

/// "8 of 9 features within two SD; 93 % of the samples in the corridor of the recordings"
std::string share_of(const ConditionCheck& condition) {
  Share share;
  share.add(condition);
  std::string text = share.text("");
  if (const comparison::GroupSummary& group = condition.group(); group.corridor) {
    text += "; " + short_number(100.0 * group.coverage.inside, 3) +
            " % of the samples in the corridor of the recordings";
  }
  return text;
}

std::string simulated_text(const FeatureSummary& one) {
  return one.simulated ? comparison::shown(one.feature, *one.simulated, one.unit) : "absent";
}

/// One line for each feature that is farther than two standard deviations from the recordings:
/// "skin: withdrawal force: -2.60 N simulated, -2.14 N (SD 0.16 N) measured, -2.9 SD".
std::vector<std::string> features_off(const ConditionCheck& condition) {
  std::vector<std::string> lines;
  for (const FeatureError& error : judged_features(condition)) {
    if (error.within()) { continue; }
    const FeatureSummary& one = *error.feature;
    lines.push_back(
        condition.name + ": " + comparison::in_words(one.feature) + ": " + simulated_text(one) +
        " simulated, " + comparison::shown(one.feature, one.mean, one.unit) + " (SD " +
        comparison::shown(one.feature, one.deviation, one.unit) + ") measured" +
        (std::isfinite(error.deviations) ? ", " + short_number(error.deviations, 2) + " SD"
                                         : std::string()));
  }
  return lines;
}

/// Rows of a table with the features of conditions, under these first columns.
void add_rows(Table& table, const std::vector<Cell>& first, const ConditionCheck& condition) {
  for (const FeatureError& error : judged_features(condition)) {
    const FeatureSummary& one = *error.feature;
    std::vector<Cell> row = first;
    row.insert(
        row.end(),
        {Cell(comparison::in_words(one.feature)), Cell(static_cast<double>(one.count)),
         Cell(comparison::shown(one.feature, one.mean, one.unit)),
         Cell(comparison::shown(one.feature, one.deviation, one.unit)), Cell(simulated_text(one)),
         Cell(std::isfinite(error.deviations) ? short_number(error.deviations, 2)
                                              : std::string("-")),
         Cell(std::string(error.within() ? "yes" : "no"))});
    table.rows.push_back(std::move(row));
  }
}

Table left_out_table(const std::vector<LeftOutNeedle>& left_out) {
  Table table = make_table(
      "left-out", "Each needle predicted by the others",
      "Fitted without the recordings of the needle, then compared with them. SD: over the "
      "recordings of this needle alone.",
      {"needle", "condition", "feature", "recordings", "measured", "SD", "simulated", "in SD",
       "within 2"});
  for (const LeftOutNeedle& needle : left_out) {
    for (const ConditionCheck& condition : needle.conditions) {
      add_rows(table, {needle.needle, condition.name + (condition.fitted ? "" : " (predicted)")},
               condition);
    }
  }
  return table;
}

Json condition_json(const ConditionCheck& condition, const ComparisonReport& compared) {
  const comparison::GroupSummary& group = condition.group();
  const auto feature = [](const FeatureError& error) {
    const FeatureSummary& one = *error.feature;
    return object("name", comparison::name_of(one.feature), "unit", one.unit, "count", one.count,
                  "mean", finite_or_null(one.mean), "standard_deviation",
                  finite_or_null(one.deviation), "simulated", one.simulated, "deviations_off",
                  finite_or_null(error.deviations));
  };
  const auto recording = [](const RecordingFile& one) {
    return object("file", one.file.filename().string(), "kind",
                  io::word_of(one.input.recording.kind), "subject", one.input.recording.subject,
                  "source", one.input.recording.source, "hash", one.hash);
  };
  return object("name", condition.name, "fitted", condition.fitted, "scene",
                compared.simulation.file.filename().string(), "scene_hash",
                compared.simulation.hash, "verdict", comparison::verdict_word(group.outcome.status),
                "features", list_of(judged_features(condition), feature), "inside_corridor",
                group.corridor ? Json(group.coverage.inside) : Json(nullptr), "recordings",
                list_of(compared.recordings, recording));
}

std::size_t count_of(const InsertionFitReport& report, bool fitted) {
  return static_cast<std::size_t>(
      std::ranges::count(report.result.conditions, fitted, &ConditionCheck::fitted));
}

Section conditions_section(const InsertionFitReport& report, bool fitted) {
  Section section{.kind = Section::Kind::section,
                  .heading = fitted ? "Fitted conditions" : "Predicted conditions"};
  for (std::size_t n = 0; n < report.conditions.size(); ++n) {
    if (report.result.conditions[n].fitted != fitted) { continue; }
    section.parts.emplace_back(group_section(report.conditions[n], 0));
  }
  return section;
}

std::vector<Fact> facts_of(const InsertionFitReport& report) {
  const InsertionFit& result = report.result;
  const Fit& fit = result.fit;
  std::string starts;
  for (const double misfit : result.misfits) {
    starts += (starts.empty() ? "" : ", ") +
              (std::isfinite(misfit) ? short_number(misfit, 3) : std::string("failed"));
  }
  std::vector<Fact> facts;
  for (const ConditionCheck& condition : result.conditions) {
    facts.push_back(
        {condition.name, condition.fitted ? "fitted" : "predicted", share_of(condition)});
  }
  facts.insert(facts.end(), {{"search", fit.converged ? "converged" : "did not converge",
                              "in " + std::to_string(fit.iterations) + " iterations, " +
                                  std::to_string(result.simulations) + " simulations"},
                             {"sum of squares", short_number(fit.misfit_after, 3),
                              "over " + std::to_string(fit.rows.size()) + " features; " +
                                  short_number(fit.misfit_before, 3) + " before the fit"},
                             {"starts", starts, "sum of squares from each; the least is the fit"}});
  return facts;
}

}  // namespace

std::string calibration_verdict(const InsertionFitReport& report) {
  const Fit& fit = report.result.fit;
  const bool predicts = count_of(report, false) > 0;
  Share share;
  for (const ConditionCheck& condition : report.result.conditions) {
    if (condition.fitted != predicts) { share.add(condition); }
  }
  return "Fitted: " + std::to_string(fit.told.size()) + " of " +
         counted(fit.parameters.size(), "parameter", "parameters") + "; " +
         share.text(predicts ? " predicted" : " fitted");
}

std::vector<std::string> calibration_warnings(const InsertionFitReport& report) {
  const InsertionFit& result = report.result;
  NoteList list;
  std::size_t phantoms = 0;
  std::size_t all = 0;
  for (const ComparisonReport& each : report.conditions) {
    all += each.recordings.size();
    phantoms += each.found.groups.front().phantoms;
  }
  list.add(phantoms == all,
           "All recordings were made in a phantom: the values hold for its materials and needle "
           "and are no evidence about patients.");
  list.add(phantoms > 0 && phantoms < all, std::to_string(phantoms) + " of " + std::to_string(all) +
                                               " recordings were made in a phantom.");
  list.add(count_of(report, false) == 0,
           "No condition was predicted: the features of the fitted ones agree by construction.");
  list.add(!result.fit.converged,
           "The search did not converge: values are the best that were tried.");
  for (const FittedParameter& each : result.fit.parameters) {
    list.add(each.at_bound, each.parameter.key + " lies at its bound: nothing is known beyond it.");
  }
  list.add(result.fit.widening > 1.0,
           "The misfit is more than chance: the model cannot follow all features at once. "
           "Intervals are widened by " +
               short_number(result.fit.widening, 3) + ".");
  for (const ConditionCheck& condition : result.conditions) {
    for (const std::string& line : features_off(condition)) {
      list.add(true, line + (condition.fitted ? " (fitted)" : "") + ".");
    }
    list.add(condition.group().only_curve_differs,
             condition.name + ": features agree, curve does not.");
  }
  return list.notes;
}

std::string to_json(const InsertionFitReport& report) {
  const InsertionFit& result = report.result;
  const Fit& fit = result.fit;
  Json conditions = Json::array();
  for (std::size_t n = 0; n < result.conditions.size(); ++n) {
    conditions.push_back(condition_json(result.conditions[n], report.conditions[n]));
  }
  Json left_out = Json::array();
  for (const LeftOutNeedle& needle : result.left_out) {
    Json predicted = Json::array();
    for (const ConditionCheck& condition : needle.conditions) {
      predicted.push_back(object("name", condition.name, "fitted", condition.fitted, "off",
                                 features_off(condition)));
    }
    left_out.push_back(
        object("needle", needle.needle, "converged", needle.converged, "conditions", predicted));
  }
  return json_text(object("schema", 1, "verdict", calibration_verdict(report), "held",
                          result.outcome().status == Status::pass, "converged", fit.converged,
                          "iterations", fit.iterations, "simulations", result.simulations, "starts",
                          result.misfits.size(), "misfit_before", fit.misfit_before, "misfit_after",
                          fit.misfit_after, "interval_widening", fit.widening, "parameters",
                          list_of(fit.parameters, parameter_json), "correlation",
                          correlation_json(fit), "conditions", conditions, "leave_one_needle_out",
                          left_out, "warnings", calibration_warnings(report)),
                   2);
}

std::string to_html(const InsertionFitReport& report) {
  const InsertionFit& result = report.result;
  const Outcome outcome = result.outcome();
  Section parameters{.kind = Section::Kind::exhibits, .parts = {parameter_table(result.fit)}};
  if (!result.left_out.empty()) { parameters.parts.emplace_back(left_out_table(result.left_out)); }
  if (!result.fit.told.empty()) { parameters.parts.emplace_back(correlation_table(result.fit)); }
  std::vector<PagePart> parts{
      Section{.heading = "Limits of this result", .parts = {Notes{calibration_warnings(report)}}},
      Section{.heading = "Key facts", .parts = {facts_of(report)}}};
  if (count_of(report, false) > 0) { parts.emplace_back(conditions_section(report, false)); }
  parts.emplace_back(conditions_section(report, true));
  parts.emplace_back(Section{.heading = "Fitted parameters", .parts = {std::move(parameters)}});
  std::size_t recordings = 0;
  for (const ComparisonReport& each : report.conditions) { recordings += each.recordings.size(); }
  return render({.banner = {.title = "Calibration with measured insertions",
                            .small_print = {counted(recordings, "recording", "recordings")},
                            .status = outcome.status,
                            .verdict = calibration_verdict(report),
                            .detail = outcome.reasons.empty() ? "" : outcome.reasons.front()},
                 .parts = std::move(parts),
                 .provenance = facts_of_map(report.provenance),
                 .command = report.command});
}

}  // namespace palpate
