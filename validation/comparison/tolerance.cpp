// SPDX-License-Identifier: MIT
#include "validation/comparison/tolerance.hpp"

#include <cmath>

#include "model/dynamics/pressure_units.hpp"

namespace palpate::comparison {

std::string_view unit_of(QuantityKind kind) { return kind == QuantityKind::pressure ? "Pa" : "N"; }
std::string_view name_of(QuantityKind kind) { return kind == QuantityKind::pressure ? "pressure" : "force"; }

double Tolerance::lower(double recorded) const {
  return factor > 1.0 ? recorded / factor : recorded - absolute - relative * std::abs(recorded);
}

double Tolerance::upper(double recorded) const {
  return factor > 1.0 ? recorded * factor : recorded + absolute + relative * std::abs(recorded);
}

std::vector<Tolerance> default_tolerances(QuantityKind kind) {
  const std::string groups =
      "Wee et al. 2017: means of four groups, 376 to 461 mmHg, lie within 10.2 % of their "
      "middle and were not told apart (p = 0.52)";
  const std::string depth = "Segal et al. 1996: depth is predicted to within 8 mm";
  const std::string time = "assumption: half a second, felt as the same moment of an insertion";
  const Tolerance plateau =
      kind == QuantityKind::pressure
          ? Tolerance{.feature = Feature::plateau,
                      .absolute = 7.0 * pascals_per_mmhg,
                      .origin =
                          "Kim et al. 1996: epidural pressure of pregnant women sitting has an SD of 7 mmHg"}
          : Tolerance{.feature = Feature::plateau,
                      .absolute = 0.5,
                      .origin = "assumption: no publication gives it"};
  constexpr double of_groups = (461.0 - 376.0) / (461.0 + 376.0);
  return {
      {.feature = Feature::loss_of_resistance, .origin = "both show it, or neither"},
      {.feature = Feature::peak, .relative = of_groups, .origin = groups},
      {.feature = Feature::drop_height, .relative = of_groups, .origin = groups + ", as of the peak"},
      {.feature = Feature::relative_drop, .absolute = 0.20,
       .origin = "Vaira et al. 2019: half the way from false (33 %) to true losses (73 %)"},
      {.feature = Feature::drop_time, .factor = 2.0,
       .origin = "assumption: falls take 50 to 200 ms, a factor of two about 100 ms"},
      plateau,
      {.feature = Feature::slope_before,
       .absolute = kind == QuantityKind::pressure ? 5.0 * pascals_per_mmhg : 0.1,
       .relative = 0.30, .origin = "assumption: no publication gives it"},
      {.feature = Feature::time_of_peak, .absolute = 0.5, .origin = time},
      {.feature = Feature::time_of_loss, .absolute = 0.5, .origin = time},
      {.feature = Feature::depth_of_peak, .absolute = 8e-3, .origin = depth},
      {.feature = Feature::depth_of_loss, .absolute = 8e-3, .origin = depth},
  };
}

}  // namespace palpate::comparison
