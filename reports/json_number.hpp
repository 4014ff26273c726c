// SPDX-License-Identifier: MIT
#pragma once
/// JSON has no NaN and no infinity: text says which.

#include <cmath>
#include <nlohmann/json.hpp>

namespace palpate {

inline nlohmann::ordered_json json_number(double value) {
  if (std::isfinite(value)) { return value; }
  return std::isnan(value) ? "nan" : value > 0.0 ? "inf" : "-inf";
}

}  // namespace palpate
