// SPDX-License-Identifier: MIT
#include "validation/bench/interleaved.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <numeric>
#include <random>

namespace palpate::bench {

double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

namespace {

double seconds_of(const Contender& contender, long times) {
  const double begin = processor_seconds();
  contender.repeat(times);
  return processor_seconds() - begin;
}

/// How often fills a batch; warms caches and code on the way.
long times_for(const Contender& contender, double batch) {
  long times = 1;
  double seconds = seconds_of(contender, times);
  while (seconds < 0.5 * batch && times < 1L << 40) {
    times *= 2;
    seconds = seconds_of(contender, times);
  }
  return std::max(1L, std::lround(static_cast<double>(times) * batch / std::max(seconds, 1e-9)));
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace

std::vector<Timed> time_interleaved(const std::vector<Contender>& contenders, const TimingPlan& plan) {
  std::vector<long> times;
  for (const Contender& each : contenders) { times.push_back(times_for(each, plan.batch)); }
  std::vector<std::vector<double>> seconds(contenders.size());
  std::vector<std::size_t> order(contenders.size());
  std::iota(order.begin(), order.end(), 0U);
  std::mt19937_64 chance(plan.seed);
  for (int round = 0; round < plan.rounds; ++round) {
    std::ranges::shuffle(order, chance);
    for (const std::size_t n : order) {
      seconds[n].push_back(seconds_of(contenders[n], times[n]) / static_cast<double>(times[n]));
    }
  }
  std::vector<Timed> timed;
  for (std::size_t n = 0; n < contenders.size(); ++n) {
    timed.push_back({.name = contenders[n].name,
                     .least = std::ranges::min(seconds[n]),
                     .median = median_of(seconds[n])});
  }
  return timed;
}

}  // namespace palpate::bench
