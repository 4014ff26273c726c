// SPDX-License-Identifier: MIT
#pragma once
/// Cuts a time axis at the instants where a load switches. Within a segment the right-hand side is
/// smooth, so a method keeps its order; across one it would not, or would step over the load.

#include <cstddef>
#include <optional>
#include <vector>

#include "model/dynamics/problem.hpp"

namespace palpate::reference {

/// Every segment is at least this many steps, so steps >= breaks + 10 holds by construction.
inline constexpr int steps_per_segment = 10;

/// An instant that a solver must hit exactly.
struct Stop {
  double time = 0.0;                    ///< [s]
  std::optional<std::size_t> output{};  ///< index of the requested time that is stored here
};

struct Segment {
  double start = 0.0;         ///< [s] a break, or 0
  double end = 0.0;           ///< [s] the next break, or the last requested time
  double gate = 0.0;          ///< [s] midpoint: decides which loads are on
  double max_step = 0.0;      ///< [s] <= shortest feature / 4 and <= (end - start) / 10
  std::vector<Stop> stops{};  ///< ascending; the last one is `end`
};

/// times: strictly ascending from 0, otherwise SolverError. A requested time within rounding of a
/// break is the break. Empty for the single time 0.
std::vector<Segment> segments_of(const Problem& problem, const std::vector<double>& times);

}  // namespace palpate::reference
