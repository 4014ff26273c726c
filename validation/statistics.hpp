// SPDX-License-Identifier: MIT
#pragma once
/// Confidence intervals of a counted share and of a mean over a few subjects.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace palpate::comparison {

struct Interval {
  double lower = 0.0;
  double upper = 0.0;
  [[nodiscard]] bool holds(double value) const { return value >= lower && value <= upper; }
};

/// Returns the exact Clopper-Pearson interval for `hits` of `trials` (at least one).
Interval share_interval(std::size_t hits, std::size_t trials, double level = 0.95);

/// Returns the interval, as shares, that contains the measured share of `trials` with probability
/// `level` if the true share is `share` (binomial).
Interval expected_share(double share, std::size_t trials, double level = 0.999);

double mean_of(std::span<const double> value);
/// Returns the sample standard deviation (n - 1); NaN for fewer than two values.
double deviation_of(std::span<const double> value);

struct BootstrapOptions {
  std::size_t draws = 2000;
  double level = 0.95;
  std::uint64_t seed = 1;
};
/// Returns the seeded percentile bootstrap interval of the mean over subjects; absent for fewer
/// than three subjects. With few subjects these intervals are too narrow: for five normal values
/// the coverage is 0.846 instead of 0.95 (Student's t at 1.96 sqrt(4/5)).
std::optional<Interval> bootstrap_mean(std::span<const double> value,
                                       const BootstrapOptions& options = {});

/// Standard uncertainties of a pressure transducer that all its readings share.
struct TransducerUncertainty {
  double zero = 57.0;  ///< [Pa] within 1 cm of the needle's height, uniform
  double gain = 0.01;  ///< [1] assumed, no recording states it
};

/// Returns the t of Student's distribution for which a share of `level` lies between -t and t.
double student_factor(double level, std::size_t degrees_of_freedom);
/// Returns the share of Student's distribution between -factor and factor.
double student_share(double factor, std::size_t degrees_of_freedom);

/// Returns the share of a normal distribution that lies more than `deviations` standard deviations
/// above the mean.
double normal_above(double deviations);

}  // namespace palpate::comparison
