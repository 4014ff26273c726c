// SPDX-License-Identifier: MIT
#include "validation/timing/change_point.hpp"

#include <cmath>

#include "tests/check.hpp"
#include "validation/random.hpp"

namespace {

using namespace palpate;
using namespace palpate::timing;

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

TEST("a step is found where it is, with the chance that Pettitt gives it") {
  std::vector<double> values(20, 1.0);
  for (std::size_t n = 12; n < 20; ++n) { values[n] = 2.0; }
  const ChangePoint change = find_change(values).value();
  CHECK(change.at == 12);
  CHECK_NEAR(change.before, 1.0, 0.0);
  CHECK_NEAR(change.after, 2.0, 0.0);
  // K = 12 x 8: every value of the one level lies below every one of the other.
  CHECK_NEAR(change.chance, 2.0 * std::exp(-6.0 * 96.0 * 96.0 / (8000.0 + 400.0)), 1e-15);
}

TEST("where nothing changes a false alarm comes once in a hundred times at most, for short and for long series") {
  for (const std::size_t n : {8U, 15U, 40U}) {
    int alarms = 0;
    constexpr int trials = 3000;
    for (int trial = 0; trial < trials; ++trial) {
      const auto change = find_change(noise(n, static_cast<std::uint64_t>(trial) + 1));
      alarms += change->chance <= false_alarm_rate ? 1 : 0;
    }
    // Three standard deviations above 1 % are 0.0155.
    CHECK(static_cast<double>(alarms) / trials <= 0.0155);
  }
}

TEST("in many series together a false alarm is as seldom") {
  int alarms = 0;
  constexpr int trials = 500;
  for (int trial = 0; trial < trials; ++trial) {
    std::vector<Trend> trends;
    for (std::uint64_t k = 0; k < 20; ++k) {
      std::vector<double> values = noise(30, static_cast<std::uint64_t>(trial) * 20 + k + 1);
      for (double& value : values) { value *= value * value * value * value; }  // 10 % up and down: no trifle
      trends.push_back({.name = "x", .unit = "instructions", .values = std::move(values)});
    }
    find_creep(trends);
    for (const Trend& trend : trends) { alarms += trend.crept ? 1 : 0; }
  }
  CHECK(static_cast<double>(alarms) / trials <= 0.0234);  // 1 % and three standard deviations
}

TEST("creep of a tenth of a per cent a run is found, though no two runs differ by one per cent") {
  std::vector<double> values;
  for (int n = 0; n < 40; ++n) { values.push_back(1e6 * std::pow(1.001, n)); }
  CHECK(creeps(values));
}

TEST("what became better, or moved by a trifle, has not crept") {
  std::vector<double> better, trifle;
  for (int n = 0; n < 40; ++n) {
    better.push_back(1e6 * std::pow(0.999, n));
    trifle.push_back(1e6 * std::pow(1.0002, n));
  }
  CHECK(!creeps(better) && !creeps(trifle));
  CHECK(find_change(trifle)->chance < 1e-3);  // and is told all the same
}

TEST("digits creep downwards") {
  std::vector<double> falling, rising;
  for (int n = 0; n < 40; ++n) {
    falling.push_back(5.0 - 0.01 * n);
    rising.push_back(5.0 + 0.01 * n);
  }
  CHECK(creeps(falling, "digits") && !creeps(rising, "digits"));
}

TEST("a constant series, one run or none tell nothing") {
  CHECK(!creeps(std::vector<double>(50, 7.0)));
  CHECK(!find_change(std::vector<double>{1.0}) && !find_change({}));
  CHECK_NEAR(find_change(std::vector<double>(50, 7.0))->chance, 1.0, 0.0);
}

}  // namespace
