// SPDX-License-Identifier: MIT
#include "validation/comparison/samples.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::comparison {

std::size_t Samples::index_at(double t) const {
  if (value.empty() || !(t > start)) { return 0; }
  const double index = std::floor((t - start) / step + 1e-9);
  return static_cast<std::size_t>(std::min(index, static_cast<double>(value.size() - 1)));
}

std::size_t Samples::steps(double duration) const {
  return static_cast<std::size_t>(std::max(1.0, std::round(duration / step)));
}

std::vector<Stretch> finite_stretches(std::span<const double> value) {
  std::vector<Stretch> stretches;
  for (std::size_t n = 0; n < value.size(); ++n) {
    if (!std::isfinite(value[n])) { continue; }
    if (stretches.empty() || stretches.back().end != n) { stretches.push_back({n, n}); }
    stretches.back().end = n + 1;
  }
  return stretches;
}

Stretch longest_stretch(std::span<const double> value) {
  Stretch longest;
  for (const Stretch& stretch : finite_stretches(value)) {
    if (stretch.size() > longest.size()) { longest = stretch; }
  }
  return longest;
}

double quantile(std::span<const double> value, double q) {
  std::vector<double> sorted = finite_only(value);
  if (sorted.empty()) { return not_measured; }
  const double place = q * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::ptrdiff_t>(std::floor(place));
  std::ranges::nth_element(sorted, sorted.begin() + below);
  const double low = sorted[static_cast<std::size_t>(below)];
  const auto next = sorted.begin() + below + 1;
  if (next == sorted.end()) { return low; }
  return low + (place - std::floor(place)) * (*std::min_element(next, sorted.end()) - low);
}

std::vector<double> finite_only(std::span<const double> value) {
  std::vector<double> finite;
  std::ranges::copy_if(value, std::back_inserter(finite), [](double v) { return std::isfinite(v); });
  return finite;
}

double usual_interval(std::span<const double> time) {
  std::vector<double> intervals;
  for (std::size_t n = 1; n < time.size(); ++n) { intervals.push_back(time[n] - time[n - 1]); }
  return quantile(intervals, 0.5);
}

Grid grid_between(double begin, double end, double anchor, double step) {
  constexpr double slack = 1e-6;  // of a step, for the rounding of times
  const double first = std::ceil((begin - anchor) / step - slack);
  const double last = std::floor((end - anchor) / step + slack);
  if (!(last >= first)) { return {begin, step, 0}; }
  return {anchor + first * step, step, static_cast<std::size_t>(last - first) + 1};
}

namespace {

/// The value at t between samples i and i + 1, one of which may be t's own.
double value_between(std::span<const double> time, std::span<const double> value, std::size_t i, double t,
                     double usual) {
  const double slack = 1e-4 * usual;
  if (t - time[i] <= slack) { return value[i]; }
  if (i + 1 == time.size()) { return not_measured; }
  const double interval = time[i + 1] - time[i];
  if (time[i + 1] - t <= slack) { return value[i + 1]; }
  if (interval > longest_bridge * usual) { return not_measured; }
  const double share = (t - time[i]) / interval;
  return value[i] + share * (value[i + 1] - value[i]);  // NaN when either is
}

}  // namespace

Samples resample(std::span<const double> time, std::span<const double> value, const Grid& grid) {
  Samples samples{grid.start, grid.step, std::vector<double>(grid.count, not_measured)};
  if (time.empty() || value.size() != time.size()) { return samples; }
  const double usual = time.size() > 1 ? usual_interval(time) : grid.step;
  std::size_t i = 0;
  for (std::size_t n = 0; n < grid.count; ++n) {
    const double t = samples.time(n);
    if (t < time.front() - 1e-4 * usual) { continue; }
    while (i + 1 < time.size() && time[i + 1] <= t) { ++i; }
    const double found = value_between(time, value, i, t, usual);
    samples.value[n] = std::isfinite(found) ? found : not_measured;  // an infinite sample is a gap too
  }
  return samples;
}

Samples resample(const Samples& samples, const Grid& grid) {
  std::vector<double> time(samples.size());
  for (std::size_t n = 0; n < time.size(); ++n) { time[n] = samples.time(n); }
  return resample(time, samples.value, grid);
}

Samples regular(std::span<const double> time, std::span<const double> value) {
  if (time.size() < 2) { return {}; }
  const double step = usual_interval(time);
  return resample(time, value, grid_between(time.front(), time.back(), time.front(), step));
}

}  // namespace palpate::comparison
