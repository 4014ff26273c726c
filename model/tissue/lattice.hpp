// SPDX-License-Identifier: MIT
#pragma once
/// Lattices and grids built cell by cell (model/EQUATIONS.md, "Material to springs", "Springs of a
/// box").

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <span>

#include "model/problem/scene.hpp"
#include "model/problem/spring_network.hpp"
#include "model/tissue/grid.hpp"

namespace palpate {

/// Material of one cell.
struct CellMaterial {
  double youngs_modulus = 0.0;        ///< E [Pa]
  double density = 0.0;               ///< [kg/m^3]
  double damping_ratio = 0.0;         ///< [1]
  std::optional<double> viscosity{};  ///< per spring, overrides damping_ratio [N s/m]
  double poissons_ratio = 0.25;       ///< nu [1]
  /// tau [s], overrides damping_ratio.
  std::optional<double> retardation_time{};
  MaterialLaw law{};  ///< stiffening and relaxation

  /// Returns the Young's modulus of the springs, 5/2 mu [Pa]: their nu is 1/4.
  [[nodiscard]] double spring_modulus() const {
    return poissons_ratio == 0.25 ? youngs_modulus : 1.25 * youngs_modulus / (1.0 + poissons_ratio);
  }
  /// Returns kappa = lambda - mu, the modulus of the cell's volume [Pa].
  [[nodiscard]] double volume_modulus() const {
    return 0.4 * spring_modulus() * (4.0 * poissons_ratio - 1.0) / (1.0 - 2.0 * poissons_ratio);
  }
  /// Sets E and nu from the moduli of springs and volume.
  void set_moduli(double spring, double volume);
};

/// Sum of materials that share a cell, weighted by their part of it.
class MaterialMean {
 public:
  void add(double part, const CellMaterial& material);
  [[nodiscard]] double parts() const { return parts_; }
  [[nodiscard]] CellMaterial mean() const;

 private:
  double parts_ = 0.0;
  CellMaterial sum_{};  ///< density and damping ratio only
  double spring_ = 0.0;
  double volume_ = 0.0;
  double viscosity_ = 0.0;
  double viscous_ = 0.0;    ///< part with a viscosity per spring
  double retarded_ = 0.0;   ///< sum of modulus times tau
  double strongest_ = 0.0;  ///< largest part of the spring modulus; its law is that of the mean
  MaterialLaw law_{};
  bool has_time_ = false;
};

/// Sum over the cells of a bond whose materials have one law; damping is their mean weighted by
/// stiffness.
struct BondSum {
  double stiffness = 0.0;
  double damping_ratio_sum = 0.0;  ///< weighted by stiffness
  double viscosity_sum = 0.0;      ///< weighted by stiffness
  double retarded = 0.0;           ///< stiffness times retardation time [N s/m]

  void add(double share, const CellMaterial& material) {
    stiffness += share;
    if (material.retardation_time) {
      retarded += share * *material.retardation_time;
    } else if (material.viscosity) {
      viscosity_sum += share * *material.viscosity;
    } else {
      damping_ratio_sum += share * material.damping_ratio;
    }
  }
  /// Returns the viscosity between nodes of these masses [kg] in [N s/m].
  [[nodiscard]] double viscosity(double mass_a, double mass_b) const {
    const double reduced_mass = mass_a * mass_b / (mass_a + mass_b);
    const double critical = 2.0 * std::sqrt(stiffness * reduced_mass);
    return (damping_ratio_sum * critical + viscosity_sum) / stiffness + retarded;
  }
};

/// Returns an empty list of springs for a lattice with nodes at `position`.
SpringList springs_of_lattice(const LatticeShape& shape, const NodeVectors& position);

/// Adds the lattice structure to a network that is a regular lattice to rounding error.
void recognise_lattice(SpringNetwork& network);

/// Returns the offsets (i, j, l) of the neighbours with a higher index: 3, 9 or 13 of them.
std::span<const std::array<int, 3>> bond_directions(int connectivity);

/// Builds a lattice from its cells: k1/4 of each for its edges, k2/2 for its face diagonals, k3 for
/// its body diagonals and an eighth of its mass for each corner. cell(i, j, l) is called once per
/// cell.
SpringNetwork cell_lattice(const LatticeShape& shape,
                           const std::function<CellMaterial(int, int, int)>& cell);

/// Builds a lattice with the same stiffness, viscosity and node mass everywhere.
SpringNetwork uniform_lattice(const LatticeShape& shape, double stiffness, double viscosity,
                              double node_mass);

struct NodeGrid;  // tissue_grid.hpp

/// Builds the network of the existing nodes of a grid. Each bond is the sum over the cells around
/// it (model/EQUATIONS.md, "Material to springs", "Springs of a box"). cell(i, j, l, a, b) returns
/// the material of a cell for the bond between network nodes a and b, or null if the cell is empty;
/// with a == b the material is used for the mass of that node. No node may be without mass.
SpringNetwork grid_network(const NodeGrid& nodes, int connectivity,
                           const std::function<const CellMaterial*(int, int, int, int, int)>& cell);

/// Stiffness of complete bonds per unit of Young's modulus [m], in the order of bond_directions().
struct BoxBonds {
  std::array<double, 13> stiffness{};
  /// C_nn and C_nm of axes n, m per unit of E [1].
  Eigen::Matrix3d elasticity = Eigen::Matrix3d::Zero();

  /// Returns the Young's moduli of the homogenised grid along its axes per unit of E [1].
  [[nodiscard]] Eigen::Vector3d youngs_moduli() const;
};

/// Computes the bonds of a box with these edges [m], for cubes those of bond_stiffness(). The grid
/// is isotropic (nu = 1/4) if non-negative constants allow it: for 26 neighbours up to an edge
/// ratio of about 1.7; beyond that, they minimise the least-squares error of C_nm. 6 neighbours
/// give C_nn = E and no shear stiffness.
BoxBonds box_bonds(const Eigen::Vector3d& size, int connectivity);

}  // namespace palpate
