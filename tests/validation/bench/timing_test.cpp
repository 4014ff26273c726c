// SPDX-License-Identifier: MIT

#include "validation/bench/timing.hpp"

#include <limits>
#include <numeric>

#include "tests/check.hpp"
#include "validation/random.hpp"

namespace PALPATE_FILE {

using namespace palpate::bench;
using namespace palpate::timing;
using namespace palpate;

/// Work in proportion to `amount` that an optimiser cannot remove.
void work(long amount) {
  volatile double x = 1.0;
  for (long n = 0; n < amount; ++n) { x = std::sqrt(x + 1.0); }
}

TEST("eight times the work takes many times as long, and every contender has every round") {
  int calls[] = {0, 0};
  const auto contender = [&](const char* name, int& count, long amount) {
    return Contender{name, [&count, amount](long times) {
                       ++count;
                       work(amount * times);
                     }};
  };
  const std::vector<Timed> timed =
      time_interleaved({contender("heavy", calls[0], 8000), contender("light", calls[1], 1000)},
                       {.rounds = 5, .batch = 2e-3});
  REQUIRE(timed.size() == 2);
  CHECK(timed[0].name == "heavy");
  CHECK(timed[1].name == "light");
  const double ratio = timed[0].least / timed[1].least;
  CHECK(ratio > 4.0);
  CHECK(ratio < 16.0);  // a factor of two for what else the processor does
  for (std::size_t n = 0; n < 2; ++n) {
    CHECK(timed[n].least > 0.0);
    CHECK(timed[n].least <= timed[n].median);
    CHECK(calls[n] >= 5 + 1);  // the rounds, and what found their length
  }
}

/// Share of trials in which something happens, a number of times each [1].
double share_of(int trials, const std::function<int(std::uint64_t)>& happens) {
  int count = 0;
  for (int trial = 0; trial < trials; ++trial) { count += happens(std::uint64_t(trial)); }
  return static_cast<double>(count) / trials;
}

/// Pairs of times with a heavy tail, as on a busy machine: every tenth batch of either build takes
/// up to five times as long.
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
  // Table of the sign test, one-sided 0.01: n = 7 gives the first, n = 20 the fifth, n = 40 the
  // thirteenth value; six values support no limit.
  const auto limits = [](int n) {
    std::vector<double> one_to_n(static_cast<std::size_t>(n));
    std::iota(one_to_n.begin(), one_to_n.end(), 1.0);
    return median_limits(one_to_n, 0.99);
  };
  CHECK_NEAR(limits(7).lower, 1.0, 0.0);
  CHECK_NEAR(limits(20).lower, 5.0, 0.0);
  CHECK_NEAR(limits(40).lower, 13.0, 0.0);
  CHECK_NEAR(limits(40).upper, 28.0, 0.0);
  CHECK_NEAR(limits(40).median, 20.5, 0.0);
  CHECK_NEAR(limits(7).median, 4.0, 0.0);
  CHECK(limits(6).lower == -std::numeric_limits<double>::infinity());
  CHECK(std::isinf(limits(6).upper));
}

TEST("the lower limit lies above the true median in one per cent of samples, whatever their law") {
  Random random(3);
  const auto above = [&](std::uint64_t) {
    std::vector<double> values;
    for (int n = 0; n < 40; ++n) { values.push_back(std::pow(random(0.0, 1.0), 8.0)); }
    // The median is 2^-8.
    return median_limits(values, 0.99).lower > std::pow(2.0, -8.0) ? 1 : 0;
  };
  // P(Bin(40, 1/2) < 13) = 0.0083; three standard deviations of 4000 trials are 0.0043.
  CHECK_NEAR(share_of(4000, above), 0.0083, 0.0043);
}

TEST("equal builds are never called slower on a busy machine, and five per cent always are") {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    CHECK(!judge_pairs(noisy_starts(1.0, seed)).slower());
    CHECK(judge_pairs(noisy_starts(1.05, seed)).slower());
  }
  const PairedVerdict verdict = judge_pairs(noisy_starts(1.05, 7));
  CHECK_NEAR(verdict.ratio, 1.05, 0.01);
  CHECK(verdict.lower < verdict.ratio);
  CHECK(verdict.ratio < verdict.upper);
  CHECK(verdict.pairs == 480);
  CHECK(judge_pairs({}).slower());  // nothing measured is not passed
}

TEST("a build that is delayed by other processes is late, and no slower") {
  std::vector<PairedStart> starts = noisy_starts(1.0, 5);
  for (PairedStart& start : starts) {
    start.batch_deadline = 0.01;
    for (Pair& pair : start.pairs) {
      pair.base_wall = pair.base;
      pair.head_wall = pair.head + 0.02;
    }
  }
  const PairedVerdict verdict = judge_pairs(starts);
  CHECK(!verdict.slower());
  CHECK(verdict.base_misses == 0);
  CHECK(verdict.head_misses == 480);
  CHECK(verdict.misses_rose());
}

