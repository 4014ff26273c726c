// SPDX-License-Identifier: MIT
/// Errata of the paper, each measured in the model and predicted from an independent linearisation
/// of the printed equations.

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <complex>

#include "model/problem/problem.hpp"
#include "model/tissue/network_builder.hpp"
#include "reference/modal.hpp"
#include "reference/solvers.hpp"
#include "reference/static_equilibrium.hpp"
#include "validation/claims/groups.hpp"
#include "validation/signal.hpp"

namespace palpate::errata {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double step = 1e-4;      ///< h [s], a tenth of the stable step
constexpr double duration = 0.05;  ///< duration of a run of a pressed lattice [s]
constexpr double press = 0.02;     ///< force on the middle of the top, inwards [N]
constexpr int pressed_node = 4;

/// Linearised motion u'' = -K u - C v for small displacements, divided by mass.
struct Linear {
  Eigen::MatrixXd stiffness{};  ///< M^-1 K [1/s^2]
  Eigen::MatrixXd damping{};    ///< M^-1 C [1/s]
};

/// Left eigenvector w of s(n+1) = S s(n), or of s' = S s. The product w^T s is multiplied by the
/// eigenvalue z, independent of the other modes in s.
struct Mode {
  Eigen::VectorXcd left{};  ///< w, scaled so that its largest position weight is real
  std::complex<double> value{};
};

/// Growth rate [1/s], measured in the model and predicted.
struct Rate {
  double measured = 0.0;
  double predicted = 0.0;  ///< for Euler-Cromer with this step on the linearised equations
  double motion = 0.0;     ///< for the exact linearised motion
  long steps = 0;          ///< number of steps of the measurement
};

constexpr long sample_count = 100;

/// Row of the summary.
struct Finding {
  std::string erratum{};
  std::string printed{};   ///< place in the paper
  std::string effect{};    ///< in words
  std::string quantity{};  ///< with unit
  double measured = 0.0;
  double predicted = 0.0;
};

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double faint = 1e-9;  ///< [m] displacement of a mode at the start; a spring is 5 mm
constexpr double small = 5e-7;  ///< [m] and at the end: a strain of 1e-4

/// Returns the eigenvalue of S^T that is largest by `larger`, with its vector.
template <class Larger> Mode dominant(const MatrixXd& transposed, Larger larger) {
  const reference::GeneralModes modes = reference::general_modes(transposed);
  Index best = 0;
  for (Index i = 1; i < transposed.rows(); ++i) {
    if (larger(modes.values(best), modes.values(i))) { best = i; }
  }
  Mode mode{modes.vectors.col(best), modes.values(best)};
  Index largest = 0;
  const Index dof = transposed.rows() / 2;
  mode.left.head(dof).cwiseAbs().maxCoeff(&largest);
  mode.left /= mode.left(largest) / std::abs(mode.left(largest));
  return mode;
}

/// 3 x 3 x 3 nodes of 1 g, 5 mm apart, 26 neighbours of 50 N/m and 0.02 N s/m, bottom fixed.
Scene lattice_scene(double h, double seconds, const std::string& integrator = "euler-cromer") {
  Scene scene = scene_of(integrator, h, seconds);
  scene.tissue.source = Source::lattice;
  scene.tissue.lattice = {.nodes = {3, 3, 3},
                          .spacing = 0.005,
                          .connectivity = 26,
                          .weights = LatticeWeights::uniform,
                          .stiffness = 50.0,
                          .viscosity = 0.02,
                          .node_mass = 1e-3};
  return scene;
}

/// Presses the middle of the top by `force` [N].
Scene pressed_scene(double h, double seconds, const PrintedForm& printed = {}, double force = press,
                    const std::string& integrator = "euler-cromer") {
  Scene scene = lattice_scene(h, seconds, integrator);
  scene.simulation.printed = printed;
  scene.loads.push_back({.nodes = {pressed_node}, .force = {0.0, 0.0, force}});
  return scene;
}

/// Linearises the printed equations without the force law of the model. damping_factor multiplies
/// C, for the lag of Eq. 9 where the step is not its h.
Linear linearise(const SpringNetwork& network, const PrintedForm& printed,
                 double damping_factor = 1.0) {
  const NetworkProblem problem(network);
  const Index dof = problem.dof();
  Linear linear{MatrixXd::Zero(dof, dof), MatrixXd::Zero(dof, dof)};
  for (const Spring& s : network.springs) {
    const Eigen::Vector3d d = network.rest_position.col(s.b) - network.rest_position.col(s.a);
    const double scale = (printed.half_force ? 0.5 : 1.0) * (printed.direction ? d.norm() : 1.0);
    const double k = scale * s.stiffness * (printed.sign && !printed.reversed ? -1.0 : 1.0);
    const double c = scale * s.viscosity * (printed.reversed ? -1.0 : 1.0) * damping_factor;
    const Eigen::Matrix3d along = d.normalized() * d.normalized().transpose();
    const std::array ends{s.a, s.b};
    for (const int on : ends) {
      for (const int by : ends) {
        const Index i = problem.coordinate(on);
        const Index j = problem.coordinate(by);
        if (i < 0 || j < 0) { continue; }
        const double side = (on == by ? 1.0 : -1.0) / network.mass(on);
        linear.stiffness.block<3, 3>(i, j) += side * k * along;
        linear.damping.block<3, 3>(i, j) += side * c * along;
      }
    }
  }
  return linear;
}

/// Returns the mode of Euler-Cromer with step h [s] that grows most or decays least.
Mode dominant_mode(const Linear& linear, double h) {
  const Index dof = linear.stiffness.rows();
  const MatrixXd identity = MatrixXd::Identity(dof, dof);
  MatrixXd kick = MatrixXd::Identity(2 * dof, 2 * dof);
  kick.bottomLeftCorner(dof, dof) = -h * linear.stiffness;
  kick.bottomRightCorner(dof, dof) = identity - h * linear.damping;
  MatrixXd drift = MatrixXd::Identity(2 * dof, 2 * dof);
  drift.topRightCorner(dof, dof) = h * identity;
  return dominant((drift * kick).transpose(),
                  [](auto a, auto b) { return std::abs(a) < std::abs(b) * (1.0 - 1e-12); });
}

/// Returns the mode of the exact motion that grows most or decays least.
Mode dominant_mode(const Linear& linear) {
  const Index dof = linear.stiffness.rows();
  MatrixXd motion = MatrixXd::Zero(2 * dof, 2 * dof);
  motion.topRightCorner(dof, dof).setIdentity();
  motion.bottomLeftCorner(dof, dof) = -linear.stiffness;
  motion.bottomRightCorner(dof, dof) = -linear.damping;
  return dominant(motion.transpose(), [](auto a, auto b) { return a.real() < b.real(); });
}

/// Displaces the free nodes along the position weights of a mode by at most `amplitude` [m].
SpringNetwork displaced(SpringNetwork network, const Mode& mode, double amplitude) {
  const NetworkProblem problem(network);
  const VectorXd shape = mode.left.head(mode.left.size() / 2).real();
  network.initial_displacement = NodeVectors::Zero(3, network.node_count());
  for (const int node : problem.free_nodes()) {
    network.initial_displacement.col(node) =
        amplitude / shape.cwiseAbs().maxCoeff() * shape.segment<3>(problem.coordinate(node));
  }
  return network;
}

/// Returns log |w^T s(last) / w^T s(0)|; NaN if the motion is not finite or ended early.
double log_growth(const Mode& mode, const SpringNetwork& network, const MatrixXd& position,
                  const MatrixXd& velocity) {
  const VectorXd rest = NetworkProblem(network).initial_position();
  const Index dof = rest.size();
  const bool usable = position.rows() == dof && velocity.rows() == dof && position.cols() >= 2 &&
                      velocity.cols() == position.cols() && position.allFinite() &&
                      velocity.allFinite();
  if (!usable) { return nan; }
  const auto weight = [&](Index column) {
    const VectorXd u = position.col(column) - rest;
    const VectorXd v = velocity.col(column);
    return std::abs((mode.left.head(dof).array() * u.array()).sum() +
                    (mode.left.tail(dof).array() * v.array()).sum());
  };
  return std::log(weight(position.cols() - 1) / weight(0));
}

/// Measures a growth rate; `update` is the step length in the printed form, h or 1.
Rate measure_rate(const CaseContext& context, const PrintedForm& printed, double h, double update,
                  double damping_factor = 1.0) {
  const SpringNetwork network = build_network(lattice_scene(h, h));
  const Linear linear = linearise(network, printed, damping_factor);
  const Mode mode = dominant_mode(linear, update);
  const double per_step = std::log(std::abs(mode.value));
  // Growth by five powers of e is measurable and keeps strains below 1e-4.
  const long steps = std::clamp(std::lround(5.0 / std::abs(per_step)), 1L, 20000L);
  Scene scene = lattice_scene(h, static_cast<double>(steps) * h);
  scene.simulation.printed = printed;
  const double amplitude =
      std::clamp(small / std::exp(per_step * static_cast<double>(steps)), 1e-13, faint);
  const SpringNetwork start = displaced(network, mode, amplitude);
  const Trace motion =
      roll_out(context, scene, &start, {.every = steps, .position = true, .velocity = true});
  const double seconds = static_cast<double>(steps) * h;
  Rate rate{
      .predicted = per_step / h, .motion = dominant_mode(linear).value.real(), .steps = steps};
  rate.measured = motion.steps == steps && !motion.diverged
                      ? log_growth(mode, network, motion.position, motion.velocity) / seconds
                      : nan;
  return rate;
}

/// Returns the same growth rate from a solution of the printed equations by an external solver.
double reference_rate(const PrintedForm& printed) {
  const SpringNetwork network = build_network(lattice_scene(step, step));
  const Mode mode = dominant_mode(linearise(network, printed));
  const double seconds = 5.0 / std::abs(mode.value.real());
  const NetworkProblem problem(displaced(network, mode, faint), {}, Eigen::Vector3d::Zero(),
                               printed);
  const Trace solution = reference::solve_arkode_explicit(problem, {0.0, 0.5 * seconds, seconds},
                                                          {1e-9, faint, faint * 1e3});
  return log_growth(mode, network, solution.position, solution.velocity) / seconds;
}

/// Solves the pressed lattice with ARKODE.
MatrixXd solve_pressed(const std::vector<double>& times, const PrintedForm& printed) {
  const Scene scene = pressed_scene(step, duration);
  const SpringNetwork network = build_network(scene);
  const NetworkProblem problem(network, resolve_loads(scene, network), Eigen::Vector3d::Zero(),
                               printed);
  return reference::solve_arkode_explicit(problem, times, {1e-11, 1e-4, 1e-1}).position.colwise() -
         problem.initial_position();
}

/// Runs a scene and returns its displacements as positions at even instants; `samples` must divide
/// the number of ticks.
Trace displacements(const CaseContext& context, const Scene& scene, long samples) {
  const SpringNetwork network = build_network(scene);
  const long ticks = std::lround(scene.simulation.duration / scene.simulation.step);
  Trace motion = roll_out(context, scene, &network, {.every = ticks / samples, .position = true});
  const VectorXd rest = NetworkProblem(network).initial_position();
  if (motion.position.rows() != rest.size()) { motion.position.resize(rest.size(), 0); }
  motion.position.colwise() -= rest;
  return motion;
}

/// Displacements of the pressed lattice; `ticks` must be a multiple of sample_count.
Trace run_pressed(const CaseContext& context, const PrintedForm& printed, long ticks) {
  const double h = duration / static_cast<double>(ticks);
  return displacements(context, pressed_scene(h, duration, printed), sample_count);
}

/// Returns `count` + 1 evenly spaced instants from 0 to `end` [s].
std::vector<double> even_times(double end, long count) {
  std::vector<double> times;
  for (long n = 0; n <= count; ++n) {
    times.push_back(end * static_cast<double>(n) / static_cast<double>(count));
  }
  return times;
}

/// Returns the largest difference over the peak of the truth; NaN if a run ended early.
double distance(const MatrixXd& found, const MatrixXd& truth) {
  return trajectory_error(found, truth, VectorXd::Zero(truth.rows())).maximum;
}

constexpr long pressed_ticks = 500;  ///< steps of 1e-4 s

/// Number of samples until the error of the printed form equals the peak, and the time of that.
struct Departure {
  double error = 0.0;
  double at = unbounded;
};

Departure departure(const Trace& run, const Eigen::MatrixXd& truth) {
  const double peak = truth.cwiseAbs().maxCoeff();
  Departure found;
  for (Eigen::Index n = 0; n < run.position.cols(); ++n) {
    const double error = (run.position.col(n) - truth.col(n)).cwiseAbs().maxCoeff() / peak;
    found.error = std::max(found.error, error);
    if (!(error < 1.0) && found.at == unbounded) {
      found.at = run.time[static_cast<std::size_t>(n)];
    }
  }
  if (run.diverged) {
    found.error = unbounded;
    found.at = std::min(found.at, run.diverged_at);
  }
  return found;
}

/// Depth of the pressed node in millimetres, as far as it stays in the picture.
Series depth_curve(const std::string& label, Series::Style style, const std::vector<double>& time,
                   const Eigen::MatrixXd& displacement, double bound) {
  Series series{.label = label, .style = style};
  for (Eigen::Index n = 0; n < displacement.cols(); ++n) {
    const double z = displacement(3 * pressed_node + 2, n);
    if (!(std::abs(z) <= bound)) { break; }
    series.add(1e3 * time[static_cast<std::size_t>(n)], 1e3 * z);
  }
  return series;
}

Cell finite_or(const std::string& words, double value) {
  return std::isfinite(value) ? Cell(value) : Cell(words);
}

/// First order: the error is twice its change when the step is halved.
double judge_first_order(const CaseContext& context, Outcome& outcome, const std::string& name,
                         const PrintedForm& printed, const Eigen::MatrixXd& truth) {
  const Eigen::MatrixXd coarse = run_pressed(context, printed, pressed_ticks).position;
  const Eigen::MatrixXd fine = run_pressed(context, printed, 2 * pressed_ticks).position;
  const double expected = 2.0 * distance(fine, coarse);
  const double error = distance(coarse, truth);
  outcome.judge_between(name, error, 0.85 * expected, 1.15 * expected,
                        "twice the change on halving the step (order 1), +-15 % of order 2");
  return error;
}

/// Judges the corrected model, measures the printed form, and adds the table and the figure.
void compare_pressed(const CaseContext& context, Outcome& outcome, const PrintedForm& printed,
                     const std::string& name) {
  const std::vector<double> times = even_times(duration, sample_count);
  const Eigen::MatrixXd truth = solve_pressed(times, {});
  const Trace coarse = run_pressed(context, {}, pressed_ticks);
  const Trace wrong = run_pressed(context, printed, pressed_ticks);
  const double error =
      judge_first_order(context, outcome, "corrected model against ARKODE", {}, truth);
  const Departure off = departure(wrong, truth);
  outcome.tables.push_back(make_table(
      "errors", "A pressed lattice, corrected and as printed: " + name,
      "Same scheme (Euler-Cromer) and step (0.1 ms); errors over 50 ms against ARKODE.",
      {"form", "error over peak (1)", "off by the whole peak at (s)"},
      {{"corrected", error, "never"},
       {"as printed: " + name, finite_or("diverged", off.error), finite_or("never", off.at)}}));
  const double bound = 3.0 * truth.cwiseAbs().maxCoeff();
  outcome.figures.push_back(plot(
      "pressed", "Depth of a pressed node: " + name,
      "The corrected model lies on the reference; beside it what the printed form does, as far as "
      "three times the peak.",
      {"time (ms)"}, {"depth (mm)"},
      {depth_curve("ARKODE", Series::Style::line, times, truth, unbounded),
       depth_curve("corrected", Series::Style::points, coarse.time, coarse.position, unbounded),
       depth_curve("as printed", Series::Style::line_and_points, wrong.time, wrong.position,
                   bound)}));
}

// Eq. 9: the extension rate from the previous displacement lags by half a step.

constexpr double span = 0.02;  ///< [s] of the ladder
constexpr long sample_count_of_ladder = 20;
constexpr double relaxation = 0.02 / 50.0;  ///< c / k of every spring [s]

struct Variant {
  std::string name;
  std::string scheme;
  bool lagged;
  int order;
};

/// Displacements of a pressed lattice over `span` at 20 instants.
Eigen::MatrixXd run_variant(const CaseContext& context, const Variant& variant, long ticks) {
  const Scene scene = pressed_scene(span / static_cast<double>(ticks), span,
                                    {.lagged_velocity = variant.lagged}, press, variant.scheme);
  return displacements(context, scene, sample_count_of_ladder).position;
}

ObservedOrder climb(const CaseContext& context, const Variant& variant,
                    const Eigen::MatrixXd& truth, Figure& figure) {
  Series& errors = figure.add(variant.name, Series::Style::line_and_points);
  for (int rung = 0; rung < (context.quick ? 5 : 6); ++rung) {
    const double coarsest = variant.order == 1 ? 800.0 : 240.0;
    const long ticks =
        sample_count_of_ladder *
        std::lround(coarsest * std::pow(1.37, rung) / static_cast<double>(sample_count_of_ladder));
    errors.add(span / static_cast<double>(ticks),
               distance(run_variant(context, variant, ticks), truth));
  }
  return observed_order(errors.x, errors.y, 1e-9);  // ARKODE at 1e-11 is far below
}

/// Stable step of kick and drift: damping centred, 2 / omega; lagging by h/2,
/// 2 (sqrt(1 + S^2) - S) / omega of the worst mode. C = (c/k) K, so each mode has its own S.
double predicted_limit(bool lagged) {
  const Linear linear = linearise(build_network(lattice_scene(step, step)), {});
  const Eigen::VectorXd squares = reference::symmetric_eigenvalues(linear.stiffness);
  double limit = unbounded;
  for (const double square : squares) {
    const double omega = std::sqrt(square);
    const double s = lagged ? 0.5 * relaxation * omega : 0.0;
    limit = std::min(limit, 2.0 / (omega * (std::sqrt(1.0 + s * s) + s)));
  }
  return limit;
}

/// Returns true if a displacement of 1e-9 m, in all modes, grows a hundredfold in 3000 steps.
bool grows(const CaseContext& context, const Variant& variant, double h) {
  const long ticks = 3000;
  Scene scene = lattice_scene(h, static_cast<double>(ticks) * h, variant.scheme);
  scene.simulation.printed.lagged_velocity = variant.lagged;
  SpringNetwork network = build_network(scene);
  network.initial_displacement = NodeVectors::Zero(3, network.node_count());
  for (Eigen::Index i = 0; i < network.initial_displacement.size(); ++i) {
    network.initial_displacement(i) = 1e-9 * std::cos(1.0 + 12.9898 * static_cast<double>(i));
  }
  for (int node = 0; node < network.node_count(); ++node) {
    if (network.is_fixed(node)) { network.initial_displacement.col(node).setZero(); }
  }
  const Trace motion = roll_out(context, scene, &network, {.every = 50, .position = true});
  if (motion.diverged || !motion.position.allFinite()) { return true; }
  const Eigen::VectorXd start = motion.position.col(0);
  const auto moved = (motion.position.colwise() - start).cwiseAbs().maxCoeff();
  return moved > 1e-7;
}

double found_limit(const CaseContext& context, const Variant& variant) {
  double good = 2e-3;
  double bad = 3.2e-3;
  if (grows(context, variant, good)) { return 0.0; }
  while (bad - good > 2e-3 * bad) {
    const double middle = std::sqrt(good * bad);
    (grows(context, variant, middle) ? bad : good) = middle;
  }
  return 0.5 * (good + bad);
}

void judge_limit(const CaseContext& context, Outcome& outcome, const Variant& variant,
                 Table& table) {
  const double theory = predicted_limit(variant.lagged);
  const double found = found_limit(context, variant);
  outcome.judge_between(
      variant.name + ": stable step over theory", found / theory, 0.995, 1.005,
      "eigenvalues of the linearised lattice; 0.2 % of the search, 3000 steps to grow in");
  table.rows.push_back({variant.name, found, theory});
}

/// Along a spring the last displacement of Euler-Cromer is h times the velocity it has now.
void judge_no_lag(const CaseContext& context, Outcome& outcome) {
  const Eigen::MatrixXd plain = run_pressed(context, {}, 500).position;
  const Eigen::MatrixXd lagged = run_pressed(context, {.lagged_velocity = true}, 500).position;
  const double strain = plain.size() == 0 ? 0.0 : plain.cwiseAbs().maxCoeff() / 0.005;
  outcome.judge_at_most("Euler-Cromer with the lag less without", distance(lagged, plain),
                        strain * strain,
                        "x(n) - x(n-1) = h v(n), except for the turn of a spring, at most the "
                        "strain, times displacements of the size of the strain");
}

/// Explicit Euler with the lag uses the velocity of a whole step ago. The fastest mode q obeys
/// q(n+1) = 2 q(n) - q(n-1) - h^2 w^2 q(n-1) - h (c/k) w^2 (q(n-1) - q(n-2)), q before 0 as at 0.
void judge_recurrence(const CaseContext& context, Outcome& outcome) {
  const long steps = 100;
  Scene scene = lattice_scene(step, static_cast<double>(steps) * step, "euler");
  scene.simulation.printed.lagged_velocity = true;
  SpringNetwork network = build_network(scene);
  const reference::SymmetricModes modes =
      reference::symmetric_modes(linearise(network, {}).stiffness);
  const Eigen::VectorXd shape = modes.vectors.rightCols(1);
  const double square = modes.values.maxCoeff();
  const double amplitude = 1e-9;
  // Nodes are numbered layer by layer and the fixed layer is the last, so free nodes come first.
  network.initial_displacement = NodeVectors::Zero(3, network.node_count());
  network.initial_displacement.leftCols(shape.size() / 3) =
      amplitude * Eigen::Map<const NodeVectors>(shape.data(), 3, shape.size() / 3);
  const Trace motion = roll_out(context, scene, &network, {.position = true});
  double error = motion.position.cols() == steps + 1 ? 0.0 : std::nan("");
  double q[3] = {amplitude, amplitude, amplitude};  // q(n), q(n-1), q(n-2)
  for (Eigen::Index n = 1; n < motion.position.cols() && error >= 0.0; ++n) {
    const double drift = n == 1 ? q[0]  // at rest before the first step
                                : 2.0 * q[0] - q[1] - step * step * square * q[1] -
                                      step * relaxation * square * (q[1] - q[2]);
    q[2] = q[1];
    q[1] = q[0];
    q[0] = drift;
    const double found = shape.dot(motion.position.col(n) - motion.position.col(0)) + amplitude;
    error = std::max(std::abs(found - q[0]), error);
    if (!std::isfinite(found)) { error = std::nan(""); }
  }
  outcome.judge_at_most("Euler with the lag less its recurrence", error / amplitude, 3e-7,
                        "strains of 2e-7; 100 steps of 1e-18 m of rounding in 1e-9 m");
}

const std::array<Variant, 4> variants{
    Variant{"leapfrog, rate at the instant", "leapfrog", false, 2},
    Variant{"half-step start, rate of h/2 ago", "feynman-newton", false, 1},
    Variant{"half-step start, lagged as printed", "feynman-newton", true, 1},
    Variant{"Euler, lagged as printed", "euler", true, 1}};

double judge_orders(const CaseContext& context, Outcome& outcome) {
  const Eigen::MatrixXd truth = solve_pressed(even_times(span, sample_count_of_ladder), {});
  Figure& figure =
      outcome.plot("order", "What the lag of Eq. 9 costs",
                   "With the rate at the instant of the position the same kick and drift has order "
                   "2; with the printed rate it has order 1.",
                   logarithmic("step h (s)"), logarithmic("largest error over peak (1)"));
  std::array<double, 4> slopes{};
  for (std::size_t i = 0; i < variants.size(); ++i) {
    const ObservedOrder order = climb(context, variants[i], truth, figure);
    slopes[i] = order.slope;
    const double p = variants[i].order;
    outcome.judge_near(
        "order: " + variants[i].name, order.slope, p, 0.15,
        variants[i].order == 2 ? "centred differences" : "a rate that lags is wrong by O(h)");
  }
  outcome.judge_between("order lost", slopes[0] - slopes[2], 0.7, 1.3,
                        "one, from two slopes known to 0.15");
  return slopes[0] - slopes[2];
}

Finding measure_lagged_velocity(const CaseContext& context, Outcome& outcome) {
  const double lost = judge_orders(context, outcome);
  Table& limits = outcome.table("limits", "Stable steps of the lattice",
                                "Found by bisection on runs, and predicted from its modes.",
                                {"scheme", "found (s)", "theory (s)"});
  if (!context.quick) { judge_limit(context, outcome, variants[0], limits); }
  judge_limit(context, outcome, variants[2], limits);
  judge_no_lag(context, outcome);
  judge_recurrence(context, outcome);
  compare_pressed(context, outcome, {.lagged_velocity = true}, "lagged-velocity");
  outcome.notes.emplace_back(
      "In Euler-Cromer the last displacement is the step times the velocity it has now, so the lag "
      "of Eq. 9 changes nothing there; it is in a scheme of second order that it costs an order.");
  return {"lagged velocity", "Eq. 9", "one order of accuracy and some of the stable step",
          "order lost (1)",  lost,    1.0};
}

// Errata that change the stiffness of the tissue, judged by static deflection and by decay.

constexpr double touch = 1e-7;  ///< [N] deflects by 1e-9 m, and tissue 150 times softer by 1e-7 m

/// Returns the equilibrium, by implicit Euler with steps of 10 s, which damp every mode.
Eigen::VectorXd rest_under(const CaseContext& context, const PrintedForm& printed, double force) {
  const Scene scene = pressed_scene(10.0, 300.0, printed, force, "implicit-euler");
  const Trace motion = displacements(context, scene, 1);
  if (motion.diverged || motion.position.cols() < 2) {
    return Eigen::VectorXd::Constant(1, std::nan(""));
  }
  return motion.position.rightCols(1);
}

double depth(const Eigen::VectorXd& displacement) {
  const Eigen::Index at = 3 * pressed_node + 2;
  return displacement.size() > at ? displacement(at) : std::nan("");
}

/// Returns the displacement of the pressed node [m] from the linearised printed equations.
double predicted_depth(const PrintedForm& printed, double force) {
  const SpringNetwork network = build_network(lattice_scene(step, step));
  const Linear linear = linearise(network, printed);
  Eigen::VectorXd f = Eigen::VectorXd::Zero(linear.stiffness.rows());
  f(3 * pressed_node + 2) = force / network.mass(pressed_node);
  return depth(linear.stiffness.ldlt().solve(f));  // one mass for all: still symmetric
}

double reference_depth(const PrintedForm& printed, double force) {
  const Scene scene = pressed_scene(step, step, {}, force);
  const SpringNetwork network = build_network(scene);
  const NetworkProblem problem(network, resolve_loads(scene, network), Eigen::Vector3d::Zero(),
                               printed);
  return depth(reference::static_equilibrium(problem).position - problem.initial_position());
}

void judge_ratio(Outcome& outcome, const std::string& name, double value, double expected,
                 double tolerance, const std::string& from) {
  outcome.judge_between(name, value, expected * (1.0 - tolerance), expected * (1.0 + tolerance),
                        from);
}

/// Judges the stiffness at a point and returns printed over corrected.
double judge_stiffness(const CaseContext& context, Outcome& outcome, const PrintedForm& printed,
                       double expected) {
  const double corrected = depth(rest_under(context, {}, touch));
  const double wrong = depth(rest_under(context, printed, touch));
  const std::string strain = "; strains below 1e-4 bend it";
  judge_ratio(outcome, "corrected depth over the linear one",
              corrected / predicted_depth({}, touch), 1.0, 1e-4, "K^-1 f" + strain);
  judge_ratio(outcome, "corrected depth over the Newton solution",
              corrected / reference_depth({}, touch), 1.0, 1e-8,
              "Newton to 1e-12; 1e-18 m of rounding in 1e-9 m");
  judge_ratio(outcome, "printed depth over the Newton solution of the printed equations",
              wrong / reference_depth(printed, touch), 1.0, 1e-8,
              "Newton to 1e-12; 1e-18 m of rounding in 1e-9 m");
  judge_ratio(outcome, "stiffness, printed over corrected", corrected / wrong, expected, 1e-4,
              "static deflection by the printed equations" + strain);
  return corrected / wrong;
}

/// Measures the decay of the slowest mode.
void judge_decay(const CaseContext& context, Outcome& outcome, const PrintedForm& printed,
                 const std::string& name) {
  const Rate rate = measure_rate(context, printed, step, step);
  judge_ratio(outcome, name + ": decay of the slowest mode over its prediction",
              rate.measured / rate.predicted, 1.0, 1e-4,
              "eigenvalue of the linearised printed step; strains of 1e-4 bend it");
  outcome.report(name + ": decay of the slowest mode", -rate.measured, "1/s");
}

/// The printed form is a well-posed model of other tissue: ARKODE on it must agree with it.
void judge_other_tissue(const CaseContext& context, Outcome& outcome, const PrintedForm& printed,
                        const std::string& name, const std::string& id) {
  judge_decay(context, outcome, {}, "corrected");
  judge_decay(context, outcome, printed, name);
  judge_first_order(context, outcome, "printed form against ARKODE on the printed equations",
                    printed, solve_pressed(even_times(duration, sample_count), printed));
  compare_pressed(context, outcome, printed, id);
}

Finding measure_direction(const CaseContext& context, Outcome& outcome) {
  const PrintedForm printed{.direction = true};
  const double expected = predicted_depth({}, touch) / predicted_depth(printed, touch);
  const double found = judge_stiffness(context, outcome, printed, expected);
  outcome.judge_between("stiffness ratio over the shortest spring's length", found / 0.005, 1.0,
                        std::sqrt(3.0), "springs are from 1 to sqrt 3 spacings long");
  judge_other_tissue(context, outcome, printed, "direction", "direction");
  outcome.notes.emplace_back(
      "Multiplying by d makes a spring's stiffness k L in N: with lengths in metres this lattice "
      "is some 150 times too soft, with lengths in millimetres it would be too stiff, and "
      "diagonals gain on edges.");
  return {"direction",           "Eq. 12", "stiffness scales with each spring's length in metres",
          "stiffness ratio (1)", found,    expected};
}

Finding measure_half_force(const CaseContext& context, Outcome& outcome) {
  const PrintedForm printed{.half_force = true};
  const double found = judge_stiffness(context, outcome, printed, 0.5);
  // Exact at any strain: half forces under a load are whole forces under twice the load.
  const Eigen::VectorXd halved = rest_under(context, printed, press);
  const Eigen::VectorXd doubled = rest_under(context, {}, 2.0 * press);
  const double difference =
      halved.size() == doubled.size() ? (halved - doubled).norm() / doubled.norm() : std::nan("");
  outcome.judge_at_most("half forces under a load less whole forces under twice the load",
                        difference, 1e-9,
                        "equal equilibria; Newton to 64 eps, 1e-18 m of rounding in 1e-3 m");
  judge_other_tissue(context, outcome, printed, "half force", "half-force");
  return {"half force",          "Eq. 14", "half as stiff and half as damped",
          "stiffness ratio (1)", found,    0.5};
}

// Errata that make a lattice diverge, compared with growth rates of the linearised equations.

void judge_rate(Outcome& outcome, const std::string& name, const Rate& rate) {
  outcome.report(name + ": growth per second", rate.measured, "1/s");
  judge_ratio(outcome, name + ": growth over its prediction", rate.measured / rate.predicted, 1.0,
              1e-4, "eigenvalue of the linearised printed step; strains of 1e-4 bend it");
}

/// The runs are so long that every growing mode exceeds all bounds.
void judge_runaway(const CaseContext& context, Outcome& outcome, const PrintedForm& printed,
                   const std::string& name, double seconds) {
  const Scene scene = pressed_scene(step, seconds, printed);
  const SpringNetwork network = build_network(scene);
  const Trace motion = roll_out(context, scene, &network, {.every = 100, .position = true});
  outcome.judge_true(name + ": diverges", motion.diverged, "a positive rate of growth");
  outcome.report(name + ": out of all bounds at", motion.diverged_at, "s");
}

/// A form whose continuous motion grows: rates of the model and of ARKODE, and divergence.
Rate judge_growing_form(const CaseContext& context, Outcome& outcome, const PrintedForm& printed,
                        const std::string& name) {
  const Rate rate = measure_rate(context, printed, step, step);
  judge_rate(outcome, name, rate);
  judge_ratio(outcome, "ARKODE on the printed equations: growth over its prediction",
              reference_rate(printed) / rate.motion, 1.0, 1e-4,
              "eigenvalue of the linearised printed equations; strains of 1e-4 bend it");
  outcome.report("rate of the printed equations without steps", rate.motion, "1/s");
  judge_runaway(context, outcome, printed, name, 1.0);
  compare_pressed(context, outcome, printed, name);
  return rate;
}

Finding measure_sign(const CaseContext& context, Outcome& outcome) {
  const Rate rate = judge_growing_form(context, outcome, {.sign = true}, "sign");
  return {"sign",
          "Eqs. 11-13",
          "a stretched spring pushes its ends apart: every network diverges",
          "growth (1/s)",
          rate.measured,
          rate.predicted};
}

Finding measure_reversed(const CaseContext& context, Outcome& outcome) {
  const Rate rate =
      judge_growing_form(context, outcome, {.sign = true, .reversed = true}, "reversed");
  return {"sign, turned round",
          "Eqs. 11-13, force reversed",
          "the damper feeds energy in: every network with viscosity diverges",
          "growth (1/s)",
          rate.measured,
          rate.predicted};
}

Finding measure_no_time_step(const CaseContext& context, Outcome& outcome) {
  const PrintedForm printed{.no_time_step = true};
  const Rate rate = measure_rate(context, printed, step, 1.0);
  judge_rate(outcome, "no time step", rate);
  judge_runaway(context, outcome, printed, "no time step", duration);

  // A lattice a billion times softer has a stable step above 1 s: what is left of the erratum is a
  // clock that runs at one second per tick, to the last bit.
  Scene soft = pressed_scene(step, 100.0 * step, printed);
  soft.tissue.lattice.stiffness *= 1e-9;
  soft.tissue.lattice.viscosity *= 1e-6;
  soft.loads[0].force *= 1e-9;
  Scene seconds = soft;
  seconds.simulation.printed = {};
  seconds.simulation.step = 1.0;
  seconds.simulation.duration = 100.0;
  const SpringNetwork network = build_network(soft);
  const Trace ticks = roll_out(context, soft, &network, {.position = true});
  const Trace slow = roll_out(context, seconds, &network, {.position = true});
  const bool comparable = ticks.position.cols() == 101 && slow.position.cols() == 101 &&
                          ticks.position.allFinite() && slow.position.allFinite();
  const double difference =
      comparable ? (ticks.position - slow.position).cwiseAbs().maxCoeff() : std::nan("");
  outcome.judge_at_most("soft lattice: printed ticks less corrected steps of 1 s", difference, 0.0,
                        "the same operations in the same order", "m");
  compare_pressed(context, outcome, printed, "no-time-step");
  outcome.notes.emplace_back(
      "Without the time step every tick advances the tissue by one second; only tissue whose "
      "fastest frequency is below 2 rad/s would survive it.");
  return {"no time step",
          "pseudo-code",
          "every tick is a step of 1 s: diverges at once",
          "log growth per tick (1)",
          rate.measured * step,
          rate.predicted * step};
}

Finding measure_all_printed(const CaseContext& context, Outcome& outcome) {
  // Eq. 9 divides by the tick while a step lasts one second, so damping is 1 / tick times itself.
  const PrintedForm printed = PrintedForm::all();
  const Rate rate = measure_rate(context, printed, step, 1.0, 1.0 / step);
  judge_rate(outcome, "all printed", rate);
  judge_runaway(context, outcome, printed, "all printed", duration);
  compare_pressed(context, outcome, printed, "all-printed");
  return {"all as printed",          "Eqs. 9-14 and pseudo-code", "diverges within a few ticks",
          "log growth per tick (1)", rate.measured * step,        rate.predicted * step};
}

struct Erratum {
  std::string name;
  std::string claim;
  Finding (*measure)(const CaseContext& context, Outcome& outcome);
};

const std::array<Erratum, 7> all_errata{
    Erratum{"sign", "With the printed sign a lattice diverges at the rate that its equations say.",
            measure_sign},
    Erratum{"reversed",
            "With the printed force turned round the dampers make a lattice diverge at the rate "
            "that its equations say.",
            measure_reversed},
    Erratum{"direction", "Multiplying by d instead of u makes stiffness scale with length.",
            measure_direction},
    Erratum{"half-force", "Halving each force halves stiffness and damping, exactly.",
            measure_half_force},
    Erratum{"no-time-step", "Without the time step every tick is a step of one second.",
            measure_no_time_step},
    Erratum{"lagged-velocity",
            "The printed spring velocity costs one order of accuracy and some stability.",
            measure_lagged_velocity},
    Erratum{"all-printed", "The equations as printed diverge within a few ticks.",
            measure_all_printed}};

void measure_summary(const CaseContext& context, Outcome& outcome) {
  Table& table =
      outcome.table("errata", "What each printed form does",
                    "Each erratum alone and all together, measured and predicted.",
                    {"erratum", "printed in", "what it does", "quantity", "measured", "predicted"});
  for (const Erratum& erratum : all_errata) {
    Outcome own;
    const Finding finding = erratum.measure(context, own);
    conclude(own);
    outcome.judge_at_most(
        erratum.name + ": claims that do not hold",
        std::ranges::count_if(own.quantities,
                              [](const Quantity& q) { return q.judged() && !q.holds(); }),
        0.0, "errata/" + erratum.name);
    outcome.report(erratum.name + ": measured over predicted",
                   finding.measured / finding.predicted);
    table.rows.push_back({finding.erratum, finding.printed, finding.effect, finding.quantity,
                          finding.measured, finding.predicted});
  }
}

}  // namespace

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const Erratum& erratum : all_errata) {
    all.push_back({"errata/" + erratum.name, "model", erratum.claim, erratum.measure, 0.5});
  }
  all.push_back({"errata/summary", "model", "Each printed form does what its equations predict.",
                 measure_summary, 3.0});
  return all;
}

}  // namespace palpate::errata
