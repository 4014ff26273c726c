// SPDX-License-Identifier: MIT
#include "validation/certificate/pareto_tail.hpp"

#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <gsl/gsl_cdf.h>
#include <limits>
#include <numeric>

namespace palpate::certificate {

namespace {

constexpr double least_shape = -0.5;
constexpr double largest_shape = 3.0;
constexpr double exponential = 1e-7;  // shapes below it are that of the exponential distribution
constexpr double impossible = 1e300;
constexpr int digits = 26;  // bits of a minimum's place: half of a double's

double sum_of(std::span<const double> excess) { return std::accumulate(excess.begin(), excess.end(), 0.0); }

/// - log likelihood of shape and scale.
double unlikeliness(std::span<const double> excess, double shape, double scale) {
  if (!(scale > 0.0)) { return impossible; }
  const auto n = static_cast<double>(excess.size());
  if (std::abs(shape) < exponential) { return n * std::log(scale) + sum_of(excess) / scale; }
  double sum = 0.0;
  for (const double y : excess) {
    const double share = shape * y / scale;
    if (!(share > -1.0)) { return impossible; }
    sum += std::log1p(share);
  }
  return n * std::log(scale) + (1.0 + 1.0 / shape) * sum;
}

/// With theta = xi / sigma the best shape is the mean of log(1 + theta y) (Grimshaw, Technometrics 35, 1993),
/// which leaves one unknown.
struct AlongTheta {
  std::span<const double> excess;
  double largest;

  /// s is log(1 + theta y_max): 0 for the exponential distribution.
  [[nodiscard]] ParetoFit at(double s) const {
    const auto n = static_cast<double>(excess.size());
    const double theta = std::expm1(s) / largest;
    ParetoFit fit{.count = excess.size()};
    if (std::abs(s) < exponential) {
      fit.scale = sum_of(excess) / n;
    } else {
      double sum = 0.0;
      for (const double y : excess) { sum += std::log1p(theta * y); }
      fit.shape = sum / n;
      fit.scale = fit.shape / theta;
    }
    const bool allowed = fit.shape >= least_shape && fit.shape <= largest_shape;
    fit.log_likelihood = allowed ? -unlikeliness(excess, fit.shape, fit.scale) : -impossible;
    return fit;
  }
};

/// log(1 / q) stretched: y_q / sigma of a shape.
double stretch(double shape, double q) {
  const double decades = -std::log(q);
  return std::abs(shape) < exponential ? decades : std::expm1(shape * decades) / shape;
}

/// The largest log likelihood of all shapes whose excess at q is y.
double profile(std::span<const double> excess, double q, double y) {
  const auto cost = [&](double shape) { return unlikeliness(excess, shape, y / stretch(shape, q)); };
  return -boost::math::tools::brent_find_minima(cost, least_shape, largest_shape, digits).second;
}

}  // namespace

double ParetoFit::shape_error() const { return (1.0 + shape) / std::sqrt(static_cast<double>(count)); }

double ParetoFit::exceeded(double y) const {
  if (std::abs(shape) < exponential) { return std::exp(-y / scale); }
  const double base = 1.0 + shape * y / scale;
  return base > 0.0 ? std::pow(base, -1.0 / shape) : 0.0;
}

double ParetoFit::excess_at(double q) const { return scale * stretch(shape, q); }

ParetoFit fit_pareto(std::span<const double> excess) {
  const AlongTheta line{excess, *std::ranges::max_element(excess)};
  constexpr double least = -4.0;  // of log(1 + theta y_max)
  constexpr double most = 16.0;
  constexpr int places = 80;
  constexpr double step = (most - least) / places;
  double best = 0.0;
  double likelihood = line.at(0.0).log_likelihood;
  for (int n = 0; n <= places; ++n) {
    const double s = least + n * step;
    const double here = line.at(s).log_likelihood;
    if (here > likelihood) {
      best = s;
      likelihood = here;
    }
  }
  const auto cost = [&](double s) { return -line.at(s).log_likelihood; };
  const double place = boost::math::tools::brent_find_minima(cost, best - step, best + step, digits).first;
  const ParetoFit found = line.at(place);
  return found.log_likelihood >= likelihood ? found : line.at(best);
}

ExcessInterval excess_interval(const ParetoFit& fit, std::span<const double> excess, double q,
                               double confidence) {
  const double least = fit.log_likelihood - 0.5 * gsl_cdf_chisq_Pinv(confidence, 1.0);
  const auto allowed = [&](double y) { return profile(excess, q, y) >= least; };
  const auto edge = [&](double inside, double outside) {
    constexpr double precision = 1e-4;
    while (std::abs(outside - inside) > precision * inside) {
      const double middle = std::sqrt(inside * outside);
      (allowed(middle) ? inside : outside) = middle;
    }
    return inside;
  };
  const double best = fit.excess_at(q);
  ExcessInterval interval{.lower = 0.0, .upper = std::numeric_limits<double>::infinity()};
  constexpr double far = 1e4;
  double low = best;
  while (low > best / far && allowed(low)) { low /= 2.0; }
  if (low > best / far) { interval.lower = edge(2.0 * low, low); }
  double high = best;
  while (high < best * far && allowed(high)) { high *= 2.0; }
  if (high < best * far) { interval.upper = edge(0.5 * high, high); }
  return interval;
}

}  // namespace palpate::certificate
