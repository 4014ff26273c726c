// SPDX-License-Identifier: MIT

#include "validation/claims/network_fixture.hpp"

#include <algorithm>
#include <cmath>

#include "model/tissue/network_builder.hpp"
#include "reference/modal.hpp"
#include "reference/solver_cross_check.hpp"
#include "reference/solvers.hpp"

namespace palpate::networks {

using Eigen::Index;

SpringNetwork block_network(const Block& block) {
  const CellMaterial material{.youngs_modulus = block.youngs_modulus,
                              .density = block.density,
                              .poissons_ratio = block.poissons_ratio};
  SpringNetwork network = cell_lattice(block.shape(), [&](int, int, int) { return material; });
  network.springs.change_each(
      [&](Spring& spring) { spring.viscosity = block.relaxation * spring.stiffness; });
  return network;
}

Scene automatic_scene(const std::string& integrator, double step, double duration) {
  Scene scene = scene_of(integrator, step, duration);
  scene.simulation.substeps.reset();
  return scene;
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

Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& a, const Eigen::VectorXd& mass) {
  const Eigen::VectorXd scale = mass.cwiseSqrt().cwiseInverse();
  return reference::symmetric_eigenvalues(scale.asDiagonal() * a * scale.asDiagonal());
}

double highest_frequency(const Problem& problem) {
  return std::sqrt(eigenvalues(stiffness_of(problem), problem.mass()).maxCoeff());
}

Truth find_truth(const CaseContext& context, const Problem& problem,
                 const std::vector<double>& times, const TruthSettings& settings) {
  using reference::solver_named;
  reference::Reference found =
      reference::establish(problem, times, settings.tolerance,
                           {solver_named(settings.solvers[0]), solver_named(settings.solvers[1])},
                           {.rungs = settings.rungs,
                            .demanded_digits = settings.demanded_digits,
                            .cache = context.cache});
  Truth truth{.agreed_digits = found.agreed_digits,
              .trustworthy = found.trustworthy,
              .reason = std::move(found.reason)};
  if (!found.second_opinions.empty()) {
    const Eigen::MatrixXd& q = found.solution.position;
    truth.worst_floor = std::ranges::max(found.position_floor);
    truth.l2_floor = trajectory_error(found.second_opinions.front().position, q, q.col(0)).l2;
  }
  truth.solution = std::move(found.solution);
  return truth;
}

void judge_truth(const Truth& truth, const TruthSettings& settings, Outcome& outcome) {
  outcome.judge_at_least("reference_agreed_digits", truth.agreed_digits, settings.demanded_digits,
                         "two families must agree at every stored instant");
  outcome.judge_true(
      "reference_trustworthy", truth.trustworthy,
      "agreement, steps taken, and a ladder of " + std::to_string(settings.rungs) + " tolerances");
  if (!truth.reason.empty()) { outcome.notes.push_back("Reference: " + truth.reason + "."); }
  outcome.notes.push_back("Reference: " + settings.solvers[0] + " (" + truth.solution.version +
                          ", relative tolerance " + text(settings.tolerance.relative) +
                          ") against " + settings.solvers[1] + ".");
}

TrajectoryError distance(const Trace& motion, const Trace& truth) {
  return trajectory_error(motion.position, truth.position, truth.position.col(0));
}

std::vector<double> row(const Eigen::MatrixXd& matrix, Index index) {
  std::vector<double> values;
  for (Index n = 0; n < matrix.cols(); ++n) { values.push_back(matrix(index, n)); }
  return values;
}

double largest_of(const Eigen::Ref<const Eigen::MatrixXd>& values) {
  return values.allFinite() ? values.cwiseAbs().maxCoeff()
                            : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace palpate::networks
