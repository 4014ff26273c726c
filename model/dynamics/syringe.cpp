// SPDX-License-Identifier: MIT
#include "model/dynamics/syringe.hpp"

#include <algorithm>
#include <cmath>

namespace palpate {

double outflow_resistance(const Syringe& syringe, bool in_tissue, TissueRole role) noexcept {
  if (!in_tissue) { return syringe.open_resistance; }
  return role == TissueRole::epidural_space ? syringe.epidural_resistance
                                            : syringe.tissue_resistance;
}

void SyringePressure::advance(double h, bool in_tissue, TissueRole role) noexcept {
  const double resistance = outflow_resistance(syringe_, in_tissue, role);
  const double limit = syringe_.thumb_force / syringe_.plunger_area;
  const double reached = syringe_.thumb_flow * resistance;  // where the thumb's flow leads
  const double after =
      reached + (pressure_ - reached) * std::exp(-h / (resistance * syringe_.compliance));
  pressure_ = std::min(after, limit);
}

}  // namespace palpate
