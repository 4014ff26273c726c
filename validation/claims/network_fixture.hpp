// SPDX-License-Identifier: MIT
#pragma once
/// Test fixture of the groups "network" and "patient": small lattices, deterministic random
/// numbers, references from two solver families, and error plots.

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "model/problem/problem.hpp"
#include "model/tissue/lattice.hpp"
#include "reference/solution.hpp"
#include "validation/case.hpp"
#include "validation/number_text.hpp"
#include "validation/random.hpp"
#include "validation/signal.hpp"

namespace palpate::networks {

inline constexpr double epsilon = std::numeric_limits<double>::epsilon();

/// Block of one material, built cell by cell and free on all sides.
struct Block {
  std::array<int, 3> nodes{4, 4, 4};
  double spacing = 5e-3;  ///< [m]
  int connectivity = 26;
  double youngs_modulus = 5e3;  ///< [Pa]
  double poissons_ratio = 0.25;
  double density = 1000.0;      ///< [kg/m^3]
  double relaxation = 0.0;      ///< c / k of every spring [s]: damping proportional to stiffness

  [[nodiscard]] LatticeShape shape() const { return {nodes, spacing, connectivity}; }
};
SpringNetwork block_network(const Block& block);

/// Returns scene_of() with automatic substeps.
Scene automatic_scene(const std::string& integrator, double step, double duration);

void hold(SpringNetwork& network, Face face);
/// Gives every free node a random displacement of up to `amplitude` [m] along each axis.
void displace(SpringNetwork& network, double amplitude, std::uint64_t seed = 1);

/// Returns the network with the planted fault, for claims about a network at rest.
SpringNetwork candidate(const CaseContext& context, SpringNetwork network);

/// Returns the equation of motion of a scene with a network.
NetworkProblem problem_of(const Scene& scene, const SpringNetwork& network);

/// Returns K = -df/dq at the initial state.
Eigen::SparseMatrix<double> stiffness_of(const Problem& problem);
/// Returns the eigenvalues of M^-1 A, ascending.
Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& a, const Eigen::VectorXd& mass);
/// Returns the largest natural angular frequency of a network about its initial state [rad/s], from
/// a dense eigensolution; for small networks only.
double highest_frequency(const Problem& problem);

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
Truth find_truth(const CaseContext& context, const Problem& problem,
                 const std::vector<double>& times, const TruthSettings& settings);
/// Judges the agreement and the convergence with tolerance, and describes the comparison.
void judge_truth(const Truth& truth, const TruthSettings& settings, Outcome& outcome);

/// Returns the distance from a truth at the same instants; NaN if the motion stopped early.
TrajectoryError distance(const Trace& motion, const Trace& truth);

inline std::string text(double value) { return plain_number(value, 3); }
std::vector<double> row(const Eigen::MatrixXd& matrix, Eigen::Index index);
/// Returns the largest |value|, or NaN if one is not finite (maxCoeff of Eigen may ignore it).
double largest_of(const Eigen::Ref<const Eigen::MatrixXd>& values);

}  // namespace palpate::networks
