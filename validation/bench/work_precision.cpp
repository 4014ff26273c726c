// SPDX-License-Identifier: MIT

#include "validation/bench/work_precision.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>

#include "model/stepping/simulation.hpp"
#include "validation/bench/timing.hpp"
#include "validation/roll_out.hpp"
#include "validation/signal.hpp"
#include "validation/text.hpp"

namespace palpate::bench {

namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

/// In the plane of logarithms.
struct Place {
  double cost = 0.0;
  double error = 0.0;
};

/// Returns the points of each method by increasing cost.
std::vector<std::vector<Place>> ladders_of(std::span<const Point> points) {
  std::map<std::string, std::vector<Place>> by_method;
  for (const Point& each : points) {
    by_method[each.method].push_back(
        {std::log10(static_cast<double>(each.evaluations)), std::log10(each.errors.tool)});
  }
  std::vector<std::vector<Place>> ladders;
  for (auto& [method, ladder] : by_method) {
    std::ranges::sort(ladder, {}, &Place::cost);
    ladders.push_back(std::move(ladder));
  }
  return ladders;
}

double between(double at, double from, double to, double value_from, double value_to) {
  return value_from + (value_to - value_from) * (at - from) / (to - from);
}

double cost_on(const std::vector<Place>& ladder, double error) {
  if (ladder.front().error <= error) { return ladder.front().cost; }
  for (std::size_t n = 1; n < ladder.size(); ++n) {
    const Place& a = ladder[n - 1];
    const Place& b = ladder[n];
    if (b.error <= error) { return between(error, a.error, b.error, a.cost, b.cost); }
  }
  return nothing;
}

double error_on(const std::vector<Place>& ladder, double cost) {
  if (cost < ladder.front().cost) { return nothing; }
  for (std::size_t n = 1; n < ladder.size(); ++n) {
    const Place& a = ladder[n - 1];
    const Place& b = ladder[n];
    if (b.cost >= cost) { return between(cost, a.cost, b.cost, a.error, b.error); }
  }
  return ladder.back().error;
}

/// Returns the minimum over the methods, ignoring those without a value.
template <class Value> double least(std::span<const Point> points, double at, Value&& value) {
  double best = nothing;
  for (const std::vector<Place>& ladder : ladders_of(points)) {
    best = std::fmin(best, value(ladder, std::log10(at)));
  }
  return best;
}

}  // namespace

double cost_at(std::span<const Point> points, double error) {
  return std::pow(10.0, least(points, error, cost_on));
}

double digits_at(std::span<const Point> points, double cost) {
  return -least(points, cost, error_on);
}

namespace {

Eigen::VectorXd vector_of(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), std::ssize(values));
}

double root_mean_square(const Eigen::MatrixXd& values) {
  return std::sqrt(values.squaredNorm() / static_cast<double>(values.size()));
}

/// Returns the length of the error vector at each counted tick.
Eigen::VectorXd lengths(const Eigen::MatrixXd& error, const std::vector<bool>& left_out) {
  Eigen::VectorXd length = error.colwise().norm().transpose();
  for (std::size_t n = 0; n < left_out.size(); ++n) {
    if (left_out[n]) { length(static_cast<Eigen::Index>(n)) = 0.0; }
  }
  return length;
}

/// Returns the change of the signal from start to end.
Eigen::VectorXd final_of(const Eigen::MatrixXd& signal) {
  return signal.rightCols(1) - signal.leftCols(1);
}

/// Returns the final error of the component with the largest change, relative to that change.
double error_at_end(const Eigen::MatrixXd& signal, const Eigen::MatrixXd& truth) {
  Eigen::Index component = 0;
  const double size = final_of(truth).cwiseAbs().maxCoeff(&component);
  return std::abs(final_of(signal)(component) - final_of(truth)(component)) / size;
}

/// A scene that the model takes in one way.
struct Candidate {
  Point point{};
  Scene scene{};
};

std::string substeps_text(int substeps) {
  return std::to_string(substeps) + (substeps == 1 ? " substep" : " substeps");
}

/// Computes the errors; false if the candidate failed or its error exceeds the peak.
bool judge_once(const CaseContext& context, const Study& study, Candidate& candidate,
                double& seconds) {
  const Trace run = run_here(context, candidate.scene);
  seconds = run.seconds;
  candidate.point.evaluations = run.evaluations;
  candidate.point.errors = errors_of(run, study.truth);
  return !run.diverged && candidate.point.errors.tool < 1.0;
}

