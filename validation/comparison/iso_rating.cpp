// SPDX-License-Identifier: MIT

#include "validation/comparison/iso_rating.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "model/problem/input_error.hpp"
#include "validation/signal.hpp"

namespace palpate::comparison {

WarpSums warp(std::span<const double> first, std::span<const double> second, std::size_t radius) {
  enum class From : std::uint8_t { first_before, second_before, both_before };
  const std::size_t length = std::min(first.size(), second.size());
  if (length == 0) { return {}; }
  radius = std::clamp<std::size_t>(radius, 1, length);
  // Column c of row i represents sample j = i + c - (radius - 1) of the second trace.
  const std::size_t width = 2 * radius - 1;
  const auto column = [&](std::size_t i, std::size_t j) { return j + radius - 1 - i; };
  std::vector<From> from(length * width);
  constexpr double none = std::numeric_limits<double>::infinity();
  std::vector<double> above(width + 1, none);  // least sums of the previous row
  std::vector<double> row = above;
  for (std::size_t i = 0; i < length; ++i) {
    std::ranges::fill(row, none);
    double left = none;
    const std::size_t end = std::min(length, i + radius);
    for (std::size_t j = i >= radius - 1 ? i - (radius - 1) : 0; j < end; ++j) {
      const std::size_t c = column(i, j);
      const double d = first[i] - second[j];
      double least = i > 0 ? above[c + 1] : none;
      From best = From::first_before;
      if (left < least) { least = left, best = From::second_before; }
      const double diagonal = i > 0 && j > 0 ? above[c] : none;
      if (diagonal < least) { least = diagonal, best = From::both_before; }
      left = (i == 0 && j == 0 ? 0.0 : least) + d * d;
      row[c] = left;
      from[i * width + c] = best;
    }
    std::swap(above, row);
  }
  WarpSums sums;
  std::size_t i = length - 1;
  std::size_t j = length - 1;
  while (true) {
    sums.difference += std::abs(first[i] - second[j]);
    sums.second += std::abs(second[j]);
    ++sums.length;
    if (i == 0 && j == 0) { return sums; }
    const From best = from[i * width + column(i, j)];
    if (best != From::second_before) { --i; }
    if (best != From::first_before) { --j; }
  }
}

namespace {

// Constants of ISO/TS 18571.
constexpr double inner_corridor = 0.05;  ///< half-width over the largest |recorded|: score 1 inside
constexpr double outer_corridor = 0.50;  ///< likewise: score 0 outside, squared distance between
constexpr double largest_shift = 0.20;   ///< share of the samples at which the phase scores 0
constexpr double warp_window = 0.10;     ///< share of the samples left after the shift
constexpr double zero_magnitude = 0.50;  ///< warped error over warped recorded values: score 0
constexpr double zero_slope = 2.0;       ///< error of slopes over recorded slopes: score 0

double corridor_score(std::span<const double> s, std::span<const double> r) {
  const double scale = std::abs(std::ranges::max(r, {}, [](double v) { return std::abs(v); }));
  double sum = 0.0;
  for (std::size_t n = 0; n < r.size(); ++n) {
    const double off = std::abs(s[n] - r[n]);
    if (off < inner_corridor * scale || off == 0.0) {
      sum += 1.0;
    } else if (off <= outer_corridor * scale) {
      sum += std::pow((outer_corridor - off / scale) / (outer_corridor - inner_corridor), 2);
    }
  }
  return sum / static_cast<double>(r.size());
}

/// Cumulative sums of a trace about its mean, for correlations at many shifts.
class Moments {
 public:
  explicit Moments(std::span<const double> value)
      : centred_(Eigen::Map<const Eigen::VectorXd>(value.data(), std::ssize(value))),
        sum_(value.size() + 1, 0.0),
        square_(value.size() + 1, 0.0) {
    const double mean = centred_.mean();
    centred_.array() -= mean;
    for (std::size_t n = 0; n < value.size(); ++n) {
      const double v = centred_[static_cast<Eigen::Index>(n)];
      sum_[n + 1] = sum_[n] + v;
      square_[n + 1] = square_[n] + v * v;
    }
    // Bound on the rounding error of these sums for a constant.
    floor_ = 1e-12 * square_.back() + static_cast<double>(value.size()) * std::pow(1e-12 * mean, 2);
  }

  [[nodiscard]] auto window(std::size_t begin, std::size_t count) const {
    return centred_.segment(static_cast<Eigen::Index>(begin), static_cast<Eigen::Index>(count));
  }
  [[nodiscard]] double sum(std::size_t begin, std::size_t count) const {
    return sum_[begin + count] - sum_[begin];
  }
  /// Returns the sum of squares about the mean of the window; 0 for a constant.
  [[nodiscard]] double variation(std::size_t begin, std::size_t count) const {
    const double square = square_[begin + count] - square_[begin];
    const double left = square - std::pow(sum(begin, count), 2) / static_cast<double>(count);
    return left > floor_ ? left : 0.0;
  }

