// SPDX-License-Identifier: MIT
#pragma once
/// Compliance that a grid lacks under a tool that is smaller than its cells (model/EQUATIONS.md,
/// "Contact of a size").

#include <Eigen/Core>
#include <array>
#include <vector>

#include "model/problem/needle_path.hpp"

namespace palpate {

/// Laterally unbounded layer of tissue.
struct ColumnLayer {
  double thickness = 0.0;        ///< [m]
  double youngs_modulus = 0.0;   ///< E [Pa]
  double poissons_ratio = 0.25;  ///< nu [1]
};

/// Returns the axial displacement per unit of axial force [m/N] at each depth [m] of layers that
/// are bonded to each other and to a rigid base. The force has the pressure of a rigid flat punch,
/// p ~ 1 / sqrt(radius^2 - r^2), and the displacement is its mean with the same weight. Exact but
/// for quadrature (stiffness matrices of layers: E. Kausel, J. M. Roesset, Bull. Seism. Soc. Am.
/// 71, 1743, 1981). Depths at or below the base give zero.
std::vector<double> continuum_compliance(const std::vector<ColumnLayer>& layers, double radius,
                                         const std::vector<double>& depths);

/// Returns the dents [m] of the same layers under ascending forces [N] on top of the layer
/// `pressed`, in large deformation. The layers are neo-Hookean. Returns an empty list if the tip
/// finds no equilibrium.
std::vector<double> large_dents(const std::vector<ColumnLayer>& layers, std::size_t pressed,
                                double radius, const std::vector<double>& forces);

/// Returns the orders of the terms of a face's pressure, in the order of FacePressure: {n, 0} is
/// the Legendre polynomial P_2n of a disc, {m, n} the product T_2m(x) T_2n(y) of Chebyshev
/// polynomials of a rectangle, both times the pressure of a flat punch (model/EQUATIONS.md,
/// "Contact of a size"). The first term is the flat punch's; it alone has a force. A uniform
/// pressure is the only term of its face.
std::vector<std::array<int, 2>> face_terms(const Probe& probe);

/// Axial compliance of a probe's face on layers [m/N]. An entry is the mean displacement with the
/// weight of one term of the pressure under the force of another.
struct FaceCompliance {
  Eigen::MatrixXd terms{};

  /// Returns the pressure of unit force with which the face is stiffest, or the only term. A rigid
  /// face is stiffer than any given pressure (minimum of the complementary energy).
  [[nodiscard]] FacePressure best_pressure() const;
  [[nodiscard]] double at(const FacePressure& pressure) const;
};
FaceCompliance face_compliance(const std::vector<ColumnLayer>& layers, const Probe& probe);

/// Returns the forces and dents of layers under a fingertip with a tip_radius, without gaps: from
/// no contact over ascending contact radii to that of the whole face, then as a flat punch.
DentTable sphere_dents(const std::vector<ColumnLayer>& layers, const Probe& probe);

/// Returns the points of a probe's face for nodes with these distances [m].
std::vector<ProbeFace::Point> face_points(const Probe& probe, const FacePressure& pressure,
                                          const Eigen::Vector2d& spacing);

/// Returns the layers of soft tissue along a line between two depths [m], to the first gap. `slope`
/// is the z component of the line's direction.
std::vector<ColumnLayer> layers_between(const std::vector<PathInterval>& tissue, double begin,
                                        double end, double slope);
/// Returns the depth at which bone begins [m]; infinite without bone.
double bone_depth(const std::vector<PathInterval>& tissue);

/// Laterally unbounded grid of springs and cells on a rigid base.
struct GridColumn {
  Eigen::Vector3d spacing{0.0, 0.0, 0.0};  ///< [m]
  int connectivity = 26;
  /// Layers of cells from the surface down; each has the thickness spacing.z().
  std::vector<double> spring_modulus{};  ///< Young's modulus of the springs [Pa]
  std::vector<double> volume_modulus{};  ///< kappa of the cells [Pa]
};
/// Share of a force on a node of a plane, at a place relative to the tool's axis.
struct PlaneSupport {
  Eigen::Vector2d place{0.0, 0.0};  ///< [m]
  double weight = 0.0;
};

/// Entries of the compliance matrix of the planes of a grid [m/N].
struct PlaneCompliance {
  double own = 0.0;   ///< mean displacement of a plane under a unit force on it
  double next = 0.0;  ///< of the next plane under that force
};
/// Returns the axial compliance of each plane for a force that `supports` share, one list for each
/// plane above the base. Computed for a grid that repeats after many cells.
std::vector<PlaneCompliance> grid_compliance(
    const GridColumn& grid, const std::vector<std::vector<PlaneSupport>>& supports);

}  // namespace palpate