Candidate candidate_of(const Study& study, const Reduction& reduction, Point::Kind kind) {
  Candidate candidate{.point = {.kind = kind, .far_field = reduction.near_radius > 0.0},
                      .scene = study.scene};
  candidate.scene.simulation.near_radius = reduction.near_radius;
  if (candidate.point.far_field) { candidate.scene.simulation.far_modes = reduction.far_modes; }
  return candidate;
}

std::string method_of(const std::string& scheme, const Candidate& candidate) {
  return scheme + (candidate.point.kind == Point::Kind::in_float ? ", float" : "") +
         (candidate.point.far_field ? ", far field" : "");
}

void add_scheme(const CaseContext& context, const Study& study, const std::string& scheme,
                const Reduction& reduction, Precision precision, double patience,
                std::vector<Candidate>& candidates) {
  const bool single = precision == Precision::single_precision;
  double before = unbounded;
  double seconds = 0.0;
  for (int substeps = study.least_substeps;
       substeps <= study.most_substeps && 2.0 * seconds <= patience; substeps *= 2) {
    Candidate candidate =
        candidate_of(study, reduction, single ? Point::Kind::in_float : Point::Kind::in_double);
    candidate.point.method = method_of(scheme, candidate);
    candidate.point.setting = substeps_text(substeps);
    candidate.scene.simulation.integrator = scheme;
    candidate.scene.simulation.substeps = substeps;
    candidate.scene.simulation.precision = precision;
    if (!judge_once(context, study, candidate, seconds)) { continue; }
    const double error = candidate.point.errors.tool;
    candidates.push_back(candidate);
    // Below the floor, or where rounding or a jump keeps it, finer steps tell nothing.
    if (error < study.truth.floor || error > 0.9 * before) { break; }
    before = error;
  }
}

void add_automatic(const CaseContext& context, const Study& study, const Reduction& reduction,
                   std::vector<Candidate>& candidates) {
  Candidate candidate = candidate_of(study, reduction, Point::Kind::automatic);
  candidate.point.method = method_of("auto", candidate);
  candidate.scene.simulation.integrator = "auto";
  candidate.scene.simulation.substeps.reset();
  const StepPlan plan = Simulation(candidate.scene).plan();
  candidate.point.setting =
      std::string(plan.integrator->name) + ", " + substeps_text(plan.substeps);
  double seconds = 0.0;
  if (judge_once(context, study, candidate, seconds)) { candidates.push_back(candidate); }
}

/// The ticks alone, all candidates in turn; what comes before them is timed too.
void time_candidates(std::vector<Candidate>& candidates, int rounds) {
  std::vector<std::unique_ptr<Simulation>> simulations(candidates.size());
  std::vector<Contender> contenders;
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    std::unique_ptr<Simulation>& simulation = simulations[c];
    contenders.push_back({.name = candidates[c].point.method,
                          .repeat =
                              [&simulation](long) {
                                for (long n = simulation->tick_count(); n > 0; --n) {
                                  (void)simulation->tick();
                                }
                              },
                          .begin =
                              [&simulation, &candidate = candidates[c]] {
                                const double begin = seconds_on(Clock::processor);
                                simulation = std::make_unique<Simulation>(candidate.scene);
                                const double took = seconds_on(Clock::processor) - begin;
                                candidate.point.loading = std::fmin(candidate.point.loading, took);
                              },
                          .end = [&simulation] { simulation.reset(); }});
  }
  const std::vector<Timed> timed = time_interleaved(contenders, {.rounds = rounds, .batch = 0.0});
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    candidates[c].point.seconds = timed[c].least;
    candidates[c].point.median = timed[c].median;
  }
}

void add_solver(const Study& study, const std::string& name, double patience,
                std::vector<Point>& points) {
  double spent = 0.0;
  for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
    Point point{
        .method = name, .setting = formatted("%.0e", tolerance), .kind = Point::Kind::elsewhere};
    std::vector<double> seconds;
    for (int n = 0; n < 3 && spent < patience; ++n) {
      const Trace run = study.there(name, tolerance);
      if (run.diverged) { break; }
      seconds.push_back(run.seconds);
      spent += run.seconds;
      point.evaluations = run.evaluations;
      point.errors = errors_of(run, study.truth);
    }
    if (seconds.empty() || point.errors.tool >= 1.0) { continue; }
    point.seconds = std::ranges::min(seconds);
    point.median = comparison::quantile(seconds, 0.5);
    points.push_back(point);
  }
}

/// Returns true if both or none of the points use the reduced-order model.
bool same_field(const Point& a, const Point& b) {
  const auto field = [](const Point& p) {
    return p.kind == Point::Kind::automatic ? Point::Kind::in_double : p.kind;
  };
  return field(a) == field(b) && a.far_field == b.far_field;
}

}  // namespace