TEST("misses rise if chance splits them so unevenly in less than one of a hundred cases") {
  const auto rose = [](long base, long head) {
    return PairedVerdict{.base_misses = base, .head_misses = head}.misses_rose();
  };
  CHECK(!rose(0, 0));
  CHECK(!rose(0, 6));
  CHECK(!rose(5, 5));
  CHECK(!rose(9, 0));
  CHECK(rose(0, 7));  // 2^-7 < 0.01
  CHECK(rose(10, 30));
  CHECK(!rose(15, 25));
}

TEST("starts are repeated only while the limits of the median do not decide") {
  // Limits of 480 pairs with this scatter are between 2 and 5 per cent from the median.
  const auto starts_for = [](double ratio, double scatter) {
    return starts_until_decided(12, [&](int n) {
      Random random(static_cast<std::uint64_t>(n) + 1);
      PairedStart start{.batch_deadline = 1.0};
      for (int pair = 0; pair < 40; ++pair) {
        const double noise = random(1.0 - scatter, 1.0 + scatter);
        start.pairs.push_back({.base = 1e-3, .head = 1e-3 * ratio * noise});
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

std::vector<double> noise(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  std::vector<double> values;
  for (std::size_t k = 0; k < n; ++k) { values.push_back(random(0.99, 1.01)); }
  return values;
}

bool creeps(std::vector<double> values, const std::string& unit = "instructions") {
  std::vector<Trend> trends{{.name = "x", .unit = unit, .values = std::move(values)}};
  find_creep(trends);
  return trends.front().crept;
}

/// Series of 40 runs.
std::vector<double> series(const std::function<double(int)>& law) {
  std::vector<double> values;
  for (int n = 0; n < 40; ++n) { values.push_back(law(n)); }
  return values;
}

TEST("a step is found where it is, with the chance that Pettitt gives it") {
  std::vector<double> values(20, 1.0);
  for (std::size_t n = 12; n < 20; ++n) { values[n] = 2.0; }
  const ChangePoint change = find_change(values).value();
  CHECK(change.at == 12);
  CHECK_NEAR(change.before, 1.0, 0.0);
  CHECK_NEAR(change.after, 2.0, 0.0);
  // K = 12 x 8: every value of one level is below every value of the other.
  CHECK_NEAR(change.chance, 2.0 * std::exp(-6.0 * 96.0 * 96.0 / (8000.0 + 400.0)), 1e-15);
}

TEST("without a change one of a hundred series or sets of series raises an alarm, or fewer") {
  for (const std::size_t n : {8U, 15U, 40U}) {
    const auto alarm = [n](std::uint64_t trial) {
      return find_change(noise(n, trial + 1))->chance <= false_alarm_rate ? 1 : 0;
    };
    CHECK(share_of(3000, alarm) <= 0.0155);  // 1 % and three standard deviations
  }
  // In many series together a false alarm is as seldom.
  const auto alarms = [](std::uint64_t trial) {
    std::vector<Trend> trends;
    for (std::uint64_t k = 0; k < 20; ++k) {
      std::vector<double> values = noise(30, trial * 20 + k + 1);
      for (double& value : values) { value = std::pow(value, 5); }  // 10 % up and down: no trifle
      trends.push_back({.name = "x", .unit = "instructions", .values = std::move(values)});
    }
    find_creep(trends);
    return static_cast<int>(std::ranges::count(trends, true, &Trend::crept));
  };
  CHECK(share_of(500, alarms) <= 0.0234);  // 1 % and three standard deviations
}

TEST("a slow loss has crept; a gain or a trifle has not") {
  // A tenth of a per cent a run, although no two runs differ by one per cent.
  CHECK(creeps(series([](int n) { return 1e6 * std::pow(1.001, n); })));
  CHECK(!creeps(series([](int n) { return 1e6 * std::pow(0.999, n); })));
  const std::vector<double> trifle = series([](int n) { return 1e6 * std::pow(1.0002, n); });
  CHECK(!creeps(trifle));
  CHECK(find_change(trifle)->chance < 1e-3);  // reported nevertheless
  // Fewer digits are worse.
  CHECK(creeps(series([](int n) { return 5.0 - 0.01 * n; }), "digits"));
  CHECK(!creeps(series([](int n) { return 5.0 + 0.01 * n; }), "digits"));
}

TEST("a constant series, one run or none have no change") {
  CHECK(!creeps(std::vector<double>(50, 7.0)));
  CHECK(!find_change(std::vector<double>{1.0}));
  CHECK(!find_change({}));
  CHECK_NEAR(find_change(std::vector<double>(50, 7.0))->chance, 1.0, 0.0);
}

}  // namespace PALPATE_FILE
