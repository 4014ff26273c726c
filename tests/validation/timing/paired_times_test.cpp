// SPDX-License-Identifier: MIT
#include "validation/timing/paired_times.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tests/check.hpp"
#include "validation/random.hpp"

namespace {

using namespace palpate;
using namespace palpate::timing;

std::vector<double> one_to(int n) {
  std::vector<double> values(static_cast<std::size_t>(n));
  std::iota(values.begin(), values.end(), 1.0);
  return values;
}

/// Pairs whose times have a heavy tail, as on a busy machine: every tenth batch of either build takes up to five
/// times as long.
std::vector<PairedStart> noisy_starts(double ratio, std::uint64_t seed) {
  Random random(seed);
  std::vector<PairedStart> starts(12, PairedStart{.batch_deadline = 1.0});
  for (PairedStart& start : starts) {
    for (int n = 0; n < 40; ++n) {
      const auto time = [&] {
        const double slow = random(0.0, 1.0) < 0.1 ? random(1.0, 5.0) : 1.0;
        return 1e-3 * slow * random(0.97, 1.03);
      };
      start.pairs.push_back({.base = time(), .head = ratio * time()});
    }
  }
  return starts;
}

TEST("limits of the median are the order statistics of the binomial table") {
  // Table of the sign test, one-sided 0.01: n = 7 gives the first, n = 20 the fifth, n = 40 the thirteenth value.
  const auto limits = [](int n) { return median_limits(one_to(n), 0.99); };
  CHECK_NEAR(limits(7).lower, 1.0, 0.0);
  CHECK_NEAR(limits(20).lower, 5.0, 0.0);
  CHECK_NEAR(limits(40).lower, 13.0, 0.0);
  CHECK_NEAR(limits(40).upper, 28.0, 0.0);
  CHECK_NEAR(limits(40).median, 20.5, 0.0);
  CHECK_NEAR(limits(7).median, 4.0, 0.0);
}

TEST("six values support no limit with 99 %") {
  const MedianLimits limits = median_limits(one_to(6), 0.99);
  CHECK(std::isinf(limits.lower) && limits.lower < 0.0 && std::isinf(limits.upper));
}

TEST("the lower limit lies above the true median in one per cent of samples, whatever their law") {
  Random random(3);
  int above = 0;
  constexpr int trials = 4000;
  for (int trial = 0; trial < trials; ++trial) {
    std::vector<double> values;
    for (int n = 0; n < 40; ++n) { values.push_back(std::pow(random(0.0, 1.0), 8.0)); }  // median 2^-8
    above += median_limits(values, 0.99).lower > std::pow(2.0, -8.0) ? 1 : 0;
  }
  // P(Bin(40, 1/2) < 13) = 0.0083; three standard deviations of 4000 trials are 0.0043.
  CHECK_NEAR(static_cast<double>(above) / trials, 0.0083, 0.0043);
}

TEST("equal builds are never called slower on a busy machine, and five per cent always are") {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    CHECK(!judge_pairs(noisy_starts(1.0, seed)).slower());
    CHECK(judge_pairs(noisy_starts(1.05, seed)).slower());
  }
}

TEST("who waits for others is late, and no slower") {
  std::vector<PairedStart> starts = noisy_starts(1.0, 5);
  for (PairedStart& start : starts) {
    start.batch_deadline = 0.01;
    for (Pair& pair : start.pairs) {
      pair.base_wall = pair.base;
      pair.head_wall = pair.head + 0.02;
    }
  }
  const PairedVerdict verdict = judge_pairs(starts);
  CHECK(!verdict.slower() && verdict.base_misses == 0 && verdict.head_misses == 480 && verdict.misses_rose());
}

TEST("the ratio is the median's") {
  const PairedVerdict verdict = judge_pairs(noisy_starts(1.05, 7));
  CHECK_NEAR(verdict.ratio, 1.05, 0.01);
  CHECK(verdict.lower < verdict.ratio && verdict.ratio < verdict.upper && verdict.pairs == 480);
}

TEST("misses rise when chance would split them so unevenly once in a hundred times") {
  const auto rose = [](long base, long head) {
    return PairedVerdict{.base_misses = base, .head_misses = head}.misses_rose();
  };
  CHECK(!rose(0, 0) && !rose(0, 6) && !rose(5, 5) && !rose(9, 0));
  CHECK(rose(0, 7));  // 2^-7 < 0.01
  CHECK(rose(10, 30) && !rose(15, 25));
}

TEST("nothing measured is not passed") { CHECK(judge_pairs({}).slower()); }

TEST("what decides nothing is measured on, and no further than that") {
  // Limits of 480 pairs that scatter by this much lie a few per cent from the median: closer than 5, wider than 2.
  const auto starts_for = [](double ratio, double scatter) {
    return starts_until_decided(12, [&](int n) {
      Random random(static_cast<std::uint64_t>(n) + 1);
      PairedStart start{.batch_deadline = 1.0};
      for (int pair = 0; pair < 40; ++pair) {
        start.pairs.push_back({.base = 1e-3, .head = 1e-3 * ratio * random(1.0 - scatter, 1.0 + scatter)});
      }
      return start;
    });
  };
  CHECK(starts_for(1.0, 0.03).size() == 12);   // below
  CHECK(starts_for(1.05, 0.03).size() == 12);  // above
  CHECK(starts_for(1.05, 0.2).size() > 12);
  CHECK(judge_pairs(starts_for(1.05, 0.2)).slower());
  CHECK(starts_for(1.03, 0.2).size() == 12 * most_looks);  // on the limit itself
}

}  // namespace
