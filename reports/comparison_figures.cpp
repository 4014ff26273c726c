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

/// Horizontal axis of a figure that compares a recorded and a simulated trace.
enum class Over { time, depth };

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

Figure empty_overlay(const Trace& trace, Over over) {
  const bool time = over == Over::time;
  return {.x = {.label = time ? "time (s)" : "tip depth (mm)"},
          .zones = time ? layers_over_time(trace) : layers_over_depth(trace),
          .marks = time ? events_over_time(trace) : events_over_depth(trace)};
}

/// Figure of one recording and the simulation; every series is labelled with its origin.
struct Overlay {
  const ComparisonReport& report;
  std::size_t index;
  Over over;
  Figure figure;

  Overlay(const ComparisonReport& of, std::size_t n, Over axis)
      : report(of), index(n), over(axis), figure(empty_overlay(of.simulation.trace, axis)) {}

  [[nodiscard]] const Recording& recording() const {
    return report.recordings[index].input.recording;
  }
  [[nodiscard]] double lag() const { return report.found.recordings[index].alignment.lag; }

  void add_recorded(const std::string& label, const std::vector<double>& values, double factor,
                    Series::Style style = Series::Style::line) {
    const bool time = over == Over::time;
    if (values.empty()) { return; }
    figure.series.push_back(
        {.label = label,
         .style = style,
         .x = time ? scaled(recording().time, 1.0, -lag()) : scaled(recording().depth, mm),
         .y = scaled(values, factor)});
  }
  void add_simulated(const std::string& label, const char* column, double factor,
                     Series::Style style = Series::Style::line) {
    const Trace& trace = report.simulation.trace;
    if (trace.find(column) == nullptr) { return; }
    figure.series.push_back(
        {.label = label,
         .style = style,
         .x = over == Over::time ? trace.time : values_of(trace, "tool.depth_m", mm),
         .y = values_of(trace, column, factor)});
  }
};

std::string clocks(const Comparison& one) {
  return " Clocks aligned " + one.alignment.how + "; recorded - simulated " +
         quantity(one.alignment.lag, "s") + ".";
}

Figure pressure_figure(const ComparisonReport& report, std::size_t n, Over over) {
  Overlay overlay(report, n, over);
  const double factor = 1.0 / pascals_per_mmhg;
  overlay.add_recorded("recorded", overlay.recording().pressure, factor);
  overlay.add_simulated("simulated", "syringe.pressure_pa", factor);
  Figure figure = std::move(overlay.figure);
  figure.id = over == Over::time ? "pressure-over-time" : "pressure-over-depth";
  figure.title = over == Over::time ? "Saline pressure over time" : "Saline pressure over depth";
  figure.y.label = "pressure (mmHg)";
  figure.caption = "As sampled; the tints are the layers that the simulated tip is in.";
  if (over == Over::time) { figure.caption += clocks(report.found.recordings[n]); }
  figure.caption += honesty(overlay.recording());
  return figure;
}

/// Force along the needle, and force on the plunger (pressure times area).
Figure force_figure(const ComparisonReport& report, std::size_t n, Over over) {
  Overlay overlay(report, n, over);
  const Recording& recording = overlay.recording();
  const auto add_plunger = [&] {
    overlay.add_recorded("on the plunger, recorded", recording.pressure, recording.plunger_area,
                         Series::Style::dashed);
  };
  overlay.add_recorded("along the needle, recorded", recording.force, 1.0);
  if (recording.force.empty()) {
    add_plunger();
  }  // recorded series first, so that it keeps its colour
  overlay.add_simulated("along the needle, simulated", "tool.force_n", 1.0);
  if (!recording.force.empty()) { add_plunger(); }
  overlay.add_simulated("on the plunger, simulated", "syringe.thumb_n", 1.0, Series::Style::dashed);
  Figure figure = std::move(overlay.figure);
  figure.id = over == Over::time ? "force-over-time" : "force-over-depth";
  figure.title = over == Over::time ? "Reaction force over time" : "Reaction force over depth";
  figure.y.label = "force (N)";
  figure.caption = "Resisting the needle, and the thumb: recorded pressure times a plunger of " +
                   quantity(1e6 * recording.plunger_area, "mm²") + ".";
  if (recording.force.empty()) { figure.caption += " Force along the needle was not recorded."; }
  figure.caption += honesty(recording);
  return figure;
}

Figure residual_figure(const ComparisonReport& report, std::size_t n) {
  const Comparison& one = report.found.recordings[n];
  const FieldUnit unit = unit_of_report(report);
  Figure figure = empty_overlay(report.simulation.trace, Over::time);
  figure.id = "residual";
  figure.title = "Residual";
  figure.caption =
      "Simulated less recorded, both filtered, where both are; a gap of the recording stays one." +
      honesty(report.recordings[n].input.recording);
  figure.y.label = label_of("simulated - recorded", unit.name);
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
  Figure corridor = empty_overlay(report.simulation.trace, Over::time);
  corridor.id = "corridor-" + std::to_string(index);
  corridor.title = "Corridor of " + (group.group.empty() ? "the subjects" : group.group);
  corridor.caption = corridor_words(group) + "; all filtered, on the simulation's clock." +
                     honesty_of_group(group);
  corridor.y.label = label_of(what, unit.name);
  const Series simulated{.label = "simulated",
                         .x = times_of(group.simulated),
                         .y = scaled(group.simulated.value, unit.factor)};
  corridor.series = {corridor_band(*group.corridor, mean.value, unit.factor),
                     {.label = "mean of the subjects",
                      .style = Series::Style::dashed,
                      .x = times_of(mean),
                      .y = scaled(mean.value, unit.factor)},
                     simulated};
  Figure residual = empty_overlay(report.simulation.trace, Over::time);
  residual.id = "corridor-residual-" + std::to_string(index);
  residual.title = "Residual against the mean";
  residual.caption = "Simulated less the mean of the subjects, within the same corridor." +
                     honesty_of_group(group);
  residual.y.label = label_of("simulated - mean", unit.name);
  const std::vector<double> zero(mean.size(), 0.0);
  residual.series = {
      corridor_band(*group.corridor, zero, unit.factor),
      {.label = "residual", .x = simulated.x, .y = difference(group.simulated, mean, unit.factor)}};
  return {corridor, residual};
}

}  // namespace palpate
