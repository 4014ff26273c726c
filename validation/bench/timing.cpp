// SPDX-License-Identifier: MIT

#include "validation/bench/timing.hpp"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <cmath>
#include <ctime>
#include <limits>
#include <numeric>
#include <random>

#include "validation/signal.hpp"

namespace palpate::bench {

namespace {

double seconds_of(const Contender& contender, long times) {
  if (contender.begin) { contender.begin(); }
  const double begin = seconds_on(contender.clock);
  contender.repeat(times);
  const double seconds = seconds_on(contender.clock) - begin;
  if (contender.end) { contender.end(); }
  return seconds;
}

/// Returns the number of repetitions of a batch; also warms caches and code.
long times_for(const Contender& contender, double batch) {
  long times = 1;
  double seconds = seconds_of(contender, times);
  while (seconds < 0.5 * batch && times < 1L << 40) {
    times *= 2;
    seconds = seconds_of(contender, times);
  }
  return std::max(1L, std::lround(static_cast<double>(times) * batch / std::max(seconds, 1e-9)));
}

}  // namespace

double seconds_on(Clock clock) {
  timespec now{};
  clock_gettime(clock == Clock::wall ? CLOCK_MONOTONIC : CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

std::vector<Timed> time_interleaved(const std::vector<Contender>& contenders,
                                    const TimingPlan& plan) {
  std::vector<long> times;
  for (const Contender& each : contenders) {
    times.push_back(plan.batch > 0.0 ? times_for(each, plan.batch) : 1);
  }
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
                     .median = comparison::quantile(seconds[n], 0.5)});
  }
  return timed;
}

}  // namespace palpate::bench

namespace palpate::timing {

namespace {

/// P(at most k of n fair coins show heads); 0 for k < 0.
double at_most(long k, std::size_t n) {
  if (k < 0) { return 0.0; }
  return boost::math::cdf(boost::math::binomial(static_cast<double>(n), 0.5),
                          static_cast<double>(k));
}

}  // namespace

MedianLimits median_limits(std::vector<double> values, double confidence) {
  std::ranges::sort(values);
  const std::size_t n = values.size();
  long rank = 0;  // the largest that is a limit with that confidence
  while (rank < static_cast<long>(n) && at_most(rank, n) <= 1.0 - confidence) { ++rank; }
  MedianLimits limits{.median = comparison::quantile(values, 0.5),
                      .lower = -std::numeric_limits<double>::infinity(),
                      .upper = std::numeric_limits<double>::infinity()};
  if (rank > 0) {
    limits.lower = values[static_cast<std::size_t>(rank) - 1];
    limits.upper = values[n - static_cast<std::size_t>(rank)];
  }
  return limits;
}

bool PairedVerdict::misses_rose() const {
  const long both = base_misses + head_misses;
  if (head_misses <= base_misses) { return false; }
  return 1.0 - at_most(head_misses - 1, static_cast<std::size_t>(both)) <= 1.0 - paired_confidence;
}

PairedVerdict judge_pairs(std::span<const PairedStart> starts) {
  PairedVerdict verdict;
  std::vector<double> logarithms;
  for (const PairedStart& start : starts) {
    for (const Pair& pair : start.pairs) {
      logarithms.push_back(std::log(pair.head / pair.base));
      verdict.base_misses += pair.base_wall > start.batch_deadline ? 1 : 0;
      verdict.head_misses += pair.head_wall > start.batch_deadline ? 1 : 0;
    }
  }
  verdict.pairs = static_cast<long>(logarithms.size());
  const bool nothing_measured = logarithms.empty();
  const MedianLimits limits = median_limits(std::move(logarithms), look_confidence);
  verdict.ratio = std::exp(limits.median);
  verdict.lower = nothing_measured ? std::nan("") : std::exp(limits.lower);  // NaN passes nowhere
  verdict.upper = std::exp(limits.upper);
  return verdict;
}

std::vector<PairedStart> starts_until_decided(int starts,
                                              const std::function<PairedStart(int)>& measure) {
  std::vector<PairedStart> measured;
  for (int look = 0; look < most_looks && !(look > 0 && judge_pairs(measured).decided()); ++look) {
    for (int n = 0; n < starts; ++n) { measured.push_back(measure(look * starts + n)); }
  }
  return measured;
}

namespace {

int sign(double x) { return (x > 0.0 ? 1 : 0) - (x < 0.0 ? 1 : 0); }

bool is_worse(const Trend& trend) {
  const ChangePoint& change = *trend.change;
  if (trend.unit == "digits") { return change.before - change.after > least_loss_of_digits; }
  return change.after > least_growth * change.before;
}

}  // namespace

std::optional<ChangePoint> find_change(std::span<const double> values) {
  const std::size_t n = values.size();
  if (n < 2) { return std::nullopt; }
  long sum = 0;
  long largest = -1;
  ChangePoint change;
  for (std::size_t t = 0; t + 1 < n; ++t) {
    // Value t moves to the side of the old level.
    for (std::size_t j = 0; j < n; ++j) { sum += sign(values[j] - values[t]); }
    if (std::abs(sum) > largest) {
      largest = std::abs(sum);
      change.at = t + 1;
    }
  }
  const auto count = static_cast<double>(n);
  const auto k = static_cast<double>(largest);
  change.chance = std::min(1.0, 2.0 * std::exp(-6.0 * k * k / (count * count * (count + 1.0))));
  change.before = comparison::quantile(values.first(change.at), 0.5);
  change.after = comparison::quantile(values.subspan(change.at), 0.5);
  return change;
}

void find_creep(std::vector<Trend>& trends) {
  std::vector<Trend*> by_chance;
  for (Trend& trend : trends) {
    trend.change = find_change(trend.values);
    trend.crept = false;
    if (trend.change) { by_chance.push_back(&trend); }
  }
  std::ranges::sort(by_chance, {}, [](const Trend* trend) { return trend->change->chance; });
  for (std::size_t n = 0; n < by_chance.size(); ++n) {
    const auto still_open = static_cast<double>(by_chance.size() - n);
    if (!(by_chance[n]->change->chance <= false_alarm_rate / still_open)) { break; }
    by_chance[n]->crept = is_worse(*by_chance[n]);
  }
}

}  // namespace palpate::timing
