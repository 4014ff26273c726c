// SPDX-License-Identifier: MIT
#pragma once
/// Dynamic time warping of two traces within a band.

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace palpate::comparison {

/// Sums over the warping path with the least sum of squared differences, from both first to both
/// last samples, with steps (1,0), (0,1), (1,1) and |i - j| < radius. Among equal predecessors, the
/// one that keeps the sample of the second trace is preferred, then the one that keeps that of the
/// first. Both traces have the same length >= 1 and finite squares. Time and memory (one byte) are
/// proportional to length times (2 radius - 1).
struct WarpSums {
  double difference = 0.0;  ///< sum of |first - second|
  double second = 0.0;      ///< sum of |second|
  std::size_t length = 0;   ///< number of pairs on the path
};
WarpSums warp(std::span<const double> first, std::span<const double> second, std::size_t radius);

// Objective rating of ISO/TS 18571 for a simulated trace and a recorded one, as in published open
// implementations of the standard. It explains a verdict but does not decide it.

struct IsoRating {
  double corridor = 0.0;     ///< Z
  double phase = 0.0;        ///< E_P
  double magnitude = 0.0;    ///< E_M
  double slope = 0.0;        ///< E_S
  double overall = 0.0;      ///< R = 0.4 Z + 0.2 (E_P + E_M + E_S)
  long shift = 0;            ///< lag of the simulated trace [samples]; negative: early
  double correlation = 0.0;  ///< Pearson's, at that shift
  std::string note{};        ///< part that could not be rated and therefore scores 0
};

/// Rates a simulated trace. Both traces have the same length >= 10 and values up to 1e100 (throws
/// InputError otherwise). The standard does not define the phase of a constant and implementations
/// rate it 1; here it is 0 with a note.
IsoRating rate(std::span<const double> simulated, std::span<const double> recorded);

/// Returns "excellent" above 0.94, "good" above 0.80, "fair" above 0.58, else "poor".
std::string_view grade_of(double overall);

}  // namespace palpate::comparison
