// SPDX-License-Identifier: MIT
#pragma once
/// The edge of what is possible: the least cost for an error, and the least error for a cost.

#include <span>
#include <string>
#include <vector>

namespace palpate::bench {

/// One way of computing a motion.
struct Effort {
  std::string method{};
  double cost = 0.0;   ///< > 0, evaluations of the force
  double error = 0.0;  ///< > 0, over the peak
};

/// Least cost of any method for an error, on the straight lines between its points where both axes are logarithmic. A
/// method whose cheapest point is nearer still costs what that one costs; NaN where none comes so near.
double cost_at(std::span<const Effort> efforts, double error);

/// Decimal digits that the best method has for a cost, likewise; beyond its dearest point it has those of that one.
/// NaN where none is so cheap.
double digits_at(std::span<const Effort> efforts, double cost);

}  // namespace palpate::bench
