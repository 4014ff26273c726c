// SPDX-License-Identifier: MIT
#pragma once
/// What an extrapolation assumes of excesses over a threshold, each as a number with its limits.

#include <span>
#include <vector>

#include "validation/certificate/tail.hpp"

namespace palpate::certificate {

/// Response times above a threshold, in the order of time.
struct Exceedances {
  double threshold = 0.0;  ///< [s]
  std::vector<LargeTick> ticks{};
  long of = 0;  ///< ticks in all

  [[nodiscard]] std::size_t count() const { return ticks.size(); }
  [[nodiscard]] std::vector<double> excess() const;  ///< [s]
  /// Those of one half of the time.
  [[nodiscard]] Exceedances half(bool second) const;
};

/// The `count` largest of a list with the largest first; the one after them is the threshold.
Exceedances exceedances(std::span<const LargeTick> largest, std::size_t count, long ticks);

/// Ferro & Segers, Journal of the Royal Statistical Society B 65, 2003: 1 where excesses come alone, 1/m
/// where they come in clusters of m.
double extremal_index(const Exceedances& all);

std::vector<TailCheck> independence_checks(const Exceedances& all);
std::vector<TailCheck> stationarity_checks(const Exceedances& all);

}  // namespace palpate::certificate