 private:
  Eigen::VectorXd centred_;
  std::vector<double> sum_;
  std::vector<double> square_;
  double floor_ = 0.0;
};

/// Returns the Pearson correlation of `count` samples from each beginning; absent if one is
/// constant.
std::optional<double> correlation(const Moments& a, std::size_t from_a, const Moments& b,
                                  std::size_t from_b, std::size_t count) {
  const double product = a.variation(from_a, count) * b.variation(from_b, count);
  if (!(product > 0.0)) { return std::nullopt; }
  const double together = a.window(from_a, count).dot(b.window(from_b, count)) -
                          a.sum(from_a, count) * b.sum(from_b, count) / static_cast<double>(count);
  return together / std::sqrt(product);
}

struct Shifted {
  std::span<const double> simulated;
  std::span<const double> recorded;
};

/// Returns the overlap if the simulated trace is shifted by `late` samples.
Shifted shifted(std::span<const double> s, std::span<const double> r, long late) {
  const std::size_t n = s.size();
  const auto by = static_cast<std::size_t>(std::abs(late));
  if (late >= 0) { return {s.subspan(by), r.first(n - by)}; }
  return {s.first(n - by), r.subspan(by)};
}

/// Among correlations that are equal to rounding, the smallest shift is selected.
void find_shift(std::span<const double> s, std::span<const double> r, IsoRating& rating) {
  std::optional<double> best;
  const Moments simulated(s);
  const Moments recorded(r);
  const double allowed = largest_shift * static_cast<double>(r.size());
  for (std::size_t by = 0; static_cast<double>(by) <= allowed; ++by) {
    const std::size_t count = r.size() - by;
    for (const bool late : {true, false}) {
      const std::optional<double> found =
          correlation(simulated, late ? by : 0, recorded, late ? 0 : by, count);
      if (!found || (best && *found <= *best + 1e-12)) { continue; }
      best = found;
      rating.shift = late ? static_cast<long>(by) : -static_cast<long>(by);
    }
  }
  if (!best) {
    rating.note = "phase: a constant has none, rated 0";
    return;
  }
  rating.correlation = *best;
  rating.phase = std::max(0.0, 1.0 - static_cast<double>(std::abs(rating.shift)) / allowed);
}

/// Returns central differences per sample, averaged over nine samples (fewer, symmetric, near the
/// ends).
std::vector<double> smooth_slope(std::span<const double> value) {
  const std::size_t count = value.size();
  std::vector<double> slope(count);
  for (std::size_t n = 0; n < count; ++n) {
    const std::size_t below = n > 0 ? n - 1 : 0;
    const std::size_t above = std::min(n + 1, count - 1);
    slope[n] = (value[above] - value[below]) / static_cast<double>(above - below);
  }
  std::vector<double> smooth(count);
  for (std::size_t n = 0; n < count; ++n) {
    const std::size_t half = std::min({std::size_t{4}, n, count - 1 - n});
    double sum = 0.0;
    for (std::size_t m = n - half; m <= n + half; ++m) { sum += slope[m]; }
    smooth[n] = sum / static_cast<double>(2 * half + 1);
  }
  return smooth;
}

/// Returns a score: 1 without error, 0 from `zero` on, and 0 for an error relative to a reference
/// of zero.
double linear_score(double error, double scale, double zero) {
  if (error == 0.0) { return 1.0; }
  return scale > 0.0 ? std::max(0.0, 1.0 - error / scale / zero) : 0.0;
}

double slope_score(const Shifted& pair) {
  const std::vector<double> s = smooth_slope(pair.simulated);
  const std::vector<double> r = smooth_slope(pair.recorded);
  double error = 0.0;
  double scale = 0.0;
  for (std::size_t n = 0; n < r.size(); ++n) {
    error += std::abs(s[n] - r[n]);
    scale += std::abs(r[n]);
  }
  return linear_score(error, scale, zero_slope);
}

}  // namespace

IsoRating rate(std::span<const double> simulated, std::span<const double> recorded) {
  const auto finite = [](double v) { return std::abs(v) <= largest_value; };
  if (simulated.size() != recorded.size() || recorded.size() < 10 ||
      !std::ranges::all_of(simulated, finite) || !std::ranges::all_of(recorded, finite)) {
    throw InputError(
        "a rating needs two traces of one length, at least 10 samples, all of them numbers");
  }
  IsoRating rating;
  rating.corridor = corridor_score(simulated, recorded);
  find_shift(simulated, recorded, rating);
  const Shifted pair = shifted(simulated, recorded, rating.shift);
  const double window = warp_window * static_cast<double>(pair.recorded.size());
  const WarpSums sums =
      warp(pair.simulated, pair.recorded, static_cast<std::size_t>(std::ceil(window)));
  rating.magnitude = linear_score(sums.difference, sums.second, zero_magnitude);
  rating.slope = slope_score(pair);
  rating.overall = 0.4 * rating.corridor + 0.2 * (rating.phase + rating.magnitude + rating.slope);
  return rating;
}

std::string_view grade_of(double overall) {
  if (overall > 0.94) { return "excellent"; }
  if (overall > 0.80) { return "good"; }
  return overall > 0.58 ? "fair" : "poor";
}

}  // namespace palpate::comparison