Eigen::MatrixXd Signal::of(const Trace& run) const {
  if (count > 0) { return run.position.middleRows(first, count); }
  return vector_of(run.values("tool.force_n")).transpose();
}

Trace run_here(const CaseContext& context, const Scene& scene) {
  Trace run = roll_out(context, scene, {.position = true, .energy = true});
  // An implicit scheme evaluates once an iteration at least.
  run.evaluations = run.steps * find_integrator(run.method)->evaluations;
  return run;
}

Errors errors_of(const Trace& run, const Truth& truth) {
  constexpr Errors useless{unbounded, unbounded, unbounded, unbounded, unbounded, unbounded};
  const bool complete = !run.diverged && run.position.rows() == truth.run.position.rows() &&
                        run.position.cols() == truth.run.position.cols();
  if (!complete) { return useless; }
  const Eigen::MatrixXd signal = truth.signal.of(run);
  if (!signal.allFinite() || !run.position.allFinite()) { return useless; }
  const Eigen::MatrixXd true_signal = truth.signal.of(truth.run);
  const Eigen::VectorXd tool = lengths(signal - true_signal, truth.left_out);
  const Eigen::MatrixXd everywhere = run.position - truth.run.position;
  const Eigen::VectorXd energy =
      vector_of(run.values("energy_j")) - vector_of(truth.run.values("energy_j"));
  return {.tool = tool.maxCoeff() / truth.peak,
          .tool_mean = root_mean_square(tool) / truth.peak,
          .tool_at_end = error_at_end(signal, true_signal),
          .trajectory = everywhere.cwiseAbs().maxCoeff() / truth.travel,
          .trajectory_mean = root_mean_square(everywhere) / truth.travel,
          .energy = energy.cwiseAbs().maxCoeff() / truth.energy};
}

Truth truth_of(Trace first, const Trace& second, const Signal& signal, std::vector<bool> left_out) {
  Truth truth{.run = std::move(first), .signal = signal, .left_out = std::move(left_out)};
  const Eigen::MatrixXd tool = signal.of(truth.run);
  const Eigen::MatrixXd& position = truth.run.position;
  const Eigen::VectorXd energy = vector_of(truth.run.values("energy_j"));
  truth.peak = (tool.colwise() - tool.col(0)).colwise().norm().maxCoeff();
  truth.travel = (position.colwise() - position.col(0)).cwiseAbs().maxCoeff();
  truth.energy = (energy.array() - energy(0)).abs().maxCoeff();
  truth.floor = errors_of(second, truth).tool;
  return truth;
}

std::vector<Point> measure_points(const CaseContext& context, const Study& study, double patience,
                                  int rounds) {
  std::vector<Candidate> candidates;
  const auto add_schemes = [&](const std::vector<std::string>& schemes,
                               const Reduction& reduction) {
    for (const std::string& scheme : schemes) {
      for (const Precision precision : {Precision::double_precision, Precision::single_precision}) {
        const bool single = precision == Precision::single_precision;
        if (single && (!study.in_float || find_integrator(scheme)->implicit)) { continue; }
        add_scheme(context, study, scheme, reduction, precision, patience, candidates);
      }
    }
  };
  add_schemes(study.schemes, {});
  if (study.reduction.near_radius > 0.0) {
    add_schemes(study.schemes_of_reduction, study.reduction);
    add_automatic(context, study, study.reduction, candidates);
  }
  add_automatic(context, study, {}, candidates);
  time_candidates(candidates, rounds);
  std::vector<Point> points;
  for (const Candidate& candidate : candidates) { points.push_back(candidate.point); }
  for (const std::string& name : study.solvers) { add_solver(study, name, 3.0 * patience, points); }
  std::ranges::stable_partition(points,
                                [](const Point& p) { return p.kind != Point::Kind::automatic; });
  return points;
}

const Point* cheapest(const std::vector<Point>& points, double error, bool here) {
  const Point* best = nullptr;
  for (const Point& point : points) {
    if (point.here() != here || !(point.errors.tool <= error)) { continue; }
    if (best == nullptr || point.seconds < best->seconds) { best = &point; }
  }
  return best;
}

bool on_frontier(const std::vector<Point>& points, const Point& point) {
  return std::ranges::none_of(points, [&](const Point& other) {
    return &other != &point && same_field(other, point) && other.seconds < point.seconds &&
           other.errors.tool < point.errors.tool;
  });
}

