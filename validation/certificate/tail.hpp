// SPDX-License-Identifier: MIT
#pragma once
/// How long ticks may take that were not seen: peaks over a threshold and a generalised Pareto distribution,
/// told only where what the method assumes was not contradicted (Cazorla et al., OASIcs.WCET.2013.64, on
/// why).

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "validation/certificate/loop_record.hpp"
#include "validation/certificate/pareto_tail.hpp"

namespace palpate::certificate {

/// One assumption: a number that must lie within limits.
struct TailCheck {
  std::string name{};   ///< "independence-in-time"
  std::string claim{};  ///< what must hold, in words
  double value = 0.0;
  double lower = 0.0;
  double upper = 0.0;

  [[nodiscard]] bool holds() const { return value >= lower && value <= upper; }
};

/// A fit above one threshold [s].
struct ThresholdFit {
  double threshold = 0.0;
  ParetoFit fit{};
};

/// The response time that one tick in 1 / probability exceeds [s].
struct ReturnLevel {
  double probability = 0.0;
  double value = 0.0;
  double lower = 0.0;  ///< at 95 %
  double upper = 0.0;
};

struct Tail {
  std::string refusal{};  ///< empty: the levels may be told
  std::vector<TailCheck> checks{};
  std::vector<ThresholdFit> fits{};   ///< lowest threshold first; the levels are from that
  std::vector<ReturnLevel> levels{};  ///< one and two decades beyond the data
  /// That a response exceeds the deadline; empty where that is rarer than one in a hundred times the ticks
  /// that were seen, about which nothing is said.
  std::optional<double> beyond_deadline{};
};

/// Fewest ticks with which there is any answer: three thresholds, 50 excesses over the highest.
inline constexpr long least_ticks_of_tail = 4000;
/// Of each check, that it contradicts what is true.
inline constexpr double false_alarm = 1e-3;

/// Of the largest responses of `ticks` ticks, largest first.
Tail judge_tail(std::span<const LargeTick> largest, long ticks, double deadline);

}  // namespace palpate::certificate
