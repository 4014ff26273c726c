// SPDX-License-Identifier: MIT
#pragma once
/// What the cells around a bond add up to (model/EQUATIONS.md, "Material to springs").

#include <cmath>
#include <optional>

namespace palpate {

/// What fills one cell.
struct CellMaterial {
  double youngs_modulus = 0.0;        ///< [Pa]
  double density = 0.0;               ///< [kg/m^3]
  double damping_ratio = 0.0;         ///< [1]
  std::optional<double> viscosity{};  ///< [N s/m] per spring; wins over damping_ratio
};

/// Stiffness adds up; damping is the mean of the cells' by what they bring of the stiffness.
struct BondSum {
  double stiffness = 0.0;
  double damping_ratio_sum = 0.0;  ///< weighted by stiffness
  double viscosity_sum = 0.0;      ///< weighted by stiffness

  void add(double share, const CellMaterial& material) {
    stiffness += share;
    if (material.viscosity) {
      viscosity_sum += share * *material.viscosity;
    } else {
      damping_ratio_sum += share * material.damping_ratio;
    }
  }
  /// [N s/m] between nodes of these masses [kg]
  [[nodiscard]] double viscosity(double mass_a, double mass_b) const {
    const double reduced_mass = mass_a * mass_b / (mass_a + mass_b);
    const double critical = 2.0 * std::sqrt(stiffness * reduced_mass);
    return (damping_ratio_sum * critical + viscosity_sum) / stiffness;
  }
};

}  // namespace palpate
