// SPDX-License-Identifier: MIT
/// A scene computed by the model, and by solvers of other libraries.

#include "validation/bench/work_precision.hpp"

#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <map>
#include <memory>

#include "model/kernels/list_network.hpp"
#include "model/problem/problem.hpp"
#include "model/tissue/network_builder.hpp"
#include "reference/exact_problems.hpp"
#include "reference/insertion.hpp"
#include "reference/solvers.hpp"
#include "validation/bench/bench_cases.hpp"
#include "validation/claims/tool_fixture.hpp"
#include "validation/number_text.hpp"
#include "validation/signal.hpp"

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

const Point* cheapest(const std::vector<Point>& points, double error, Among among) {
  const auto belongs = [among](const Point& point) {
    if (among == Among::libraries) { return !point.here(); }
    const bool same_problem = point.kind != Point::Kind::in_float && !point.far_field;
    return point.here() && (among == Among::here || same_problem);
  };
  const Point* best = nullptr;
  for (const Point& point : points) {
    if (!belongs(point) || !(point.errors.tool <= error)) { continue; }
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
  Table table = make_table(
      "points", "Every setting",
      "Errors at ticks, over the largest displacement, change of energy, or signal of the tool "
      "(here: " +
          study.tool +
          "). Run times, without loading, are the least and the median of rounds; on the frontier "
          "is what no other setting of its kind and precision beats in both." +
          words_on_far_field(study),
      {"method", "setting", "time (s)", "median (s)", "loading (s)", "evaluations", "tool (1)",
       "tool, mean (1)", "trajectory (1)", "trajectory, mean (1)", "energy (1)", "frontier"});
  table.timing = true;
  for (const Point& p : points) {
    const Cell loading = p.here() ? Cell(p.loading) : Cell("-");
    table.rows.push_back({p.method, p.setting, p.seconds, p.median, loading, p.evaluations,
                          p.errors.tool, p.errors.tool_mean, p.errors.trajectory,
                          p.errors.trajectory_mean, p.errors.energy,
                          on_frontier(points, p) ? "yes" : ""});
  }
  return table;
}

Table cheapest_table(const std::vector<Point>& points, const Study& study) {
  Table table = make_table("cheapest", "The cheapest way to an error",
                           "Of what is at most that far off at the tool (" + study.tool +
                               "); integrator = \"auto\" chooses " + points.back().setting +
                               ". Libraries compute in double, with every node and the springs in "
                               "a list, and stop at every tick, as here. The ratio is theirs over "
                               "here in double with every node, without set-up." +
                               words_on_far_field(study),
                           {"error (1)", "here", "time (s)", "here, double, every node", "time (s)",
                            "library", "time (s)", "ratio (1)"});
  table.timing = true;
  for (const double error : {1e-2, 1e-3, 1e-4}) {
    const Point* here = cheapest(points, error, Among::here_as_libraries);
    const Point* there = cheapest(points, error, Among::libraries);
    std::vector<Cell> row{error};
    for (const Point* point : {cheapest(points, error, Among::here), here, there}) {
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
  Figure figure =
      plot(std::string(view.id) + (single ? "-float" : ""),
           std::string(view.title) + (single ? ", in float" : ""),
           "Lower and further left is better. Lines: schemes of the model, from few substeps to "
           "many; points: other libraries, from loose tolerances to tight ones.",
           {.label = view.evaluations ? "evaluations of the force (1)" : "run time (s)",
            .logarithmic = true},
           logarithmic(view.error_label));
  figure.timing = !view.evaluations;
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

namespace {

/// Network problem whose forces come from the list kernel of the model, for a fair run time.
class QuickProblem final : public reference::DerivedProblem {
 public:
  explicit QuickProblem(const NetworkProblem& plain)
      : DerivedProblem(plain),
        system_(plain, {}, 1.0, true),
        q_(plain.dof()),
        v_(plain.dof()),
        f_(plain.dof()) {}
  void force(double t, double gate, const Eigen::Ref<const Eigen::VectorXd>& q,
             const Eigen::Ref<const Eigen::VectorXd>& v,
             Eigen::Ref<Eigen::VectorXd> f) const override {
    q_ = q;
    v_ = v;
    system_.force(t, gate, q_, v_, f_);
    f = f_;
  }

 private:
  mutable ListNetwork<double> system_;
  mutable Eigen::VectorXd q_, v_, f_;
};

/// Instants of the ticks, the first 0 [s].
std::vector<double> instants_of(const Scene& scene) {
  const double step = scene.simulation.step;
  return tick_times(step, std::lround(scene.simulation.duration / step));
}

/// Solver of a scene without a tool. The time of a solution is the wall time of the integration, or
/// less if other processes used the processor. A solver that fails gives a diverged trace.
class PointSolver {
 public:
  explicit PointSolver(const Scene& scene)
      : plain_(make_problem(scene)), instants_(instants_of(scene)) {
    network_ = dynamic_cast<const NetworkProblem*>(plain_.get());
    if (network_ != nullptr) { quick_ = std::make_unique<QuickProblem>(*network_); }
  }

  /// Returns the position of a node, or of the mass of an oscillator.
  [[nodiscard]] Signal signal_of(int node) const {
    return network_ != nullptr ? Signal{network_->coordinate(node), 3} : Signal{0, 1};
  }

  [[nodiscard]] Trace solve(const std::string& solver,
                            const reference::Tolerance& tolerance) const {
    try {
      const Problem& problem = quick_ ? *quick_ : *plain_;
      const double begin = seconds_on(Clock::processor);
      Trace run = reference::solver_named(solver).solve(problem, instants_, tolerance);
      run.seconds = std::min(seconds_on(Clock::processor) - begin, run.seconds);
      Column energy{.name = "energy_j", .unit = "J"};
      for (Eigen::Index n = 0; n < run.position.cols(); ++n) {
        energy.values.push_back(plain_->energy(run.position.col(n), run.velocity.col(n)));
      }
      run.columns.push_back(std::move(energy));
      return run;
    } catch (const reference::SolverError&) { return {.diverged = true}; }
  }

 private:
  std::unique_ptr<Problem> plain_;
  const NetworkProblem* network_ = nullptr;  ///< nullptr for an oscillator
  std::unique_ptr<Problem> quick_{};         ///< networks only
  std::vector<double> instants_;
};

/// Solves a scene with a needle with CVODE and root finding for events. The events of the trace are
/// those at which the force jumps.
Trace solve_needle(const Scene& scene, double tolerance) {
  const SpringNetwork network = build_network(scene);
  const double begin = seconds_on(Clock::processor);
  Trace run =
      reference::solve_insertion(scene, network, instants_of(scene), {.relative = tolerance});
  run.seconds = std::min(seconds_on(Clock::processor) - begin, run.seconds);
  std::erase_if(run.events, [](const Event& event) { return event.kind == "knot-passed"; });
  return run;
}

/// Ticks within two of an event.
std::vector<bool> jumps_of(const Trace& run, double step) {
  std::vector<bool> jumps;
  for (const double time : run.time) {
    jumps.push_back(std::ranges::any_of(
        run.events, [&](const Event& event) { return std::abs(time - event.time) <= 2.0 * step; }));
  }
  return jumps;
}

/// Adds the truth and the solvers of a scene without a tool. The two references share no method.
void observe_point(Study& study, int node, const std::array<const char*, 2>& references) {
  const auto point = std::make_shared<PointSolver>(study.scene);
  const reference::Tolerance tight{
      .relative = 1e-9, .position_scale = 1e-3, .velocity_scale = 1e-2};
  study.truth = truth_of(point->solve(references[0], tight), point->solve(references[1], tight),
                         point->signal_of(node));
  study.there = [point, travel = study.truth.travel, duration = study.scene.simulation.duration](
                    const std::string& solver, double tolerance) {
    return point->solve(
        solver,
        {.relative = tolerance, .position_scale = travel, .velocity_scale = travel / duration});
  };
}

/// Adds the truth and the solver of a scene with a needle; ticks at jumps of the force are left
/// out.
void observe_needle(Study& study, double finest) {
  Trace truth = solve_needle(study.scene, finest);
  std::vector<bool> jumps = jumps_of(truth, study.scene.simulation.step);
  study.truth = truth_of(std::move(truth), solve_needle(study.scene, 1e-8), {}, std::move(jumps));
  study.there = [scene = study.scene](const std::string&, double tolerance) {
    return solve_needle(scene, tolerance);
  };
}

/// The paper's lightest damping (its Figs. 6-10): m = k = 1, c = 0.1, some four periods.
Study oscillator_study() {
  Study study;
  study.tool = "the mass";
  study.scene.simulation = {.duration = 25.0, .step = 0.25};
  study.scene.tissue.source = Source::oscillator;
  observe_point(study, 0, {"modal", "arkode-fehlberg-7-8"});
  return study;
}

/// A cube with 26 neighbours and one pulled node; not stiff, so solvers with matrices have no part
/// in it.
Study cube_study(int nodes_a_side) {
  Study study;
  study.scene = s26_scene(nodes_a_side);
  study.tool = "the pulled node";
  observe_point(study, study.scene.loads.front().nodes.front(),
                {"arkode-fehlberg-7-8", "cvode-adams"});
  return study;
}

/// Seven layers with moduli that explicit schemes can follow, at 20 mm/s.
Study needle_study(double duration, double finest) {
  Study study;
  study.scene = tools::seven_soft_layers();
  study.tool = "the force on the hand, but within two ticks of an event";
  study.scene.simulation = {.duration = duration, .step = 1e-3};
  observe_needle(study, finest);
  return study;
}

Quantity floor_of(const Study& study) {
  return {.name = "floor_of_the_reference",
          .value = study.truth.floor,
          .upper = 1e-5,
          .bound_from = "a tenth of the smallest error that is required"};
}

// Error against run time on four scenes: one spring, a soft cube, seven layers under a needle, a
// stiff ligament.

/// All schemes except the printed Feynman-Newton, which is an erratum.
const std::vector<std::string> all_schemes{"euler",          "euler-cromer",     "feynman-newton",
                                           "leapfrog",       "velocity-verlet",  "rk4",
                                           "implicit-euler", "implicit-midpoint"};
const std::vector<std::string> explicit_solvers{"cvode-adams", "arkode-dormand-prince-5-4",
                                                "gsl-rk8pd", "odeint-dormand-prince-5-4"};

/// Allowed error at the tool, relative to the peak (docs/scenes.md).
constexpr double automatic_promise = 0.02;

/// Requirements for one scene.
struct Demand {
  /// At the end of S26: what semi-implicit Euler of any engine has (5.7338e-4 m for 5.7313e-4 m),
  /// to two digits.
  double error_at_end = unbounded;
};

/// Errors of "auto", and of semi-implicit Euler with one step per tick, the setting of the kernel
/// timings.
void judge_end(const std::vector<Point>& points, double most, Outcome& outcome) {
  for (const Point& p : points) {
    const bool timed = p.method.starts_with("euler-cromer") && p.setting == "1 substep";
    if (p.far_field) { continue; }
    if (!timed && p.kind != Point::Kind::automatic) { continue; }
    outcome.judge_at_most(
        "error_at_end_" + std::string(p.kind == Point::Kind::automatic  ? "auto"
                                      : p.kind == Point::Kind::in_float ? "float"
                                                                        : "double"),
        p.errors.tool_at_end, most,
        "what semi-implicit Euler of other engines has after 0.1 s, 4.3e-4");
  }
}

void judge(const CaseContext& context, const Study& study, const Demand& demand, Outcome& outcome) {
  const std::vector<Point> points =
      measure_points(context, study, context.quick ? 0.1 : 0.6, context.quick ? 2 : 5);
  outcome.judge(floor_of(study));
  outcome.judge_at_most("auto_over_quickest_as_accurate", automatic_over_best(points),
                        noise_of(points),
                        "integrator = \"auto\" is on the frontier: the least of its run times over "
                        "the median of any setting in double that is as near, apart by no more "
                        "than least and median of one setting are in this table, or a tenth");
  outcome.judge_at_most("error_of_auto", largest_error_of_automatic(points), automatic_promise,
                        "what docs/scenes.md promises of integrator = \"auto\"");
  if (std::isfinite(demand.error_at_end)) { judge_end(points, demand.error_at_end, outcome); }
  add_tables(points, study, outcome);
  add_figures(points, study, outcome);
}

void measure_oscillator(const CaseContext& context, Outcome& outcome) {
  Study study = oscillator_study();
  study.schemes = all_schemes;
  study.solvers = explicit_solvers;
  study.most_substeps = 256;
  judge(context, study, {}, outcome);
}

void measure_cube(const CaseContext& context, Outcome& outcome) {
  Study study = cube_study(10);
  study.schemes = all_schemes;
  study.solvers = explicit_solvers;
  study.most_substeps = context.quick ? 4 : 64;
  study.scene.simulation.substeps.reset();
  // Two and a half spacings; what its shapes lack is then half of what RK4 is off with one substep.
  study.reduction = {.near_radius = 0.025, .far_modes = 24};
  study.schemes_of_reduction = {"euler-cromer", "velocity-verlet", "rk4"};
  judge(context, study, {.error_at_end = 4.35e-4}, outcome);
}

/// A block of ligament with its published modulus: explicit schemes take some ten microseconds a
/// step.
void measure_ligament(const CaseContext& context, Outcome& outcome) {
  Study study;
  study.tool = "the pushed node";
  study.schemes = all_schemes;
  study.solvers = explicit_solvers;
  study.solvers.emplace_back("cvode-bdf");
  if (!context.quick) { study.solvers.emplace_back("arkode-esdirk-5-4"); }
  study.most_substeps = context.quick ? 128 : 512;
  study.scene.simulation = {.duration = 0.02, .step = 1e-3};
  study.scene.tissue.lattice = {
      .nodes = {6, 6, 6}, .spacing = 0.002, .material = "interspinous-ligament"};
  study.scene.materials = {{.name = "interspinous-ligament",
                            .youngs_modulus = 10e6,
                            .density = 1130.0,
                            .damping_ratio = 0.5}};
  constexpr int node = 3 * 6 + 3;
  study.scene.loads = {
      {.nodes = {node}, .force = {0.0, 0.0, 0.5}, .end = 0.015, .profile = Profile::half_sine}};
  observe_point(study, node, {"arkode-fehlberg-7-8", "cvode-bdf"});
  judge(context, study, {}, outcome);
}

void measure_needle(const CaseContext& context, Outcome& outcome) {
  Study study = needle_study(context.quick ? 0.15 : 0.45, 1e-10);
  study.schemes = all_schemes;
  // They have velocities at half steps, which a tool cannot use.
  std::erase(study.schemes, "leapfrog");
  std::erase(study.schemes, "feynman-newton");
  study.solvers = {"cvode-adams with events as roots"};
  study.most_substeps = context.quick ? 64 : 256;
  judge(context, study, {}, outcome);
}

// Cost of accuracy in force evaluations, which are the same on every machine, so that a gate can
// compare them.

/// Points of four explicit schemes with 1, 2, 4 ... substeps, without run times.
std::vector<Point> count_points(const CaseContext& context, const Study& study) {
  std::vector<Point> points;
  for (const char* scheme : {"euler", "euler-cromer", "velocity-verlet", "rk4"}) {
    for (int substeps = study.least_substeps; substeps <= study.most_substeps; substeps *= 2) {
      Scene scene = study.scene;
      scene.simulation.integrator = scheme;
      scene.simulation.substeps = substeps;
      const Trace run = run_here(context, scene);
      const Errors errors = errors_of(run, study.truth);
      if (!(errors.tool < 1.0)) { continue; }
      points.push_back({.method = scheme, .evaluations = run.evaluations, .errors = errors});
      if (errors.tool < 10.0 * study.truth.floor) { break; }
    }
  }
  return points;
}

/// `costs` are the numbers of evaluations for which digits are reported.
void count(const CaseContext& context, const Study& study, const std::vector<double>& costs,
           Outcome& outcome) {
  const std::vector<Point> points = count_points(context, study);
  outcome.judge(floor_of(study));
  for (const double error : {1e-2, 1e-3, 1e-4}) {
    outcome.report("evaluations_at_" + plain_number(error) + "_of_the_peak", cost_at(points, error),
                   "evaluations");
  }
  for (const double cost : costs) {
    outcome.report("digits_after_" + plain_number(cost, 6) + "_evaluations",
                   digits_at(points, cost), "digits");
  }
  Table& table = outcome.tables.emplace_back(
      Table{.id = "efforts",
            .title = "Evaluations and errors",
            .caption = "The largest error at the tool over its peak.",
            .columns = {"scheme", "evaluations of the force", "error"}});
  for (const Point& each : points) {
    table.rows.push_back({each.method, each.evaluations, each.errors.tool});
  }
}

}  // namespace

std::vector<Case> precision_cases() {
  const auto named = [](const std::string& scene, const std::string& claim,
                        void (*measure)(const CaseContext&, Outcome&)) {
    return Case{"bench/precision/" + scene, "timing", claim, measure, 60.0};
  };
  return {
      named(
          "oscillator",
          "On one spring, nothing in double is both quicker and nearer than what \"auto\" chooses.",
          measure_oscillator),
      named("cube",
            "Of a pulled cube of 1000 nodes, nothing in double is both quicker and nearer than "
            "what \"auto\" chooses.",
            measure_cube),
      named("needle",
            "Of seven layers under a needle, nothing in double is both quicker and nearer than "
            "what \"auto\" chooses.",
            measure_needle),
      named("ligament",
            "Of a stiff ligament, nothing in double is both quicker and nearer than what \"auto\" "
            "chooses.",
            measure_ligament)};
}

std::vector<Case> frontier_cases() {
  const auto named = [](const std::string& scene, void (*measure)(const CaseContext&, Outcome&)) {
    return Case{"bench/frontier/" + scene, "timing",
                "What an error costs in evaluations of the force, and what they buy, is known to a "
                "tenth of the smallest error that is asked for.",
                measure, 10.0};
  };
  return {named("oscillator",
                [](const CaseContext& context, Outcome& outcome) {
                  count(context, oscillator_study(), {400.0, 1600.0}, outcome);
                }),
          named("cube",
                [](const CaseContext& context, Outcome& outcome) {
                  count(context, cube_study(6), {400.0, 1600.0}, outcome);
                }),
          named("needle", [](const CaseContext& context, Outcome& outcome) {
            Study study = needle_study(0.15, 1e-9);
            study.least_substeps = 8;
            count(context, study, {2400.0, 9600.0}, outcome);
          })};
}

}  // namespace palpate::bench
