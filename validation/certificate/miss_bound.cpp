// SPDX-License-Identifier: MIT
#include "validation/certificate/miss_bound.hpp"

#include <cmath>

#include "validation/comparison/statistics.hpp"

namespace palpate::certificate {

double miss_probability_upper(long misses, long ticks, double confidence) {
  if (ticks <= 0 || misses >= ticks) { return 1.0; }
  if (misses == 0) { return -std::expm1(std::log1p(-confidence) / static_cast<double>(ticks)); }
  const double two_sided = 2.0 * confidence - 1.0;
  return comparison::share_interval(static_cast<std::size_t>(misses), static_cast<std::size_t>(ticks),
                                    two_sided)
      .upper;
}

}  // namespace palpate::certificate
