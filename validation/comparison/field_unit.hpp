// SPDX-License-Identifier: MIT
#pragma once
/// Features in the units that clinicians read: mmHg and mm.

#include <string>
#include <string_view>

#include "model/dynamics/pressure_units.hpp"

namespace palpate::comparison {

struct FieldUnit {
  double factor = 1.0;  ///< value in this unit over value in SI
  std::string name{};
};

/// Of "Pa", "Pa/s" and "m"; every other unit stays as it is.
inline FieldUnit field_unit(std::string_view unit) {
  if (unit == "Pa") { return {1.0 / pascals_per_mmhg, "mmHg"}; }
  if (unit == "Pa/s") { return {1.0 / pascals_per_mmhg, "mmHg/s"}; }
  if (unit == "m") { return {1e3, "mm"}; }
  return {1.0, std::string(unit)};
}

}  // namespace palpate::comparison
