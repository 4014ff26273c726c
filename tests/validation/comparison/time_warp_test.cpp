// SPDX-License-Identifier: MIT
#include "validation/comparison/time_warp.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "device/seeded.hpp"
#include "tests/check.hpp"

namespace {

using namespace palpate::comparison;

/// Least sum of squares over every path within the band, by trying them all.
double least_square(const std::vector<double>& a, const std::vector<double>& b, long i, long j, long radius) {
  if (i < 0 || j < 0 || std::abs(i - j) >= radius) { return std::numeric_limits<double>::infinity(); }
  const double d = a[static_cast<std::size_t>(i)] - b[static_cast<std::size_t>(j)];
  if (i == 0 && j == 0) { return d * d; }
  return d * d + std::min({least_square(a, b, i - 1, j, radius), least_square(a, b, i, j - 1, radius),
                           least_square(a, b, i - 1, j - 1, radius)});
}

TEST("equal traces answer each other sample by sample") {
  const std::vector<double> trace{0.0, 2.0, -1.0, 4.0, 4.0};
  const WarpSums sums = warp(trace, trace, 3);
  CHECK(sums.difference == 0.0);
  CHECK(sums.length >= trace.size());
}

TEST("the path is the best one of all within its band") {
  palpate::device::Seeded seeded(3);
  for (int trial = 0; trial < 40; ++trial) {
    std::vector<double> a;
    std::vector<double> b;
    // Values 0 or 1: squared and absolute differences are the same number, so the sums can be compared.
    for (int n = 0; n < 7; ++n) {
      a.push_back(seeded.uniform(0.0, 1.0) < 0.5 ? 0.0 : 1.0);
      b.push_back(seeded.uniform(0.0, 1.0) < 0.5 ? 0.0 : 1.0);
    }
    for (const std::size_t radius : {1UL, 2UL, 4UL, 7UL}) {
      CHECK_NEAR(warp(a, b, radius).difference, least_square(a, b, 6, 6, static_cast<long>(radius)), 0.0);
    }
  }
}

TEST("a delay within the band costs nothing, one beyond it does") {
  std::vector<double> early(60, 0.0);
  std::vector<double> late(60, 0.0);
  early[20] = 1.0;
  late[25] = 1.0;
  CHECK(warp(late, early, 6).difference == 0.0);   // |i - j| = 5 < 6
  CHECK(warp(late, early, 5).difference == 2.0);   // the pulses cannot meet: both stand alone
}

TEST("a band of one sample compares instant by instant") {
  const std::vector<double> a{1.0, 5.0, 2.0};
  const std::vector<double> b{1.0, 2.0, 4.0};
  const WarpSums sums = warp(a, b, 1);
  CHECK_NEAR(sums.difference, 5.0, 0.0);
  CHECK_NEAR(sums.second, 7.0, 0.0);
  CHECK(sums.length == 3);
}

}  // namespace
