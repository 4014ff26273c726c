// SPDX-License-Identifier: MIT
#pragma once
/// Slow creep that no single comparison sees: a series of runs whose level has changed somewhere.

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace palpate::timing {

/// Where a series changes its level, and how seldom chance alone does as much: Pettitt, Applied Statistics 28 (1979),
/// K = max |sum of sign(x_j - x_i), i <= t < j|, p = 2 exp(-6 K^2 / (n^3 + n^2)), which for few values says more than
/// the true chance. Ranks alone count: no scale, no law of the noise.
struct ChangePoint {
  std::size_t at = 0;   ///< first value of the new level
  double chance = 1.0;  ///< p, at most 1
  double before = 0.0;  ///< median
  double after = 0.0;   ///< median
};
/// Nothing for fewer than two values.
std::optional<ChangePoint> find_change(std::span<const double> values);

/// A series of runs, oldest first.
struct Trend {
  std::string name{};
  std::string unit{};
  std::vector<double> values{};
  std::optional<ChangePoint> change{};
  bool crept = false;
};

/// Chance of one false alarm or more in all series together, where nothing changes (Holm, Scandinavian Journal of
/// Statistics 6, 1979).
inline constexpr double false_alarm_rate = 0.01;
/// A change that matters: more than one comparison lets pass. Digits are told as they are.
inline constexpr double least_growth = 1.01;
inline constexpr double least_loss_of_digits = 0.1;

/// Fills in changes, and marks those that are no chance, no trifle, and for the worse: more of what is counted, fewer
/// digits.
void find_creep(std::vector<Trend>& trends);

}  // namespace palpate::timing
