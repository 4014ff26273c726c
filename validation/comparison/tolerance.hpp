// SPDX-License-Identifier: MIT
#pragma once
/// How far a simulated feature may be from a recorded one, and who says so.

#include <string>
#include <vector>

#include "validation/comparison/features.hpp"

namespace palpate::comparison {

/// What is compared: saline pressure [Pa], or force along the needle [N].
enum class QuantityKind { pressure, force };
std::string_view unit_of(QuantityKind kind);  ///< "Pa", "N"
std::string_view name_of(QuantityKind kind);  ///< "pressure", "force"

/// Allowed is D - a to D + a with a = absolute + relative |D|; with a factor f > 1, D / f to D f instead.
struct Tolerance {
  Feature feature{};
  double absolute = 0.0;  ///< in the feature's unit
  double relative = 0.0;
  double factor = 0.0;
  std::string origin{};   ///< publication, or "assumption: ..."

  [[nodiscard]] double lower(double recorded) const;
  [[nodiscard]] double upper(double recorded) const;
};

/// One for every feature, in their order.
std::vector<Tolerance> default_tolerances(QuantityKind kind);

}  // namespace palpate::comparison
