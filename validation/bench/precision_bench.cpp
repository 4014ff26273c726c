// SPDX-License-Identifier: MIT
/// Error against run time: every scheme with every number of substeps beside the solvers of other libraries, on
/// the same motion, with the same forces.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "model/dynamics/network_builder.hpp"
#include "model/stepping/integrator.hpp"
#include "model/stepping/list_network.hpp"
#include "reference/solvers.hpp"
#include "validation/bench/bench_cases.hpp"

namespace palpate::bench {

namespace {

/// A network whose forces come from the model's list kernel, so that other libraries do not pay for a plain
/// right-hand side.
class QuickProblem final : public Problem {
 public:
  explicit QuickProblem(const NetworkProblem& plain)
      : plain_(plain), system_(plain, {}, 1.0, true), q_(plain.dof()), v_(plain.dof()), f_(plain.dof()) {}
  [[nodiscard]] Eigen::Index dof() const override { return plain_.dof(); }
  [[nodiscard]] const Eigen::VectorXd& mass() const override { return plain_.mass(); }
  [[nodiscard]] Eigen::VectorXd initial_position() const override { return plain_.initial_position(); }
  [[nodiscard]] Eigen::VectorXd initial_velocity() const override { return plain_.initial_velocity(); }
  void force(double t, double gate, const Eigen::Ref<const Eigen::VectorXd>& q,
             const Eigen::Ref<const Eigen::VectorXd>& v, Eigen::Ref<Eigen::VectorXd> f) const override {
    q_ = q;
    v_ = v;
    system_.force(t, gate, q_, v_, f_);
    f = f_;
  }
  void jacobian(const Eigen::Ref<const Eigen::VectorXd>& q, const Eigen::Ref<const Eigen::VectorXd>& v,
                Eigen::SparseMatrix<double>& stiffness, Eigen::SparseMatrix<double>& damping) const override {
    plain_.jacobian(q, v, stiffness, damping);
  }
  [[nodiscard]] std::vector<double> breaks() const override { return plain_.breaks(); }
  [[nodiscard]] double shortest_feature() const override { return plain_.shortest_feature(); }
  [[nodiscard]] double energy(const Eigen::Ref<const Eigen::VectorXd>& q,
                              const Eigen::Ref<const Eigen::VectorXd>& v) const override {
    return plain_.energy(q, v);
  }

