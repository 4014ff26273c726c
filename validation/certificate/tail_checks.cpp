// SPDX-License-Identifier: MIT
#include "validation/certificate/tail_checks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <gsl/gsl_cdf.h>
#include <gsl/gsl_statistics_double.h>
#include <numeric>

namespace palpate::certificate {

namespace {

constexpr long lags = 10;

/// Beyond which a standard normal number falls with this chance, on both sides.
double two_sided(double chance) { return gsl_cdf_ugaussian_Qinv(0.5 * chance); }

std::vector<double> sizes(const Exceedances& all) {
  std::vector<double> size;
  for (const LargeTick& each : all.ticks) { size.push_back(each.seconds); }
  return size;
}

/// Rank correlation of two lists of one length; 0 where one of them does not vary.
double rank_correlation(std::span<const double> a, std::span<const double> b) {
  std::vector<double> work(2 * a.size());
  const double r = gsl_stats_spearman(a.data(), 1, b.data(), 1, a.size(), work.data());
  return std::isfinite(r) ? r : 0.0;
}

TailCheck correlation_check(const char* name, const char* claim, double r, std::size_t pairs) {
  const double limit = two_sided(false_alarm) / std::sqrt(static_cast<double>(pairs) - 1.0);
  return {.name = name, .claim = claim, .value = r, .lower = -limit, .upper = limit};
}

/// Ticks that are both above the threshold, a lag apart: how unlikely the most surprising number of such
/// pairs is among independent ticks, times the number of lags. Their number is close to a Poisson variable.
double chance_of_pairs(const Exceedances& all) {
  std::array<unsigned, lags + 1> pairs{};
  for (std::size_t n = 0; n < all.count(); ++n) {
    for (std::size_t m = n + 1; m < all.count() && all.ticks[m].tick - all.ticks[n].tick <= lags; ++m) {
      ++pairs[static_cast<std::size_t>(all.ticks[m].tick - all.ticks[n].tick)];
    }
  }
  const auto count = static_cast<double>(all.count());
  const double expected = count * count / static_cast<double>(all.of);
  double least = 1.0;
  for (std::size_t lag = 1; lag <= lags; ++lag) {
    if (pairs[lag] > 0) { least = std::min(least, gsl_cdf_poisson_Q(pairs[lag] - 1, expected)); }
  }
  return std::min(1.0, static_cast<double>(lags) * least);
}

/// Largest distance of two distributions, of sorted samples (Kolmogorov & Smirnov).
double distribution_distance(std::span<const double> a, std::span<const double> b) {
  double distance = 0.0;
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    const double x = std::min(a[i], b[j]);
    while (i < a.size() && a[i] <= x) { ++i; }
    while (j < b.size() && b[j] <= x) { ++j; }
    distance = std::max(distance, std::abs(static_cast<double>(i) / static_cast<double>(a.size()) -
                                           static_cast<double>(j) / static_cast<double>(b.size())));
  }
  return distance;
}

TailCheck halves_check(const Exceedances& all) {
  std::vector<double> first = sizes(all.half(false));
  std::vector<double> second = sizes(all.half(true));
  std::ranges::sort(first);
  std::ranges::sort(second);
  const auto n = static_cast<double>(first.size());
  const auto m = static_cast<double>(second.size());
  const bool both = n > 0.0 && m > 0.0;
  return {.name = "same-distribution-in-both-halves",
          .claim = "excesses of both halves have one distribution (Kolmogorov-Smirnov distance)",
          .value = both ? distribution_distance(first, second) : 1.0,
          .lower = 0.0,
          .upper = both ? std::sqrt(-0.5 * std::log(0.5 * false_alarm) * (n + m) / (n * m)) : 0.0};
}

}  // namespace

std::vector<double> Exceedances::excess() const {
  std::vector<double> excess;
  for (const LargeTick& each : ticks) { excess.push_back(each.seconds - threshold); }
  return excess;
}

Exceedances Exceedances::half(bool second) const {
  Exceedances part{.threshold = threshold, .of = second ? of - of / 2 : of / 2};
  for (const LargeTick& each : ticks) {
    if ((each.tick >= of / 2) == second) { part.ticks.push_back(each); }
  }
  return part;
}

Exceedances exceedances(std::span<const LargeTick> largest, std::size_t count, long ticks) {
  Exceedances all{.threshold = largest[count].seconds, .of = ticks};
  all.ticks.assign(largest.begin(), largest.begin() + static_cast<std::ptrdiff_t>(count));
  std::ranges::sort(all.ticks, {}, &LargeTick::tick);
  return all;
}

double extremal_index(const Exceedances& all) {
  double sum = 0.0;
  double squares = 0.0;
  double longest = 0.0;
  const auto gaps = static_cast<double>(all.count() - 1);
  for (std::size_t n = 1; n < all.count(); ++n) {
    longest = std::max(longest, static_cast<double>(all.ticks[n].tick - all.ticks[n - 1].tick));
  }
  const double one = longest > 2.0 ? 1.0 : 0.0;
  const double two = longest > 2.0 ? 2.0 : 0.0;
  for (std::size_t n = 1; n < all.count(); ++n) {
    const auto gap = static_cast<double>(all.ticks[n].tick - all.ticks[n - 1].tick);
    sum += gap - one;
    squares += (gap - one) * (gap - two);
  }
  return squares > 0.0 ? std::min(1.0, 2.0 * sum * sum / (gaps * squares)) : 1.0;
}

std::vector<TailCheck> independence_checks(const Exceedances& all) {
  const std::vector<double> size = sizes(all);
  const std::span<const double> each(size);
  // Of n exponential gaps the estimator has a standard error of 1 / sqrt(n): 4 + 20/4 - 8/2 from the moments
  // of mean and mean square.
  const double spread = gsl_cdf_ugaussian_Qinv(false_alarm) / std::sqrt(static_cast<double>(all.count()));
  return {
      {.name = "alone-in-time",
       .claim = "late ticks do not follow each other within ten ticks (chance of so many pairs)",
       .value = chance_of_pairs(all),
       .lower = false_alarm,
       .upper = 1.0},
      correlation_check("sizes-uncorrelated", "a large excess does not announce the next (rank correlation)",
                        rank_correlation(each.first(size.size() - 1), each.subspan(1)), size.size() - 1),
      {.name = "extremal-index",
       .claim = "excesses do not come in clusters (extremal index, 1 without any)",
       .value = extremal_index(all),
       .lower = 1.0 - spread,
       .upper = 1.0}};
}

std::vector<TailCheck> stationarity_checks(const Exceedances& all) {
  const auto count = static_cast<double>(all.count());
  const auto first = static_cast<double>(all.half(false).count());
  const double limit = two_sided(false_alarm);
  std::vector<double> order(all.count());
  std::iota(order.begin(), order.end(), 0.0);
  return {{.name = "as-many-in-both-halves",
           .claim = "both halves have as many excesses (difference over its standard error)",
           .value = (2.0 * first - count) / std::sqrt(count),
           .lower = -limit,
           .upper = limit},
          halves_check(all),
          correlation_check("no-trend", "excesses do not grow or shrink with time (rank correlation)",
                            rank_correlation(order, sizes(all)), all.count())};
}

}  // namespace palpate::certificate
