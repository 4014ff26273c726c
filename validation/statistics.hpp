// SPDX-License-Identifier: MIT
#pragma once
/// Intervals: of a share that was counted, and of a mean over a few subjects.

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

/// Clopper-Pearson (exact, from the beta distribution) for `hits` out of `trials`, at least one.
Interval share_interval(std::size_t hits, std::size_t trials, double level = 0.95);

/// Counts out of `trials` outside of which a binomial variable of this share falls at most 1 -
/// level of the time, as shares: what a measured share must lie in if the true one is `share`.
Interval expected_share(double share, std::size_t trials, double level = 0.999);

double mean_of(std::span<const double> value);
/// With n - 1; NaN below two values.
double deviation_of(std::span<const double> value);

struct BootstrapOptions {
  std::size_t draws = 2000;
  double level = 0.95;
  std::uint64_t seed = 1;
};
/// Percentile bootstrap of the mean over subjects, seeded. Absent below three subjects. With few
/// subjects such intervals are too narrow: for five normal values they cover 0.846 instead of 0.95,
/// Student's t at 1.96 sqrt(4/5). Stated with every result.
std::optional<Interval> bootstrap_mean(std::span<const double> value,
                                       const BootstrapOptions& options = {});

/// Student's t at which a share of `level` lies between -t and t.
double student_factor(double level, std::size_t degrees_of_freedom);
/// The share that lies between -factor and factor.
double student_share(double factor, std::size_t degrees_of_freedom);

/// The share of a normal distribution that lies more than so many deviations above its mean.
double normal_above(double deviations);

}  // namespace palpate::comparison
