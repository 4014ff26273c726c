// SPDX-License-Identifier: MIT
#include "validation/certificate/miss_bound.hpp"

#include <cmath>

#include "tests/check.hpp"

namespace {

using palpate::certificate::miss_probability_upper;

TEST("after no miss the limit is 1 - 0.05^(1/n), some 3/n") {
  CHECK_NEAR(miss_probability_upper(0, 60000), 1.0 - std::pow(0.05, 1.0 / 60000.0), 1e-15);
  CHECK_NEAR(60000.0 * miss_probability_upper(0, 60000), 3.0, 0.01);
  CHECK_NEAR(miss_probability_upper(0, 1), 0.95, 1e-15);
}

TEST("one miss of two has its limit where both missing has the chance 0.95") {
  // P(X <= 1) = 1 - p^2 = 0.05
  CHECK_NEAR(miss_probability_upper(1, 2), std::sqrt(0.95), 1e-12);
}

TEST("more misses mean a higher limit, more ticks a lower one") {
  for (long misses = 0; misses < 50; ++misses) {
    CHECK(miss_probability_upper(misses, 1000) < miss_probability_upper(misses + 1, 1000));
    CHECK(miss_probability_upper(misses, 2000) < miss_probability_upper(misses, 1000));
  }
}

TEST("the limit lies above the share that was seen, for a day at 1 kHz too") {
  for (const long misses : {1L, 10L, 1000L, 1000000L, 86399999L}) {
    const double limit = miss_probability_upper(misses, 86400000);
    CHECK(limit > static_cast<double>(misses) / 86400000.0 && limit <= 1.0);
  }
}

TEST("where all missed, or nothing ran, nothing contradicts a probability of one") {
  CHECK_NEAR(miss_probability_upper(3, 3), 1.0, 0.0);
  CHECK_NEAR(miss_probability_upper(0, 0), 1.0, 0.0);
}

}  // namespace
