// SPDX-License-Identifier: MIT
#pragma once
/// Dynamic time warping within a band: which samples of two traces answer each other.

#include <cstddef>
#include <span>

namespace palpate::comparison {

/// Sums over the path from both first to both last samples that has the least sum of squared differences,
/// among paths of steps (1,0), (0,1), (1,1) with |i - j| < radius. Of equal predecessors, the one that keeps
/// the second trace's sample is taken first, then the one that keeps the first's. Both are of equal length,
/// at least 1, and their squares are numbers. Time and memory (one byte) go with length times (2 radius - 1).
struct WarpSums {
  double difference = 0.0;  ///< sum of |first - second|
  double second = 0.0;      ///< sum of |second|
  std::size_t length = 0;   ///< pairs on the path
};
WarpSums warp(std::span<const double> first, std::span<const double> second, std::size_t radius);

}  // namespace palpate::comparison
