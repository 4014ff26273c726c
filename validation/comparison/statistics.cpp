// SPDX-License-Identifier: MIT
#include "validation/comparison/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <gsl/gsl_cdf.h>

#include "device/seeded.hpp"
#include "validation/comparison/samples.hpp"

namespace palpate::comparison {

Interval share_interval(std::size_t hits, std::size_t trials, double level) {
  const double tail = 0.5 * (1.0 - level);
  const auto k = static_cast<double>(hits);
  const auto n = static_cast<double>(trials);
  return {hits == 0 ? 0.0 : gsl_cdf_beta_Pinv(tail, k, n - k + 1.0),
          hits == trials ? 1.0 : gsl_cdf_beta_Qinv(tail, k + 1.0, n - k)};
}

Interval expected_share(double share, std::size_t trials, double level) {
  const double tail = 0.5 * (1.0 - level);
  const auto n = static_cast<unsigned>(trials);
  unsigned low = 0;
  while (low < n && gsl_cdf_binomial_P(low, share, n) < tail) { ++low; }
  unsigned high = n;
  while (high > 0 && gsl_cdf_binomial_Q(high - 1, share, n) < tail) { --high; }
  return {static_cast<double>(low) / n, static_cast<double>(high) / n};
}

double mean_of(std::span<const double> value) {
  return std::accumulate(value.begin(), value.end(), 0.0) / static_cast<double>(value.size());
}

double deviation_of(std::span<const double> value) {
  const double mean = mean_of(value);
  double square = 0.0;
  for (const double v : value) { square += (v - mean) * (v - mean); }
  return std::sqrt(square / (static_cast<double>(value.size()) - 1.0));
}

std::optional<Interval> bootstrap_mean(std::span<const double> value, const BootstrapOptions& options) {
  if (value.size() < 3 || options.draws == 0) { return std::nullopt; }
  device::Seeded seeded(options.seed);
  const auto count = static_cast<double>(value.size());
  std::vector<double> means(options.draws, 0.0);
  for (double& mean : means) {
    for (std::size_t n = 0; n < value.size(); ++n) {
      mean += value[static_cast<std::size_t>(seeded.uniform(0.0, count))] / count;
    }
  }
  const double tail = 0.5 * (1.0 - options.level);
  return Interval{quantile(means, tail), quantile(means, 1.0 - tail)};
}

double student_factor(double level, std::size_t degrees_of_freedom) {
  return gsl_cdf_tdist_Qinv(0.5 * (1.0 - level), static_cast<double>(degrees_of_freedom));
}

}  // namespace palpate::comparison
