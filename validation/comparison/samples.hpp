// SPDX-License-Identifier: MIT
#pragma once
/// Samples on a uniform grid, and the only place where samples are moved from one grid to another.
/// A gap is NaN and stays one: nothing is interpolated across it.

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace palpate::comparison {

inline constexpr double not_measured = std::numeric_limits<double>::quiet_NaN();

/// Squares and their sums stay numbers up to here; nothing larger is a measurement.
inline constexpr double largest_value = 1e100;

/// An interval longer than this many usual ones is a gap: a single missing sample makes it 2.
inline constexpr double longest_bridge = 1.5;

struct Grid {
  double start = 0.0;     ///< [s]
  double step = 0.01;     ///< [s]
  std::size_t count = 0;  ///< instants
};

struct Samples {
  double start = 0.0;           ///< [s]
  double step = 0.01;           ///< [s]
  std::vector<double> value{};  ///< NaN where nothing was measured

  [[nodiscard]] std::size_t size() const { return value.size(); }
  [[nodiscard]] double time(std::size_t n) const { return start + step * static_cast<double>(n); }
  [[nodiscard]] double end() const { return value.empty() ? start : time(value.size() - 1); }
  [[nodiscard]] Grid grid() const { return {start, step, value.size()}; }
  /// The index at or before a time, clamped to the samples.
  [[nodiscard]] std::size_t index_at(double t) const;
  /// How many steps a duration [s] holds, at least one.
  [[nodiscard]] std::size_t steps(double duration) const;
};

/// Samples [begin, end) without a gap.
struct Stretch {
  std::size_t begin = 0;
  std::size_t end = 0;
  [[nodiscard]] std::size_t size() const { return end - begin; }
};
std::vector<Stretch> finite_stretches(std::span<const double> value);
Stretch longest_stretch(std::span<const double> value);

/// Median of the intervals between times [s]; NaN below two of them.
double usual_interval(std::span<const double> time);

/// Every instant from `begin` to `end` [s] that lies on start + n step.
Grid grid_between(double begin, double end, double anchor, double step);

/// Linear between neighbours no further apart than `longest_bridge` usual intervals and both finite; NaN
/// elsewhere and outside. An instant within 1e-4 of an interval of a sample takes that sample. `time`
/// is strictly increasing.
Samples resample(std::span<const double> time, std::span<const double> value, const Grid& grid);
Samples resample(const Samples& samples, const Grid& grid);

/// The samples on a grid of their own usual interval, which starts at the first of them.
Samples regular(std::span<const double> time, std::span<const double> value);

/// The q-quantile of the finite values, linear between order statistics; NaN when there is none.
double quantile(std::span<const double> value, double q);

/// The finite values alone.
std::vector<double> finite_only(std::span<const double> value);

}  // namespace palpate::comparison