double automatic_over_best(const std::vector<Point>& points) {
  Largest worst(-unbounded);
  for (const Point& automatic : points) {
    if (automatic.kind != Point::Kind::automatic) { continue; }
    worst.add(0.0);
    for (const Point& p : points) {
      if (p.kind != Point::Kind::in_double || !same_field(p, automatic)) { continue; }
      if (p.errors.tool <= automatic.errors.tool) { worst.add(automatic.seconds / p.median); }
    }
  }
  return worst.value() >= 0.0 ? worst.value() : nothing;
}

double largest_error_of_automatic(const std::vector<Point>& points) {
  Largest largest(-unbounded);
  for (const Point& p : points) {
    if (p.kind == Point::Kind::automatic) { largest.add(p.errors.tool); }
  }
  return largest.value() >= 0.0 ? largest.value() : nothing;
}

double noise_of(const std::vector<Point>& points) {
  std::vector<double> apart;
  for (const Point& p : points) {
    if (p.here()) { apart.push_back(p.median / p.seconds); }
  }
  const auto tenth = apart.begin() + static_cast<std::ptrdiff_t>(9 * apart.size() / 10);
  std::ranges::nth_element(apart, tenth);
  return std::max(1.1, *tenth);
}

namespace {

/// Describes the reduced-order model, which the name of a method does not.
std::string words_on_far_field(const Study& study) {
  if (!(study.reduction.near_radius > 0.0)) { return ""; }
  return formatted(
      " With a far field, what lies further than %g mm from what is pushed is linear about rest, "
      "in %d modes.",
      1e3 * study.reduction.near_radius, study.reduction.far_modes);
}

Table points_table(const std::vector<Point>& points, const Study& study) {
  Table table{.id = "points",
              .title = "Every setting",
              .caption =
                  "Errors at ticks, over the largest displacement, change of energy, or signal of "
                  "the tool (here: " +
                  study.tool +
                  "). Run times, without loading, are the least and the median of rounds; on the "
                  "frontier is what no other setting of its kind and precision beats in both." +
                  words_on_far_field(study),
              .columns = {"method", "setting", "time (s)", "median (s)", "loading (s)",
                          "evaluations", "tool (1)", "tool, mean (1)", "trajectory (1)",
                          "trajectory, mean (1)", "energy (1)", "frontier"},
              .timing = true};
  for (const Point& p : points) {
    const Cell loading = p.here() ? Cell(p.loading) : Cell("-");
    table.rows.push_back({p.method, p.setting, p.seconds, p.median, loading,
                          static_cast<double>(p.evaluations), p.errors.tool, p.errors.tool_mean,
                          p.errors.trajectory, p.errors.trajectory_mean, p.errors.energy,
                          std::string(on_frontier(points, p) ? "yes" : "")});
  }
  return table;
}

Table cheapest_table(const std::vector<Point>& points, const Study& study) {
  Table table{.id = "cheapest",
              .title = "The cheapest way to an error",
              .caption = "Of what is at most that far off at the tool (" + study.tool +
                         "); integrator = \"auto\" chooses " + points.back().setting + "." +
                         words_on_far_field(study),
              .columns = {"error (1)", "here", "time (s)", "elsewhere", "time (s)", "ratio (1)"},
              .timing = true};
  for (const double error : {1e-2, 1e-3, 1e-4}) {
    const Point* here = cheapest(points, error, true);
    const Point* there = cheapest(points, error, false);
    std::vector<Cell> row{error};
    for (const Point* point : {here, there}) {
      row.emplace_back(point == nullptr ? "none" : point->method + ", " + point->setting);
      row.push_back(point == nullptr ? Cell("-") : Cell(point->seconds));
    }
    const bool both = here != nullptr && there != nullptr;
    row.push_back(both ? Cell(there->seconds / here->seconds) : Cell("-"));
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
         "error of all nodes, mean (1)", [](const Point& p) { return p.errors.trajectory_mean; },
         false, true},
    View{"trajectory-time", "Largest error of any node against run time",
         "largest error of any node (1)", [](const Point& p) { return p.errors.trajectory; }, false,
         true},
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
          "Lower and further left is better. Lines: schemes of the model, from few substeps to "
          "many; points: other libraries, from loose tolerances to tight ones.",
      .x = {.label = view.evaluations ? "evaluations of the force (1)" : "run time (s)",
            .logarithmic = true},
      .y = {.label = view.error_label, .logarithmic = true},
      .timing = !view.evaluations};
  double least = unbounded;
  double most = 0.0;
  for (const Point& point : points) {
    const bool shown =
        single ? point.kind == Point::Kind::in_float : point.kind != Point::Kind::in_float;
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
