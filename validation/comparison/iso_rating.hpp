// SPDX-License-Identifier: MIT
#pragma once
/// Dynamic time warping within a band: which samples of two traces answer each other.

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace palpate::comparison {

/// Sums over the path from both first to both last samples that has the least sum of squared
/// differences, among paths of steps (1,0), (0,1), (1,1) with |i - j| < radius. Of equal
/// predecessors, the one that keeps the second trace's sample is taken first, then the one that
/// keeps the first's. Both are of equal length, at least 1, and their squares are numbers. Time and
/// memory (one byte) go with length times (2 radius - 1).
struct WarpSums {
  double difference = 0.0;  ///< sum of |first - second|
  double second = 0.0;      ///< sum of |second|
  std::size_t length = 0;   ///< pairs on the path
};
WarpSums warp(std::span<const double> first, std::span<const double> second, std::size_t radius);

// The objective rating of ISO/TS 18571 for a simulated trace against a recorded one, as published
// open implementations of the standard read it. It explains a verdict and never makes one.

/// Constants of ISO/TS 18571.
struct IsoRule {
  double inner_corridor = 0.05;  ///< half-width over the largest |recorded|: score 1 inside
  double outer_corridor = 0.50;  ///< likewise: score 0 outside, squared distance between
  double largest_shift = 0.20;   ///< of the samples; phase score 0 there, linear to 1 at no shift
  double warp_window = 0.10;     ///< of the samples left after the shift
  double zero_magnitude = 0.50;  ///< warped error over warped recorded values that scores 0
  double zero_slope = 2.0;       ///< error of slopes over recorded slopes that scores 0
};

struct IsoRating {
  double corridor = 0.0;     ///< Z
  double phase = 0.0;        ///< E_P
  double magnitude = 0.0;    ///< E_M
  double slope = 0.0;        ///< E_S
  double overall = 0.0;      ///< R = 0.4 Z + 0.2 (E_P + E_M + E_S)
  long shift = 0;            ///< samples by which the simulated trace is late; negative: early
  double correlation = 0.0;  ///< Pearson's, at that shift
  std::string note{};        ///< what could not be rated and scores 0 therefore
};

/// Both of one length, at least 10, and numbers up to 1e100 (throws InputError otherwise). The
/// standard leaves the phase of a constant open and implementations rate it 1: it is 0 here, with a
/// note.
IsoRating rate(std::span<const double> simulated, std::span<const double> recorded,
               const IsoRule& rule = {});

/// "excellent" above 0.94, "good" above 0.80, "fair" above 0.58, "poor".
std::string_view grade_of(double overall);

}  // namespace palpate::comparison
