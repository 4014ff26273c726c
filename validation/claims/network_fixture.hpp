// SPDX-License-Identifier: MIT
#pragma once
/// Test fixture of the groups "network" and "patient": small lattices, deterministic random
/// numbers, references from two solver families, and error plots.

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "model/problem/problem.hpp"
#include "model/tissue/lattice.hpp"
#include "model/tissue/network_builder.hpp"
#include "reference/modal.hpp"
#include "reference/solution.hpp"
#include "reference/solver_cross_check.hpp"
#include "reference/solvers.hpp"
#include "validation/case.hpp"
#include "validation/number_text.hpp"
#include "validation/random.hpp"
#include "validation/signal.hpp"

namespace palpate::networks {

inline constexpr double epsilon = std::numeric_limits<double>::epsilon();

inline std::string text(double value) { return plain_number(value, 3); }

/// Block of one material, built cell by cell and free on all sides.
struct Block {
  std::array<int, 3> nodes{4, 4, 4};
  double spacing = 5e-3;  ///< [m]
  int connectivity = 26;
  double youngs_modulus = 5e3;  ///< [Pa]
  double poissons_ratio = 0.25;
  double density = 1000.0;  ///< [kg/m^3]
  double relaxation = 0.0;  ///< c / k of every spring [s]: damping proportional to stiffness

  [[nodiscard]] LatticeShape shape() const { return {nodes, spacing, connectivity}; }
};
inline SpringNetwork block_network(const Block& block) {
  const CellMaterial material{.youngs_modulus = block.youngs_modulus,
                              .density = block.density,
                              .poissons_ratio = block.poissons_ratio};
  SpringNetwork network = cell_lattice(block.shape(), [&](int, int, int) { return material; });
  network.springs.change_each(
      [&](Spring& spring) { spring.viscosity = block.relaxation * spring.stiffness; });
  return network;
}

/// Returns scene_of() with automatic substeps.
inline Scene automatic_scene(const std::string& integrator, double step, double duration) {
  Scene scene = scene_of(integrator, step, duration);
  scene.simulation.substeps.reset();
  return scene;
}

inline void hold(SpringNetwork& network, Face face) {
  for (const int node : face_nodes(network.rest_position, face)) {
    network.fixed[static_cast<std::size_t>(node)] = 1;
  }
}

/// Gives every free node a random displacement of up to `amplitude` [m] along each axis.
inline void displace(SpringNetwork& network, double amplitude, std::uint64_t seed = 1) {
  Random random(seed);
  network.initial_displacement = NodeVectors::Zero(3, network.node_count());
  for (int i = 0; i < network.node_count(); ++i) {
    if (network.is_fixed(i)) { continue; }
    network.initial_displacement.col(i) = random.vector(3, amplitude);
  }
}

/// Returns the network with the planted fault, for claims about a network at rest.
inline SpringNetwork candidate(const CaseContext& context, SpringNetwork network) {
  if (context.mutation != nullptr && context.mutation->model) {
    Scene scene;
    context.mutation->model(scene, network);
  }
  return network;
}

/// Returns the equation of motion of a scene with a network.
inline NetworkProblem problem_of(const Scene& scene, const SpringNetwork& network) {
  return NetworkProblem(network, resolve_loads(scene, network), scene.tissue.gravity,
                        scene.simulation.printed);
}

/// Returns K = -df/dq at the initial state.
inline Eigen::SparseMatrix<double> stiffness_of(const Problem& problem) {
  Eigen::SparseMatrix<double> stiffness;
  Eigen::SparseMatrix<double> damping;
  problem.jacobian(problem.initial_position(), Eigen::VectorXd::Zero(problem.dof()), stiffness,
                   damping);
  return stiffness;
}

/// Returns the eigenvalues of M^-1 A, ascending.
inline Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& a, const Eigen::VectorXd& mass) {
  const Eigen::VectorXd scale = mass.cwiseSqrt().cwiseInverse();
  return reference::symmetric_eigenvalues(scale.asDiagonal() * a * scale.asDiagonal());
}

/// Returns the largest natural angular frequency of a network about its initial state [rad/s], from
/// a dense eigensolution; for small networks only.
inline double highest_frequency(const Problem& problem) {
  return std::sqrt(eigenvalues(stiffness_of(problem), problem.mass()).maxCoeff());
}

/// Reference solution on which two solver families agree.
struct Truth {
  Trace solution{};
  double worst_floor = 0.0;  ///< largest difference between the families over the peak [1]
  double l2_floor = 0.0;     ///< root mean square difference between the families
  double agreed_digits = 0.0;
  bool trustworthy = false;  ///< all checks of reference::establish pass
  std::string reason{};      ///< why not
};
struct TruthSettings {
  std::array<std::string, 2> solvers{"arkode-fehlberg-7-8", "cvode-adams"};
  reference::Tolerance tolerance{};
  int rungs = 2;  ///< number of tolerances, each a hundred times smaller
  double demanded_digits = 9.0;
};
inline Truth find_truth(const CaseContext& context, const Problem& problem,
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

/// Judges the agreement and the convergence with tolerance, and describes the comparison.
inline void judge_truth(const Truth& truth, const TruthSettings& settings, Outcome& outcome) {
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

/// Returns the distance from a truth at the same instants; NaN if the motion stopped early.
inline TrajectoryError distance(const Trace& motion, const Trace& truth) {
  return trajectory_error(motion.position, truth.position, truth.position.col(0));
}

inline std::vector<double> row(const Eigen::MatrixXd& matrix, Eigen::Index index) {
  std::vector<double> values;
  for (Eigen::Index n = 0; n < matrix.cols(); ++n) { values.push_back(matrix(index, n)); }
  return values;
}
/// Returns the largest |value|, or NaN if one is not finite (maxCoeff of Eigen may ignore it).
inline double largest_of(const Eigen::Ref<const Eigen::MatrixXd>& values) {
  return values.allFinite() ? values.cwiseAbs().maxCoeff()
                            : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace palpate::networks
