// SPDX-License-Identifier: MIT

#include "model/problem/scene.hpp"

#include <array>

namespace palpate {

namespace {

constexpr int thickest_gauge = 14;
/// Outer diameters of gauges 14 to 27 [m]: the inches of the Stubs needle scale, rounded to 1 um.
constexpr std::array diameters{2.108e-3, 1.829e-3, 1.651e-3, 1.473e-3, 1.270e-3,
                               1.067e-3, 0.908e-3, 0.819e-3, 0.718e-3, 0.641e-3,
                               0.565e-3, 0.514e-3, 0.464e-3, 0.413e-3};

bool names(const Material& material, std::string_view part) {
  return material.name.find(part) != std::string::npos;
}

}  // namespace

std::optional<double> diameter_of_gauge(int gauge) {
  constexpr int thinnest_gauge = thickest_gauge + static_cast<int>(diameters.size()) - 1;
  if (gauge < thickest_gauge || gauge > thinnest_gauge) { return {}; }
  const int index = gauge - thickest_gauge;
  return diameters[static_cast<std::size_t>(index)];
}

Syringe air_syringe() {
  constexpr double thinner = 55.0;  // water 1.0e-3 Pa s, air 1.8e-5 Pa s
  Syringe air;
  air.compliance = 1.0e-10;  // 10 ml at 101 kPa
  air.thumb_flow *= thinner;
  air.tissue_resistance /= thinner;
  air.epidural_resistance /= thinner;
  air.open_resistance /= thinner;
  return air;
}

TissueRole role_of(const Material& material) {
  if (material.role) { return *material.role; }
  if (names(material, "epidural")) { return TissueRole::epidural_space; }
  if (names(material, "dura")) { return TissueRole::dura; }
  if (names(material, "bone")) { return TissueRole::bone; }
  return TissueRole::tissue;
}

}  // namespace palpate