 private:
  const NetworkProblem& plain_;
  mutable ListNetwork<double> system_;
  mutable Eigen::VectorXd q_, v_, f_;
};

/// One way of computing the motion.
struct Point {
  std::string method{};
  std::string setting{};   ///< "4 substeps", "1e-06"
  bool ours = true;
  double seconds = 0.0;    ///< for the whole motion
  long evaluations = 0;
  double tip = 0.0;        ///< largest error of the loaded node over its largest displacement
  double mean = 0.0;       ///< root mean square over time of the same
  double everywhere = 0.0; ///< largest error of any node, over the same
};

struct Study {
  Scene scene{};
  int node = 0;
  std::vector<std::string> schemes{};
  std::vector<std::string> solvers{};
  int most_substeps = 64;
};

/// The motion itself, and how far two families of solvers are apart.
struct Truth {
  Eigen::MatrixXd position{};
  Eigen::Index coordinate = 0;
  double peak = 0.0;
  double floor = 0.0;
};

std::vector<double> instants(const Scene& scene) {
  std::vector<double> times;
  const long count = std::lround(scene.simulation.duration / scene.simulation.step);
  for (long n = 0; n <= count; ++n) { times.push_back(static_cast<double>(n) * scene.simulation.step); }
  return times;
}

void measure_errors(const Truth& truth, const Eigen::MatrixXd& position, Point& point) {
  if (position.cols() != truth.position.cols() || !position.allFinite()) {
    point.tip = point.mean = point.everywhere = unbounded;
    return;
  }
  const Eigen::MatrixXd error = position - truth.position;
  const auto tip = error.middleRows(truth.coordinate, 3).colwise().norm();
  point.tip = tip.maxCoeff() / truth.peak;
  point.mean = std::sqrt(tip.squaredNorm() / static_cast<double>(tip.size())) / truth.peak;
  point.everywhere = error.cwiseAbs().maxCoeff() / truth.peak;
}

Truth truth_of(const Study& study, const NetworkProblem& problem) {
  const QuickProblem quick(problem);
  const std::vector<double> times = instants(study.scene);
  const reference::Tolerance tight{.relative = 1e-11, .position_scale = 1e-3, .velocity_scale = 1e-2};
  const auto first = reference::solver_named("arkode-fehlberg-7-8").solve(quick, times, tight);
  const auto second = reference::solver_named("cvode-adams").solve(quick, times, tight);
  Truth truth{.position = first.position, .coordinate = problem.coordinate(study.node)};
  const auto tip = truth.position.middleRows(truth.coordinate, 3);
  truth.peak = (tip.colwise() - tip.col(0)).colwise().norm().maxCoeff();
  Point apart;
  measure_errors(truth, second.position, apart);
  truth.floor = apart.tip;
  return truth;
}

constexpr int repeats = 3;

std::optional<Point> play(const CaseContext& context, const Study& study, const Truth& truth,
                          const std::string& scheme, int substeps, Precision precision) {
  Scene scene = study.scene;
  scene.simulation.integrator = scheme;
  scene.simulation.substeps = substeps;
  scene.simulation.precision = precision;
  const bool single = precision == Precision::single_precision;
  Point point{.method = scheme + (single ? ", float" : ""),
              .setting = std::to_string(substeps) + (substeps == 1 ? " substep" : " substeps"),
              .seconds = unbounded};
  for (int n = 0; n < repeats; ++n) {
    const Motion motion = simulate(context, scene);
    if (motion.diverged) { return {}; }
    point.seconds = std::min(point.seconds, motion.seconds);
    point.evaluations = motion.steps * find_integrator(scheme)->evaluations;
    measure_errors(truth, motion.position, point);
  }
  return point;
}

std::vector<Point> play_ours(const CaseContext& context, const Study& study, const Truth& truth) {
  std::vector<Point> points;
  for (const std::string& scheme : study.schemes) {
    const bool implicit = find_integrator(scheme)->implicit;
    for (const Precision precision : {Precision::double_precision, Precision::single_precision}) {
      if (implicit && precision == Precision::single_precision) { continue; }
      for (int substeps = 1; substeps <= study.most_substeps; substeps *= 2) {
        const auto point = play(context, study, truth, scheme, substeps, precision);
        if (point && point->tip < 1.0) { points.push_back(*point); }
      }
    }
  }
  return points;
}

std::vector<Point> play_others(const Study& study, const NetworkProblem& problem, const Truth& truth) {
  std::vector<Point> points;
  const QuickProblem quick(problem);
  for (const std::string& name : study.solvers) {
    for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
      const reference::Tolerance wanted{.relative = tolerance,
                                        .position_scale = truth.peak,
                                        .velocity_scale = truth.peak / study.scene.simulation.duration};
      std::array<char, 16> text{};
      std::snprintf(text.data(), text.size(), "%.0e", tolerance);
      Point point{.method = name, .setting = text.data(), .ours = false, .seconds = unbounded};
      for (int n = 0; n < repeats; ++n) {
        const auto solution = reference::solver_named(name).solve(quick, instants(study.scene), wanted);
        point.seconds = std::min(point.seconds, solution.seconds);
        point.evaluations = solution.evaluations;
        measure_errors(truth, solution.position, point);
      }
      if (point.tip < 1.0) { points.push_back(point); }
    }
  }
  return points;
}

/// The quickest whose error at the tip is no larger; nullptr if none.
const Point* cheapest(const std::vector<Point>& points, double error, bool ours) {
  const Point* best = nullptr;
  for (const Point& point : points) {
    if (point.ours != ours || !(point.tip <= error)) { continue; }
    if (best == nullptr || point.seconds < best->seconds) { best = &point; }
  }
  return best;
}

Table points_table(const std::vector<Point>& points) {
  Table table{.id = "points",
              .title = "Every setting",
              .caption = "Errors over the largest displacement of the loaded node; run times are the least of "
                         "three.",
              .columns = {"method", "setting", "time (s)", "evaluations", "tip (1)", "tip, mean (1)",
                          "any node (1)"},
              .timing = true};
  for (const Point& p : points) {
    table.rows.push_back({p.method, p.setting, p.seconds, static_cast<double>(p.evaluations), p.tip, p.mean,
                          p.everywhere});
  }
  return table;
}

Figure points_figure(const std::vector<Point>& points, const Truth& truth) {
  Figure figure{.id = "work-precision",
                .title = "Error against run time",
                .caption = "Lower and further left is better; dashed: how far two families of references are "
                           "apart.",
                .x = {.label = "run time (s)", .logarithmic = true},
                .y = {.label = "error at the loaded node (1)", .logarithmic = true},
                .timing = true};
  double quickest = unbounded;
  double slowest = 0.0;
  for (const Point& point : points) {
    if (figure.series.empty() || figure.series.back().label != point.method) {
      figure.series.push_back({.label = point.method, .style = point.ours ? Series::Style::line_and_points
                                                                           : Series::Style::points});
    }
    figure.series.back().x.push_back(point.seconds);
    figure.series.back().y.push_back(point.tip);
    quickest = std::min(quickest, point.seconds);
    slowest = std::max(slowest, point.seconds);
  }
  figure.series.push_back({.label = "floor of the reference",
                           .style = Series::Style::dashed,
                           .x = {quickest, slowest},
                           .y = {truth.floor, truth.floor}});
  return figure;
}

Table cheapest_table(const std::vector<Point>& points) {
  Table table{.id = "cheapest",
              .title = "The cheapest way to an error",
              .caption = "Of what is at most that far off at the loaded node.",
              .columns = {"error (1)", "here", "time (s)", "elsewhere", "time (s)", "ratio (1)"},
              .timing = true};
  for (const double error : {1e-2, 1e-3, 1e-4}) {
    const Point* here = cheapest(points, error, true);
    const Point* there = cheapest(points, error, false);
    if (here == nullptr || there == nullptr) { continue; }
    table.rows.push_back({error, here->method + ", " + here->setting, here->seconds,
                          there->method + ", " + there->setting, there->seconds,
                          there->seconds / here->seconds});
  }
  return table;
}

void judge(const CaseContext& context, const Study& study, Outcome& outcome, double times_cheaper) {
  const SpringNetwork network = build_network(study.scene);
  const NetworkProblem problem(network, resolve_loads(study.scene, network), study.scene.tissue.gravity);
  const Truth truth = truth_of(study, problem);
  std::vector<Point> points = play_ours(context, study, truth);
  std::ranges::move(play_others(study, problem, truth), std::back_inserter(points));
  const Point* here = cheapest(points, 1e-3, true);
  const Point* there = cheapest(points, 1e-3, false);
  outcome.judge({.name = "floor_of_the_reference",
                 .value = truth.floor,
                 .upper = 1e-5,
                 .bound_from = "a tenth of the smallest error that is asked for"});
  outcome.judge({.name = "elsewhere_over_here_at_1e-3",
                 .value = here != nullptr && there != nullptr ? there->seconds / here->seconds : std::nan(""),
                 .lower = times_cheaper,
                 .bound_from = "asked of the project: so many times cheaper than the best of SUNDIALS, GSL and "
                               "odeint"});
  outcome.tables = {cheapest_table(points), points_table(points)};
  outcome.figures.push_back(points_figure(points, truth));
}

/// 1000 nodes, 26 neighbours, one pulled; not stiff, so solvers with matrices have no part in it.
void measure_cube(const CaseContext& context, Outcome& outcome) {
  Study study{.scene = s26_scene(10),
              .schemes = {"euler-cromer", "velocity-verlet", "leapfrog", "rk4", "implicit-midpoint"},
              .solvers = {"cvode-adams", "arkode-fehlberg-7-8", "gsl-rk8pd"},
              .most_substeps = context.quick ? 4 : 16};
  study.node = study.scene.loads.front().nodes.front();
  judge(context, study, outcome, 20.0);
}

}  // namespace

std::vector<Case> precision_cases() {
  return {{.name = "bench/precision/cube",
           .suite = "timing",
           .claim = "The pulled cube of 1000 nodes is computed to a thousandth of its peak at a small part of what "
                    "the best solver of another library takes for it.",
           .measure = measure_cube,
           .weight = 60.0}};
}

std::vector<Case> all_benches() {
  std::vector<Case> cases = kernel_cases();
  std::ranges::move(precision_cases(), std::back_inserter(cases));
  std::ranges::move(needle_cases(), std::back_inserter(cases));
  return cases;
}

}  // namespace palpate::bench
