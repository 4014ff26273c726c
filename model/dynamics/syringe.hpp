// SPDX-License-Identifier: MIT
#pragma once
/// Pressure of the fluid behind the needle's tip (model/EQUATIONS.md, "Syringe").

#include "model/dynamics/scene.hpp"

namespace palpate {

class SyringePressure {
 public:
  explicit SyringePressure(const Syringe& syringe) : syringe_(syringe) {}

  /// h seconds on, with the tip in open air or in tissue of this role; exact for constant outflow.
  void advance(double h, bool in_tissue, TissueRole role) noexcept;
  [[nodiscard]] double pressure() const noexcept { return pressure_; }  ///< gauge [Pa]
  [[nodiscard]] double thumb() const noexcept { return pressure_ * syringe_.plunger_area; }  ///< [N]

 private:
  Syringe syringe_;
  double pressure_ = 0.0;
};

/// R [Pa s/m^3] where the tip is.
double outflow_resistance(const Syringe& syringe, bool in_tissue, TissueRole role) noexcept;

}  // namespace palpate
