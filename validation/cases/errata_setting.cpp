// SPDX-License-Identifier: MIT
#include "validation/cases/errata_setting.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/dynamics/network_builder.hpp"
#include "reference/arkode.hpp"
#include "reference/dense_modes.hpp"
#include "validation/metrics.hpp"

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

/// Of the eigenvalues of S^T the one that `larger` puts last, with its vector.
template <class Larger>
Mode dominant(const MatrixXd& transposed, Larger larger) {
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
  // Five powers of e are seen well, and leave strains below 1e-4.
  const long steps = std::clamp(std::lround(5.0 / std::abs(per_step)), 1L, 20000L);
  Scene scene = lattice_scene(h, static_cast<double>(steps) * h);
  scene.simulation.printed = printed;
  const double amplitude =
      std::clamp(small / std::exp(per_step * static_cast<double>(steps)), 1e-13, faint);
  const SpringNetwork start = displaced(network, mode, amplitude);
  const Motion motion = simulate(context, scene, &start, {.velocity = true, .every = steps});
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
  const reference::Solution solution = reference::solve_arkode_explicit(
      problem, {0.0, 0.5 * seconds, seconds}, {1e-9, faint, faint * 1e3});
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
  const Motion motion = simulate(context, scene, &network, {.every = ticks / sample_count});
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

}  // namespace palpate::errata
