// SPDX-License-Identifier: MIT

#include "validation/signal.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

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
  const std::vector<Stretch> stretches = finite_stretches(value);
  return stretches.empty() ? Stretch{} : *std::ranges::max_element(stretches, {}, &Stretch::size);
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
  std::vector<double> finite(value.begin(), value.end());
  std::erase_if(finite, [](double v) { return !std::isfinite(v); });
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

/// Interpolates at t between samples i and i + 1; an instant close to a sample takes its value.
double value_between(std::span<const double> time, std::span<const double> value, std::size_t i,
                     double t, double usual) {
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
    if (std::isfinite(found)) { samples.value[n] = found; }  // an infinite sample is a gap too
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

namespace {

/// Second-order Butterworth by the bilinear transform, its cut-off prewarped.
struct Biquad {
  double b0 = 1.0;
  double a1 = 0.0;
  double a2 = 0.0;

  /// Filters in place, from the steady state of the first value.
  void run(std::span<double> value) const {
    double late = (b0 - a2) * value.front();
    double later = (1.0 - b0) * value.front();
    for (double& v : value) {
      const double in = v;
      v = b0 * in + later;
      later = 2.0 * b0 * in - a1 * v + late;
      late = b0 * in - a2 * v;
    }
  }
};

Biquad butterworth(double cutoff, double rate) {
  const double k = std::tan(std::numbers::pi * cutoff / rate);
  const double norm = 1.0 / (1.0 + std::numbers::sqrt2 * k + k * k);
  return {k * k * norm, 2.0 * (k * k - 1.0) * norm, (1.0 - std::numbers::sqrt2 * k + k * k) * norm};
}

void filter_stretch(std::span<double> value, const Biquad& filter, std::size_t wanted) {
  if (value.size() < 3) { return; }
  const std::size_t pad = std::min(wanted, value.size() - 1);
  std::vector<double> work(value.size() + 2 * pad);
  const std::size_t last = value.size() - 1;
  for (std::size_t n = 1; n <= pad; ++n) {
    work[pad - n] = 2.0 * value[0] - value[n];
    work[pad + last + n] = 2.0 * value[last] - value[last - n];
  }
  std::ranges::copy(value, work.begin() + static_cast<std::ptrdiff_t>(pad));
  filter.run(work);
  std::ranges::reverse(work);
  filter.run(work);
  std::ranges::reverse(work);
  std::copy_n(work.begin() + static_cast<std::ptrdiff_t>(pad), value.size(), value.begin());
}

}  // namespace

bool can_filter(double cutoff, double rate) { return cutoff > 0.0 && cutoff < 0.4 * rate; }

Samples zero_phase(const Samples& samples, double cutoff) {
  const double rate = 1.0 / samples.step;
  if (!can_filter(cutoff, rate)) { return samples; }
  const Biquad filter = butterworth(cutoff, rate);
  const auto pad = static_cast<std::size_t>(std::ceil(3.0 * rate / cutoff));
  Samples filtered = samples;
  for (const Stretch& stretch : finite_stretches(samples.value)) {
    filter_stretch(std::span(filtered.value).subspan(stretch.begin, stretch.size()), filter, pad);
  }
  return filtered;
}

NoiseShares noise_shares(double cutoff, double rate) {
  if (!can_filter(cutoff, rate)) { return {}; }
  const double k = std::tan(std::numbers::pi * cutoff / rate);
  constexpr int count = 2000;
  NoiseShares shares{.passed = 0.0, .removed = 0.0};
  for (int n = 0; n < count; ++n) {
    const double w = std::tan(0.5 * std::numbers::pi * (n + 0.5) / count) / k;
    const double gain = 1.0 / (1.0 + std::pow(w, 4));
    shares.passed += gain * gain / count;
    shares.removed += (1.0 - gain) * (1.0 - gain) / count;
  }
  return shares;
}

TraceErrors trace_errors(std::span<const double> simulated, std::span<const double> recorded) {
  TraceErrors errors;
  double ss = 0.0;
  double rr = 0.0;
  double sr = 0.0;
  double sum = 0.0;
  double square = 0.0;
  double smallest = std::numeric_limits<double>::infinity();
  double largest = -smallest;
  for (std::size_t n = 0; n < std::min(simulated.size(), recorded.size()); ++n) {
    const double s = simulated[n];
    const double r = recorded[n];
    if (!std::isfinite(s) || !std::isfinite(r)) { continue; }
    ++errors.samples;
    ss += s * s;
    rr += r * r;
    sr += s * r;
    sum += s - r;
    square += (s - r) * (s - r);
    smallest = std::min(smallest, r);
    largest = std::max(largest, r);
  }
  const auto count = static_cast<double>(errors.samples);  // 0 / 0 below is NaN: not defined
  errors.rmse = std::sqrt(square / count);
  errors.nrmse = largest > smallest ? errors.rmse / (largest - smallest) : std::nan("");
  errors.mean = sum / count;
  errors.magnitude = rr > 0.0 ? std::sqrt(ss / rr) - 1.0 : std::nan("");
  errors.phase = ss > 0.0 && rr > 0.0 ? std::acos(std::clamp(sr / std::sqrt(ss * rr), -1.0, 1.0)) *
                                            std::numbers::inv_pi
                                      : std::nan("");
  errors.combined = std::hypot(errors.magnitude, errors.phase);
  return errors;
}

}  // namespace palpate::comparison

