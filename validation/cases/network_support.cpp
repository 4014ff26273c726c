// SPDX-License-Identifier: MIT
#include "validation/cases/network_support.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "model/dynamics/network_builder.hpp"
#include "reference/solvers.hpp"
#include "reference/trajectory_error.hpp"

namespace palpate::networks {

using Eigen::Index;

SpringNetwork block_network(const Block& block) {
  const CellMaterial material{.youngs_modulus = block.youngs_modulus, .density = block.density};
  SpringNetwork network = cell_lattice(block.shape(), [&](int, int, int) { return material; });
  for (Spring& spring : network.springs) { spring.viscosity = block.relaxation * spring.stiffness; }
  return network;
}

void hold(SpringNetwork& network, Face face) {
  for (const int node : face_nodes(network.rest_position, face)) {
    network.fixed[static_cast<std::size_t>(node)] = 1;
  }
}

void displace(SpringNetwork& network, double amplitude, std::uint64_t seed) {
  Random random(seed);
  network.initial_displacement = NodeVectors::Zero(3, network.node_count());
  for (int i = 0; i < network.node_count(); ++i) {
    if (network.is_fixed(i)) { continue; }
    network.initial_displacement.col(i) = random.vector(3, amplitude);
  }
}

SpringNetwork candidate(const CaseContext& context, SpringNetwork network) {
  if (context.mutation != nullptr && context.mutation->model) {
    Scene scene;
    context.mutation->model(scene, network);
  }
  return network;
}

NetworkProblem problem_of(const Scene& scene, const SpringNetwork& network) {
  return NetworkProblem(network, resolve_loads(scene, network), scene.tissue.gravity,
                        scene.simulation.printed);
}

Eigen::SparseMatrix<double> stiffness_of(const Problem& problem) {
  Eigen::SparseMatrix<double> stiffness;
  Eigen::SparseMatrix<double> damping;
  problem.jacobian(problem.initial_position(), Eigen::VectorXd::Zero(problem.dof()), stiffness,
                   damping);
  return stiffness;
}

double highest_frequency(const Problem& problem) {
  const Eigen::VectorXd scale = problem.mass().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled =
      scale.asDiagonal() * Eigen::MatrixXd(stiffness_of(problem)) * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scaled, Eigen::EigenvaluesOnly);
  return std::sqrt(solver.eigenvalues().maxCoeff());
}

std::vector<double> instants(double step, long count) {
  std::vector<double> times;
  for (long n = 0; n <= count; ++n) { times.push_back(static_cast<double>(n) * step); }
  return times;
}

Truth find_truth(const CaseContext& context, const Problem& problem,
                 const std::vector<double>& times, const TruthSettings& settings) {
  const auto solve = [&](const std::string& name, double relative) {
    reference::Tolerance tolerance = settings.tolerance;
    tolerance.relative = relative;
    return reference::solve_cached(context.cache, name, reference::solver_named(name).solve,
                                   problem, times, tolerance);
  };
  const double fine = settings.tolerance.relative;
  const double other_fine = settings.second_relative > 0.0 ? settings.second_relative : fine;
  Truth truth{.solution = solve(settings.solvers[0], fine)};
  const reference::Solution other = solve(settings.solvers[1], other_fine);
  const reference::Solution coarse = solve(settings.solvers[0], 100.0 * fine);
  const double peak = reference::peak_displacement(truth.solution.position);
  truth.floor = reference::instant_errors(other.position, truth.solution.position, peak);
  truth.worst_floor = std::ranges::max(truth.floor);
  truth.l2_floor =
      trajectory_error(other.position, truth.solution.position, truth.solution.position.col(0)).l2;
  truth.agreed_digits = reference::digits(truth.worst_floor);
  const double looser = reference::trajectory_error(coarse.position, truth.solution.position, peak);
  truth.ladder_falls = looser >= 1e-13 || truth.worst_floor <= 1e-12;
  return truth;
}

void judge_truth(const Truth& truth, const TruthSettings& settings, double demanded_digits,
                 Outcome& outcome) {
  outcome.judge({.name = "reference_agreed_digits",
                 .value = truth.agreed_digits,
                 .lower = demanded_digits,
                 .bound_from = "two families must agree at every stored instant"});
  outcome.judge({.name = "reference_ladder_falls",
                 .value = truth.ladder_falls ? 1.0 : 0.0,
                 .lower = 1.0,
                 .bound_from = "a hundredfold looser primary must be further away than rounding"});
  outcome.notes.push_back("Reference: " + settings.solvers[0] + " (" + truth.solution.version +
                          ", relative tolerance " + text(settings.tolerance.relative) +
                          ") against " + settings.solvers[1] + ".");
}

TrajectoryError distance(const Motion& motion, const reference::Solution& truth) {
  return trajectory_error(motion.position, truth.position, truth.position.col(0));
}

std::string text(double value) {
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.3g", value);
  return buffer.data();
}

Series line(std::string label, std::vector<double> x, std::vector<double> y, Series::Style style) {
  return {.label = std::move(label), .style = style, .x = std::move(x), .y = std::move(y)};
}

std::vector<double> row(const Eigen::MatrixXd& matrix, Index index) {
  std::vector<double> values;
  for (Index n = 0; n < matrix.cols(); ++n) { values.push_back(matrix(index, n)); }
  return values;
}

double worse(double a, double b) {
  return std::isnan(a) || std::isnan(b) ? std::numeric_limits<double>::quiet_NaN() : std::max(a, b);
}

}  // namespace palpate::networks
