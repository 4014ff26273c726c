// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cstdio>

#include "validation/bench/work_precision.hpp"

namespace palpate::bench {

namespace {

/// What a method's name leaves open.
std::string words_on_far_field(const Study& study) {
  if (!(study.reduction.near_radius > 0.0)) { return ""; }
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(),
                " With a far field, what lies further than %g mm from what is pushed is linear about rest, in %d modes.",
                1e3 * study.reduction.near_radius, study.reduction.far_modes);
  return text.data();
}

Table points_table(const std::vector<Point>& points, const Study& study) {
  Table table{
      .id = "points",
      .title = "Every setting",
      .caption =
          "Errors at ticks, over the largest displacement, change of energy, or signal of the tool "
          "(here: " +
          study.tool +
          "). Run times, without loading, are the least and the median of rounds; on the "
          "frontier is what no other setting of its kind and precision beats in both." +
          words_on_far_field(study),
      .columns = {"method", "setting", "time (s)", "median (s)", "loading (s)", "evaluations", "tool (1)", "tool, mean (1)",
                  "trajectory (1)", "trajectory, mean (1)", "energy (1)", "frontier"},
      .timing = true};
  for (const Point& p : points) {
    const Cell loading = p.here() ? Cell(p.loading) : Cell(std::string("-"));
    table.rows.push_back({p.method, p.setting, p.seconds, p.median, loading, static_cast<double>(p.evaluations),
                          p.errors.tool, p.errors.tool_mean, p.errors.trajectory, p.errors.trajectory_mean,
                          p.errors.energy, std::string(on_frontier(points, p) ? "yes" : "")});
  }
  return table;
}

void add_cells(const Point* point, std::vector<Cell>& row) {
  if (point == nullptr) {
    row.insert(row.end(), {std::string("none"), std::string("-")});
  } else {
    row.insert(row.end(), {point->method + ", " + point->setting, point->seconds});
  }
}

Table cheapest_table(const std::vector<Point>& points, const Study& study) {
  Table table{.id = "cheapest",
              .title = "The cheapest way to an error",
              .caption = "Of what is at most that far off at the tool (" + study.tool +
                         "); integrator = \"auto\" "
                         "chooses " +
                         points.back().setting + "." + words_on_far_field(study),
              .columns = {"error (1)", "here", "time (s)", "elsewhere", "time (s)", "ratio (1)"},
              .timing = true};
  for (const double error : {1e-2, 1e-3, 1e-4}) {
    const Point* here = cheapest(points, error, true);
    const Point* there = cheapest(points, error, false);
    std::vector<Cell> row{error};
    add_cells(here, row);
    add_cells(there, row);
    row.emplace_back(std::string("-"));
    if (here != nullptr && there != nullptr) { row.back() = there->seconds / here->seconds; }
    table.rows.push_back(std::move(row));
  }
  return table;
}

/// One error against one cost.
struct View {
  const char* id;
  const char* title;
  const char* error_label;
  double (*error)(const Point&);
  bool evaluations = false;  ///< else run time
  bool of_all = false;       ///< coordinates, of which an oscillator has one
};

constexpr std::array views{
    View{"tool-time", "Error at the tool against run time", "largest error at the tool (1)",
         [](const Point& p) { return p.errors.tool; }},
    View{"tool-evaluations", "Error at the tool against evaluations of the force",
         "largest error at the tool (1)", [](const Point& p) { return p.errors.tool; }, true},
    View{"trajectory-mean-time", "Error of all nodes, root mean square, against run time",
         "error of all nodes, mean (1)", [](const Point& p) { return p.errors.trajectory_mean; }, false,
         true},
    View{"trajectory-time", "Largest error of any node against run time", "largest error of any node (1)",
         [](const Point& p) { return p.errors.trajectory; }, false, true},
    View{"energy-time", "Error of the energy against run time", "largest error of the energy (1)",
         [](const Point& p) { return p.errors.energy; }}};

double cost(const View& view, const Point& point) {
  return view.evaluations ? static_cast<double>(point.evaluations) : point.seconds;
}

Figure figure_of(const std::vector<Point>& points, const View& view, double floor, bool single) {
  Figure figure{
      .id = std::string(view.id) + (single ? "-float" : ""),
      .title = std::string(view.title) + (single ? ", in float" : ""),
      .caption =
          "Lower and further left is better. Lines: schemes of the model, from few substeps to many; "
          "points: other libraries, from loose tolerances to tight ones.",
      .x = {.label = view.evaluations ? "evaluations of the force (1)" : "run time (s)", .logarithmic = true},
      .y = {.label = view.error_label, .logarithmic = true},
      .timing = !view.evaluations};
  double least = unbounded;
  double most = 0.0;
  for (const Point& point : points) {
    const bool shown = single ? point.kind == Point::Kind::in_float : point.kind != Point::Kind::in_float;
    if (!shown || !(view.error(point) > 0.0)) { continue; }
    if (figure.series.empty() || figure.series.back().label != point.method) {
      figure.series.push_back({.label = point.method,
                               .style = point.here() && point.kind != Point::Kind::automatic
                                            ? Series::Style::line_and_points
                                            : Series::Style::points});
    }
    figure.series.back().x.push_back(cost(view, point));
    figure.series.back().y.push_back(view.error(point));
    least = std::min(least, cost(view, point));
    most = std::max(most, cost(view, point));
  }
  if (floor > 0.0 && most > 0.0) {
    figure.caption += " Dashed: how far two references are apart.";
    figure.series.push_back({.label = "floor of the reference",
                             .style = Series::Style::dashed,
                             .x = {least, most},
                             .y = {floor, floor}});
  }
  return figure;
}

}  // namespace

void add_tables(const std::vector<Point>& points, const Study& study, Outcome& outcome) {
  outcome.tables.push_back(cheapest_table(points, study));
  outcome.tables.push_back(points_table(points, study));
}

void add_figures(const std::vector<Point>& points, const Study& study, Outcome& outcome) {
  for (const View& view : views) {
    if (view.of_all && study.truth.run.position.rows() == 1) { continue; }
    const bool of_tool = std::string_view(view.id).starts_with("tool");
    outcome.figures.push_back(figure_of(points, view, of_tool ? study.truth.floor : 0.0, false));
  }
  if (std::ranges::any_of(points, [](const Point& p) { return p.kind == Point::Kind::in_float; })) {
    outcome.figures.push_back(figure_of(points, views.front(), study.truth.floor, true));
  }
}

}  // namespace palpate::bench
