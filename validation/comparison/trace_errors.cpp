// SPDX-License-Identifier: MIT
#include "validation/comparison/trace_errors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace palpate::comparison {

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
  errors.phase = ss > 0.0 && rr > 0.0
                     ? std::acos(std::clamp(sr / std::sqrt(ss * rr), -1.0, 1.0)) * std::numbers::inv_pi
                     : std::nan("");
  errors.combined = std::hypot(errors.magnitude, errors.phase);
  return errors;
}

}  // namespace palpate::comparison
