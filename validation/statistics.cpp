// SPDX-License-Identifier: MIT

#include "validation/statistics.hpp"

#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "device/seeded.hpp"
#include "validation/signal.hpp"

namespace palpate::comparison {

Interval share_interval(std::size_t hits, std::size_t trials, double level) {
  const double tail = 0.5 * (1.0 - level);
  const auto k = static_cast<double>(hits);
  const auto n = static_cast<double>(trials);
  return {hits == 0 ? 0.0 : boost::math::ibeta_inv(k, n - k + 1.0, tail),
          hits == trials ? 1.0 : boost::math::ibetac_inv(k + 1.0, n - k, tail)};
}

Interval expected_share(double share, std::size_t trials, double level) {
  const double tail = 0.5 * (1.0 - level);
  const auto n = static_cast<double>(trials);
  const boost::math::binomial counts(n, share);
  double low = 0.0;
  while (low < n && cdf(counts, low) < tail) { ++low; }
  double high = n;
  while (high > 0.0 && cdf(complement(counts, high - 1.0)) < tail) { --high; }
  return {low / n, high / n};
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

std::optional<Interval> bootstrap_mean(std::span<const double> value,
                                       const BootstrapOptions& options) {
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
  const boost::math::students_t t(static_cast<double>(degrees_of_freedom));
  return quantile(complement(t, 0.5 * (1.0 - level)));
}

double student_share(double factor, std::size_t degrees_of_freedom) {
  const boost::math::students_t t(static_cast<double>(degrees_of_freedom));
  return 1.0 - 2.0 * cdf(complement(t, factor));
}

double normal_above(double deviations) { return 0.5 * std::erfc(deviations / std::numbers::sqrt2); }

}  // namespace palpate::comparison