namespace palpate {

using comparison::not_measured;

std::vector<double> tick_times(double step, long count) {
  std::vector<double> times;
  for (long n = 0; n <= count; ++n) { times.push_back(static_cast<double>(n) * step); }
  return times;
}

TrajectoryError trajectory_error(const Eigen::Ref<const Eigen::MatrixXd>& candidate,
                                 const Eigen::Ref<const Eigen::MatrixXd>& truth,
                                 const Eigen::Ref<const Eigen::VectorXd>& start) {
  const bool comparable = candidate.rows() == truth.rows() && candidate.cols() == truth.cols() &&
                          truth.size() > 0 && start.size() == truth.rows() &&
                          candidate.allFinite() && truth.allFinite() && start.allFinite();
  if (!comparable) { return {not_measured, not_measured, not_measured, not_measured}; }
  const Eigen::MatrixXd motion = truth.colwise() - Eigen::VectorXd(start);
  const Eigen::MatrixXd difference = candidate - truth;
  TrajectoryError error;
  error.peak = motion.cwiseAbs().maxCoeff();
  error.maximum = difference.cwiseAbs().maxCoeff() / error.peak;
  error.l2 = difference.norm() / motion.norm();
  error.final = difference.rightCols(1).cwiseAbs().maxCoeff() / error.peak;
  return error;
}

ObservedOrder observed_order(std::span<const double> h, std::span<const double> error, double floor,
                             double ceiling) {
  std::vector<double> x;
  std::vector<double> y;
  ObservedOrder order;
  order.monotone = true;
  for (std::size_t n = 0; n < h.size() && n < error.size(); ++n) {
    if (!(error[n] > floor && error[n] < ceiling)) { continue; }
    x.push_back(std::log(h[n]));
    y.push_back(std::log(error[n]));
    const std::size_t last = x.size() - 1;
    if (last > 0 && (x[last] - x[last - 1]) * (y[last] - y[last - 1]) <= 0.0) {
      order.monotone = false;
    }
  }
  order.rungs = static_cast<int>(x.size());
  if (order.rungs < 4) {
    order.slope = order.r_squared = not_measured;
    return order;
  }
  const Eigen::Map<const Eigen::ArrayXd> log_h(x.data(), order.rungs);
  const Eigen::Map<const Eigen::ArrayXd> log_e(y.data(), order.rungs);
  const Eigen::ArrayXd dx = log_h - log_h.mean();
  const Eigen::ArrayXd dy = log_e - log_e.mean();
  order.slope = (dx * dy).sum() / dx.square().sum();
  order.r_squared = std::pow((dx * dy).sum(), 2) / (dx.square().sum() * dy.square().sum());
  return order;
}

GridConvergence grid_convergence(std::span<const double> h, std::span<const double> value) {
  const std::size_t n = value.size() - 1;
  const double step = value[n] - value[n - 1];
  const double before = value[n - 1] - value[n - 2];
  const double fine = h[n - 1] / h[n];
  const double coarse = h[n - 2] / h[n - 1];
  const double sign = before * step < 0.0 ? -1.0 : 1.0;
  double order = 1.0;
  for (int round = 0; round < 50; ++round) {  // fixed point; exact at once for equal ratios
    const double uneven = (std::pow(fine, order) - sign) / (std::pow(coarse, order) - sign);
    order = (std::log(std::abs(before / step)) + std::log(uneven)) / std::log(fine);
    order = std::clamp(order, -10.0, 10.0);
  }
  const bool seen = order >= 0.5 && order <= 2.5;
  const double index =
      (seen ? 1.25 : 3.0) * std::abs(step / value[n]) / (std::pow(fine, seen ? order : 1.0) - 1.0);
  return {order, index};
}

}  // namespace palpate
