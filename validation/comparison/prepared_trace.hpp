// SPDX-License-Identifier: MIT
#pragma once
/// One trace made ready to be compared: on a uniform grid, filtered, its features found, or refused.

#include <span>
#include <string>

#include "validation/comparison/features.hpp"

namespace palpate::comparison {

struct RawTrace {
  std::span<const double> time{};   ///< [s]
  std::span<const double> value{};  ///< [Pa or N]
  std::span<const double> depth{};  ///< [m], or empty
};

struct PreparedTrace {
  FeatureInput input{};
  Features features{};
  std::string refusal{};  ///< why there is nothing to compare; empty: there is
};

/// Why a trace cannot be compared: empty, one sample, times that do not increase, no number, a constant,
/// or more than ten million of its usual intervals. Empty when it can.
std::string refusal_of(const RawTrace& trace);

PreparedTrace prepare(const RawTrace& trace, double cutoff, const FeatureRule& rule);

}  // namespace palpate::comparison
