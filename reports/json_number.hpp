// SPDX-License-Identifier: MIT
#pragma once
/// JSON has no NaN and no infinity.

#include <cmath>
#include <nlohmann/json.hpp>

namespace palpate {

/// Text says which.
inline nlohmann::ordered_json json_number(double value) {
  if (std::isfinite(value)) { return value; }
  return std::isnan(value) ? "nan" : value > 0.0 ? "inf" : "-inf";
}

/// Null means that there is no limit.
inline nlohmann::ordered_json finite_or_null(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

}  // namespace palpate
