// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "model/dynamics/recording_defects.hpp"
#include "reports/calibration_report.hpp"
#include "reports/markup.hpp"
#include "reports/shown_units.hpp"

namespace palpate {
namespace {

using namespace calibration;

constexpr double milliseconds = 1e3;  // [ms/s]

/// As clinicians read it.
struct Shown {
  double factor = 1.0;
  const char* unit = "";
};
Shown shown(Eigen::Index observable) {
  if (is_pressure(observable)) { return {1.0 / pascals_per_mmhg, "mmHg"}; }
  if (is_force(observable)) { return {1.0, "N"}; }
  return observable == index_of(Observable::drop_time) ? Shown{milliseconds, "ms"} : Shown{mm, "mm"};
}

std::string with_unit(Eigen::Index observable, double value) {
  return quantity(shown(observable).factor * value, shown(observable).unit);
}

std::string interval_text(const comparison::Interval& interval) {
  return short_number(interval.lower, 3) + " to " + short_number(interval.upper, 3);
}

std::string small_text(double value) { return value < 0.01 ? "< 0.01" : short_number(value, 3); }

Table parameter_table(const Fit& fit) {
  Table table{
      .id = "parameters",
      .title = "Parameters",
      .caption =
          "Priors and bounds are log-normal about the scene's values; intervals are 95 %. Sensitivity: "
          "what one spread of the prior moves, in uncertainties of the recordings.",
      .columns = {"parameter", "unit", "told", "prior", "fitted", "interval", "bounds", "sensitivity"}};
  const auto add = [&](const FittedParameter& each) {
    const bool told = each.telling == Telling::told;
    table.rows.push_back(
        {each.parameter.key, each.parameter.unit,
         told ? std::string("told") : "no: " + std::string(name_of(each.telling)), each.parameter.prior,
         told ? Cell(each.value) : Cell(std::string("the prior")), interval_text(each.interval),
         interval_text({each.parameter.lower, each.parameter.upper}), small_text(each.sensitivity)});
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
  Table table{
      .id = "observables",
      .title = "Recordings and simulation",
      .caption =
          "Means over subjects with their standard uncertainty; the scene before and after, and the "
          "fitted scene without the coarser block and step that the fit uses.",
      .columns = {"observable", "subjects", "mean", "uncertainty", "before", "after",
                  "after, whole scene"}};
  for (const Eigen::Index row : fit.rows) {
    table.rows.push_back(
        {std::to_string(table.rows.size() + 1) + " " + name_of(row),
         static_cast<double>(fit.data.count[static_cast<std::size_t>(row)]),
         with_unit(row, fit.data.mean[row]), with_unit(row, std::sqrt(fit.data.covariance(row, row))),
         with_unit(row, fit.before[row]), with_unit(row, fit.after[row]), with_unit(row, result.whole[row])});
  }
  return table;
}

Table correlation_table(const Fit& fit) {
  Table table{
      .id = "correlation",
      .title = "Correlation",
      .caption = "Of the logarithms of what was told. Near 1 or -1 two parameters are known together alone.",
      .columns = {"parameter"}};
  for (std::size_t n = 0; n < fit.told.size(); ++n) { table.columns.push_back(std::to_string(n + 1)); }
  for (std::size_t n = 0; n < fit.told.size(); ++n) {
    std::vector<Cell> row{std::to_string(n + 1) + " " + fit.parameters[fit.told[n]].parameter.key};
    for (std::size_t m = 0; m < fit.told.size(); ++m) {
      const double r = fit.correlation(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(m));
      row.emplace_back(std::round(100.0 * r) / 100.0 + 0.0);  // no minus before a zero
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table held_out_table(const std::vector<HeldOut>& held_out) {
  Table table{.id = "held-out",
              .title = "Each group foretold from the others",
              .caption =
                  "Fitted to all groups but one. Errors are root mean squares over observables, relative: of "
                  "those that were fitted, and of the group that was not.",
              .columns = {"group held out", "subjects", "error, fitted", "error, foretold", "peak seen",
                          "peak foretold"}};
  const Eigen::Index peak = index_of(Observable::pressure_peak);
  for (const HeldOut& each : held_out) {
    table.rows.push_back({each.group.empty() ? "(no group)" : each.group,
                          static_cast<double>(each.subjects),
                          short_number(100.0 * each.error_fitted, 3) + " %",
                          short_number(100.0 * each.error_foretold, 3) + " %",
                          with_unit(peak, each.seen.mean[peak]), with_unit(peak, each.foretold[peak])});
  }
  return table;
}

Table recording_table(const CalibrationReport& report) {
  Table table{.id = "recordings",
              .title = "Recordings",
              .caption = "Each with where its force along the needle comes from.",
              .columns = {"file", "kind", "group", "technique", "force", "hash"}};
  for (const CalibratedRecording& each : report.recordings) {
    table.rows.push_back(
        {each.file, std::string(each.kind == Recording::Kind::measured ? "measured" : "reconstructed"),
         each.subject.group, each.technique, std::string(name_of(each.subject.seen.force)), each.hash});
  }
  return table;
}

Figure profile_figure(const CalibrationReport& report) {
  const calibration::Profile& profile = report.result.profile;
  const Parameter& p = report.result.fit.parameters[profile.parameter].parameter;
  const auto [low, high] = std::ranges::minmax(profile.value);
  constexpr double threshold = 3.841;  // chi-squared of one degree of freedom, 0.95
  return {
      .id = "profile",
      .title = "Profile of " + p.key,
      .caption =
          "Growth of the sum of squares where this parameter, told with the widest interval, is held and the "
          "others are fitted again. Dashed: 95 % if observables were independent; they are not, and the "
          "interval of the table is the wider one.",
      .x = {.label = p.key + " (" + p.unit + ")"},
      .y = {.label = "growth (1)"},
      .series = {
          {.label = "sum of squares",
           .style = Series::Style::line_and_points,
           .x = profile.value,
           .y = profile.growth},
          {.label = "3.84", .style = Series::Style::dashed, .x = {low, high}, .y = {threshold, threshold}}}};
}

/// Middle of a bin behind the loss of resistance [mm].
double middle_of(std::size_t bin) { return 0.5 * mm * (force_bins[bin].begin + force_bins[bin].end); }

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
  return {.id = "force",
          .title = "Force along the needle before the loss of resistance",
          .caption = "Means over 2 mm of the way, 1.5 mm in the last, by the distance to where resistance is "
                     "lost.",
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
  return {
      .id = "misfit",
      .title = "Misfit of every observable",
      .caption =
          "Simulated less recorded, in standard uncertainties; observables as the table below numbers them.",
      .x = {.label = "observable (1)", .minimum = 0.5, .maximum = end},
      .y = {.label = "misfit (1)"},
      .series = {std::move(allowed), std::move(before), std::move(after)}};
}

}  // namespace

std::vector<Table> calibration_tables(const CalibrationReport& report) {
  std::vector<Table> tables{parameter_table(report.result.fit), observable_table(report.result)};
  if (!report.result.held_out.empty()) { tables.push_back(held_out_table(report.result.held_out)); }
  if (!report.result.fit.told.empty()) { tables.push_back(correlation_table(report.result.fit)); }
  tables.push_back(recording_table(report));
  return tables;
}

std::vector<Figure> calibration_figures(const CalibrationReport& report) {
  std::vector<Figure> figures{misfit_figure(report.result.fit)};
  if (std::isfinite(report.result.fit.data.mean[index_of(Observable::force)])) {
    figures.push_back(force_figure(report.result.fit));
  }
  if (report.result.profile.value.size() > 1) { figures.push_back(profile_figure(report)); }
  return figures;
}

}  // namespace palpate
