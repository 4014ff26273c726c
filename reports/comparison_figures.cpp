// SPDX-License-Identifier: MIT

#include <string>

#include "fixtures/io/recording_file.hpp"
#include "reports/comparison_report.hpp"
#include "reports/html/html_page.hpp"
#include "reports/plot/shown_units.hpp"
#include "reports/plot/trace_figures.hpp"
#include "validation/comparison/comparison.hpp"

namespace palpate {

using namespace comparison;

namespace {

std::string honesty(const Recording& recording) {
  if (recording.kind == Recording::Kind::measured) { return {}; }
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

/// Ends of an id and of a title.
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
      "Resisting the needle, and the thumb: recorded pressure times a plunger of " +
          quantity(1e6 * recording.plunger_area, "mm²") + "." +
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
  const std::size_t rebuilt = group.recordings - group.measured;
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

std::string corridor_words(const GroupSummary& group) {
  return "Mean ± " + short_number(group.corridor->factor, 3) + " SD of " +
         subjects_of(*group.corridor) +
         ", in which a recording of a further subject lies with 0.95 (more SD where fewer were "
         "measured)";
}

}  // namespace

Figure overlay_figure(const ComparisonReport& report, std::size_t recording) {
  return report.options.comparison.quantity == QuantityKind::pressure
             ? pressure_figure(report, recording, Over::time)
             : force_figure(report, recording, Over::time);
}

std::vector<Figure> recording_figures(const ComparisonReport& report, std::size_t recording) {
  std::vector<Figure> figures;
  const bool both_have_depth = !report.recordings[recording].input.recording.depth.empty() &&
                               report.simulation.trace.find("tool.depth_m") != nullptr;
  for (const Over over : {Over::time, Over::depth}) {
    if (over == Over::depth && !both_have_depth) { continue; }
    figures.push_back(pressure_figure(report, recording, over));
    figures.push_back(force_figure(report, recording, over));
  }
  figures.push_back(residual_figure(report, recording));
  return figures;
}

std::vector<Figure> group_figures(const ComparisonReport& report, std::size_t index) {
  const GroupSummary& group = report.found.groups[index];
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

}  // namespace palpate
