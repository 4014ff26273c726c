// SPDX-License-Identifier: MIT

#include "validation/claims/errata_fixture.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/tissue/network_builder.hpp"
#include "reference/modal.hpp"
#include "reference/solvers.hpp"
#include "validation/signal.hpp"

namespace palpate::errata {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double faint = 1e-9;  ///< [m] displacement of a mode at the start; a spring is 5 mm
constexpr double small = 5e-7;  ///< [m] and at the end: a strain of 1e-4

std::vector<int> free_nodes(const SpringNetwork& network) {
  std::vector<int> nodes;
  for (int node = 0; node < network.node_count(); ++node) {
    if (!network.is_fixed(node)) { nodes.push_back(node); }
  }
  return nodes;
}

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

VectorXd rest_of(const SpringNetwork& network) {
  const std::vector<int> nodes = free_nodes(network);
  VectorXd rest(3 * static_cast<Index>(nodes.size()));
  Index i = 0;
  for (const int node : nodes) {
    rest.segment<3>(i) = network.rest_position.col(node);
    i += 3;
  }
  return rest;
}

}  // namespace

Scene lattice_scene(double h, double seconds, const std::string& integrator) {
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

Scene pressed_scene(double h, double seconds, const PrintedForm& printed) {
  Scene scene = lattice_scene(h, seconds);
  scene.simulation.printed = printed;
  scene.loads.push_back({.nodes = {pressed_node}, .force = {0.0, 0.0, press}});
  return scene;
}

Linear linearise(const SpringNetwork& network, const PrintedForm& printed, double damping_factor) {
  const std::vector<int> nodes = free_nodes(network);
  std::vector<Index> coordinate(static_cast<std::size_t>(network.node_count()), -1);
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    coordinate[static_cast<std::size_t>(nodes[n])] = 3 * static_cast<Index>(n);
  }
  const Index dof = 3 * static_cast<Index>(nodes.size());
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
        const Index i = coordinate[static_cast<std::size_t>(on)];
        const Index j = coordinate[static_cast<std::size_t>(by)];
        if (i < 0 || j < 0) { continue; }
        const double side = (on == by ? 1.0 : -1.0) / network.mass(on);
        linear.stiffness.block<3, 3>(i, j) += side * k * along;
        linear.damping.block<3, 3>(i, j) += side * c * along;
      }
    }
  }
  return linear;
}

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

Mode dominant_mode(const Linear& linear) {
  const Index dof = linear.stiffness.rows();
  MatrixXd motion = MatrixXd::Zero(2 * dof, 2 * dof);
  motion.topRightCorner(dof, dof).setIdentity();
  motion.bottomLeftCorner(dof, dof) = -linear.stiffness;
  motion.bottomRightCorner(dof, dof) = -linear.damping;
  return dominant(motion.transpose(), [](auto a, auto b) { return a.real() < b.real(); });
}

SpringNetwork displaced(SpringNetwork network, const Mode& mode, double amplitude) {
  const std::vector<int> nodes = free_nodes(network);
  const VectorXd shape = mode.left.head(mode.left.size() / 2).real();
  network.initial_displacement = NodeVectors::Zero(3, network.node_count());
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    network.initial_displacement.col(nodes[n]) =
        amplitude / shape.cwiseAbs().maxCoeff() * shape.segment<3>(3 * static_cast<Index>(n));
  }
  return network;
}

