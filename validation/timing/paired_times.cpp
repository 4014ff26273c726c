// SPDX-License-Identifier: MIT
#include "validation/timing/paired_times.hpp"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <cmath>
#include <limits>

namespace palpate::timing {

namespace {

/// P(at most k of n fair coins show heads); 0 for k < 0.
double at_most(long k, std::size_t n) {
  if (k < 0) { return 0.0; }
  return boost::math::cdf(boost::math::binomial(static_cast<double>(n), 0.5), static_cast<double>(k));
}

double median_of_sorted(const std::vector<double>& sorted) {
  const std::size_t n = sorted.size();
  return n == 0 ? std::nan("") : 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]);
}

}  // namespace

MedianLimits median_limits(std::vector<double> values, double confidence) {
  std::ranges::sort(values);
  const std::size_t n = values.size();
  long rank = 0;  // the largest that is a limit with that confidence
  while (rank < static_cast<long>(n) && at_most(rank, n) <= 1.0 - confidence) { ++rank; }
  MedianLimits limits{.median = median_of_sorted(values),
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

std::vector<PairedStart> starts_until_decided(int starts, const std::function<PairedStart(int)>& measure) {
  std::vector<PairedStart> measured;
  for (int look = 0; look < most_looks && !(look > 0 && judge_pairs(measured).decided()); ++look) {
    for (int n = 0; n < starts; ++n) { measured.push_back(measure(look * starts + n)); }
  }
  return measured;
}

}  // namespace palpate::timing
