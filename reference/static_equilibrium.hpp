// SPDX-License-Identifier: MIT
#pragma once
/// Static solutions: response of a linearised problem to small forces, for many load cases on one
/// stiffness; equilibrium; a rigid punch on an elastic layer.

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <functional>

#include "model/problem/problem.hpp"
#include "reference/solution.hpp"

namespace palpate::reference {

/// Inverse K^-1 of a stiffness matrix, prepared once. Up to `most_factorised` coordinates it is
/// factorised, with one refinement step for each solution. Above, where the factors of a block
/// would take more than a gigabyte, a symmetric matrix is solved by conjugate gradients to a
/// residual of 1e-10 in at most `most_rounds` iterations.
class StaticResponse {
 public:
  /// Prepares K of the problem at its rest position. Throws SolverError if K is singular, that is,
  /// if the body can move freely; for a large K this may be detected only in a solution.
  explicit StaticResponse(const Problem& problem, Eigen::Index most_factorised = 15000,
                          int most_rounds = 20000);
  explicit StaticResponse(Eigen::SparseMatrix<double> stiffness,
                          Eigen::Index most_factorised = 15000, int most_rounds = 20000);

  /// Returns the displacement K^-1 f [m] under the forces f [N].
  [[nodiscard]] Eigen::VectorXd operator()(const Eigen::VectorXd& force) const {
    return solve_(force);
  }
  /// Returns the compliance w.K^-1 w [m/N]: the displacement of the weighted mean w of coordinates
  /// per force distributed by w.
  [[nodiscard]] double compliance(const Eigen::VectorXd& w) const { return w.dot((*this)(w)); }

 private:
  std::function<Eigen::VectorXd(const Eigen::VectorXd&)> solve_{};
};

// Static equilibrium of a problem: f(t, q, 0) = 0.

struct Equilibrium {
  Eigen::VectorXd position{};  ///< q [m]
  int iterations = 0;
  double residual = 0.0;  ///< largest |f(q)| over the largest |f(start)|
};

struct EquilibriumOptions {
  double time = 0.0;         ///< [s] at which loads are evaluated
  double gate = 0.0;         ///< activation time that selects the active loads [s]
  double tolerance = 1e-12;  ///< on the residual; rounding of the spring forces also suffices
  int iteration_limit = 100;
};

/// Solves for equilibrium by Newton with step halving from `start` (the initial position by
/// default), with sparse LDL^T, or LU if the stiffness is not symmetric and definite. Throws
/// SolverError if it does not converge or if the stiffness is singular (the body can move freely).
Equilibrium static_equilibrium(const Problem& problem, const EquilibriumOptions& options = {});
Equilibrium static_equilibrium(const Problem& problem, const EquilibriumOptions& options,
                               const Eigen::VectorXd& start);

/// Stiffness of a rigid flat punch without friction on an elastic layer that is bonded to a rigid
/// base, over 2 E a / (1 - nu^2) of a half space.
struct PunchFactor {
  double kappa = 1.0;
  double uncertainty = 0.0;  ///< difference from a coarser quadrature
};
/// Solves the Fredholm equation of W. C. Hayes, L. M. Keer, G. Herrmann, L. F. Mockros, J. Biomech.
/// 5, 541, 1972, for nu from 0 to 1/2. Accurate to 1e-6 for radii up to four thicknesses.
PunchFactor punch_on_layer(double radius_over_thickness, double poissons_ratio);

/// Elastic layer, from the punch down.
struct PunchLayer {
  double thickness = 0.0;       ///< [m]
  double youngs_modulus = 0.0;  ///< [Pa]
  double poissons_ratio = 0.0;  ///< below 1/2
};
/// The same for layers that are bonded to each other and to a rigid base, over 2 E a / (1 - nu^2)
/// of the first layer. The radius [m] may be up to twenty thicknesses of that layer.
PunchFactor punch_on_layers(double radius, const std::vector<PunchLayer>& layers);
/// The same for a uniform pressure on a disc, over the mean displacement of the disc.
PunchFactor uniform_pressure_on_layers(double radius, const std::vector<PunchLayer>& layers);

/// Rigid round face whose surface is a paraboloid, as a sphere's near its axis.
struct SphericalFace {
  double radius = 0.0;      ///< of the face [m]
  double tip_radius = 0.0;  ///< of curvature [m]
};
struct SphereForce {
  double force = 0.0;           ///< [N]
  double uncertainty = 0.0;     ///< difference from a coarser quadrature, relative [1]
  double contact_radius = 0.0;  ///< at most that of the face [m]
};
/// Returns the force of such a face without friction at a dent [m], from the equation of Hayes et
/// al. for layers. Their right-hand side is that of a sphere until it touches with its whole face.
SphereForce sphere_on_layers(double dent, const SphericalFace& face,
                             const std::vector<PunchLayer>& layers);

}  // namespace palpate::reference