double log_growth(const Mode& mode, const SpringNetwork& network, const MatrixXd& position,
                  const MatrixXd& velocity) {
  const VectorXd rest = rest_of(network);
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

Rate measure_rate(const CaseContext& context, const PrintedForm& printed, double h, double update,
                  double damping_factor) {
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

MatrixXd solve_pressed(const std::vector<double>& times, const PrintedForm& printed) {
  const Scene scene = pressed_scene(step, duration);
  const SpringNetwork network = build_network(scene);
  const NetworkProblem problem(network, resolve_loads(scene, network), Eigen::Vector3d::Zero(),
                               printed);
  return reference::solve_arkode_explicit(problem, times, {1e-11, 1e-4, 1e-1}).position.colwise() -
         rest_of(network);
}

Pressed run_pressed(const CaseContext& context, const PrintedForm& printed, long ticks) {
  const double h = duration / static_cast<double>(ticks);
  const Scene scene = pressed_scene(h, duration, printed);
  const SpringNetwork network = build_network(scene);
  const Trace motion =
      roll_out(context, scene, &network, {.every = ticks / sample_count, .position = true});
  Pressed pressed{
      .time = motion.time, .diverged = motion.diverged, .diverged_at = motion.diverged_at};
  if (motion.position.rows() == rest_of(network).size()) {
    pressed.displacement = motion.position.colwise() - rest_of(network);
  }
  return pressed;
}

std::vector<double> pressed_times() {
  std::vector<double> times;
  for (long n = 0; n <= sample_count; ++n) {
    times.push_back(duration * static_cast<double>(n) / static_cast<double>(sample_count));
  }
  return times;
}

double distance(const MatrixXd& found, const MatrixXd& truth) {
  return trajectory_error(found, truth, VectorXd::Zero(truth.rows())).maximum;
}

namespace {

constexpr double never = std::numeric_limits<double>::infinity();
constexpr long ticks = 500;  ///< steps of 1e-4 s

/// Number of samples until the error of the printed form equals the peak, and the time of that.
struct Departure {
  double error = 0.0;
  double at = never;
};

Departure departure(const Pressed& run, const Eigen::MatrixXd& truth) {
  const double peak = truth.cwiseAbs().maxCoeff();
  Departure found;
  for (Eigen::Index n = 0; n < run.displacement.cols(); ++n) {
    const double error = (run.displacement.col(n) - truth.col(n)).cwiseAbs().maxCoeff() / peak;
    found.error = std::max(found.error, error);
    if (!(error < 1.0) && found.at == never) { found.at = run.time[static_cast<std::size_t>(n)]; }
  }
  if (run.diverged) {
    found.error = never;
    found.at = std::min(found.at, run.diverged_at);
  }
  return found;
}

/// Depth of the pressed node in millimetres, as far as it stays in the picture.
Series depth(const std::string& label, Series::Style style, const std::vector<double>& time,
             const Eigen::MatrixXd& displacement, double bound) {
  Series series{.label = label, .style = style};
  for (Eigen::Index n = 0; n < displacement.cols(); ++n) {
    const double z = displacement(3 * pressed_node + 2, n);
    if (!(std::abs(z) <= bound)) { break; }
    series.x.push_back(1e3 * time[static_cast<std::size_t>(n)]);
    series.y.push_back(1e3 * z);
  }
  return series;
}

Cell finite_or(const std::string& words, double value) {
  return std::isfinite(value) ? Cell(value) : Cell(words);
}

/// First order: the error is twice its change when the step is halved.
double judge_corrected(const CaseContext& context, Outcome& outcome, const Pressed& coarse,
                       const Eigen::MatrixXd& truth) {
  const Pressed fine = run_pressed(context, {}, 2 * ticks);
  const double expected = 2.0 * distance(fine.displacement, coarse.displacement);
  const double error = distance(coarse.displacement, truth);
  outcome.judge(
      {.name = "corrected model against ARKODE",
       .value = error,
       .lower = 0.85 * expected,
       .upper = 1.15 * expected,
       .bound_from = "twice the change on halving the step (order 1), +-15 % of order 2"});
  return error;
}

}  // namespace

void compare_pressed(const CaseContext& context, Outcome& outcome, const PrintedForm& printed,
                     const std::string& name) {
  const std::vector<double> times = pressed_times();
  const Eigen::MatrixXd truth = solve_pressed(times, {});
  const Pressed coarse = run_pressed(context, {}, ticks);
  const Pressed wrong = run_pressed(context, printed, ticks);
  const double error = judge_corrected(context, outcome, coarse, truth);
  const Departure off = departure(wrong, truth);
  outcome.tables.push_back(
      {.id = "errors",
       .title = "A pressed lattice, corrected and as printed: " + name,
       .caption = "Same scheme (Euler-Cromer) and step (0.1 ms); errors over 50 ms against ARKODE.",
       .columns = {"form", "error over peak (1)", "off by the whole peak at (s)"},
       .rows = {
           {"corrected", error, "never"},
           {"as printed: " + name, finite_or("diverged", off.error), finite_or("never", off.at)}}});
  const double bound = 3.0 * truth.cwiseAbs().maxCoeff();
  outcome.figures.push_back(
      {.id = "pressed",
       .title = "Depth of a pressed node: " + name,
       .caption =
           "The corrected model lies on the reference; beside it what the printed form does, "
           "as far as three times the peak.",
       .x = {.label = "time (ms)"},
       .y = {.label = "depth (mm)"},
       .series = {
           depth("ARKODE", Series::Style::line, times, truth, never),
           depth("corrected", Series::Style::points, coarse.time, coarse.displacement, never),
           depth("as printed", Series::Style::line_and_points, wrong.time, wrong.displacement,
                 bound)}});
}

}  // namespace palpate::errata
