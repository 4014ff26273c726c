// SPDX-License-Identifier: MIT
#pragma once
/// Distance of a curve from a tube around another.

#include <vector>

namespace palpate::gate {

/// A curve over rising x, in the coordinates that are compared.
struct Path {
  std::vector<double> x{};
  std::vector<double> y{};
};

/// Half widths, in the coordinates of the paths.
struct Tube {
  double x = 0.0;
  double y = 0.0;
};

/// Where two curves are furthest apart, by their own reckoning: how far a point of the one lies beyond all that
/// the other does within the tube's half width in x.
struct Excess {
  double y = 0.0;  ///< beyond the other's range there; 0: within it
  double x = 0.0;  ///< where
};

/// Largest excess of a point of either over the other; x of both rises, neither is empty, all is finite. What
/// lies beyond the end of a curve by more than tube.x is infinitely far from it.
Excess largest_excess(const Path& before, const Path& now, double half_width_x);

}  // namespace palpate::gate
