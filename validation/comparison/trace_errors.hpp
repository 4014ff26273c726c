// SPDX-License-Identifier: MIT
#pragma once
/// Distances of a whole trace from another. They explain a verdict and never make one: none is sharp on
/// the event (docs/comparison.md has the table of what each is blind to).

#include <cstddef>
#include <span>

namespace palpate::comparison {

/// Over the samples where both are numbers; NaN where a figure is not defined.
struct TraceErrors {
  std::size_t samples = 0;
  double rmse = 0.0;       ///< root mean square of simulated - recorded, in the traces' unit
  double nrmse = 0.0;      ///< rmse over the recorded range, largest - smallest [1]
  double mean = 0.0;       ///< mean of simulated - recorded, in the traces' unit
  double magnitude = 0.0;  ///< Sprague-Geers M = sqrt(sum s^2 / sum r^2) - 1, signed [1]
  double phase = 0.0;      ///< Sprague-Geers P = acos(sum s r / sqrt(sum s^2 sum r^2)) / pi [1]
  double combined = 0.0;   ///< Sprague-Geers C = sqrt(M^2 + P^2) [1]
};
TraceErrors trace_errors(std::span<const double> simulated, std::span<const double> recorded);

}  // namespace palpate::comparison
