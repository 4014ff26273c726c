// SPDX-License-Identifier: MIT
#pragma once
/// Value and first two derivatives over one parameter, carried through formulas exactly.

#include <cmath>

namespace palpate::reference {

struct Taylor {
  double value = 0.0;
  double first = 0.0;
  double second = 0.0;
};

inline Taylor operator+(Taylor a, Taylor b) {
  return {a.value + b.value, a.first + b.first, a.second + b.second};
}
inline Taylor operator-(Taylor a, Taylor b) {
  return {a.value - b.value, a.first - b.first, a.second - b.second};
}
inline Taylor operator+(Taylor a, double b) { return {a.value + b, a.first, a.second}; }
inline Taylor operator*(double a, Taylor b) { return {a * b.value, a * b.first, a * b.second}; }
inline Taylor operator*(Taylor a, Taylor b) {
  return {a.value * b.value, a.first * b.value + a.value * b.first,
          a.second * b.value + 2.0 * a.first * b.first + a.value * b.second};
}
/// g(a) from g, g' and g'' at a's value.
inline Taylor chain(Taylor a, double g, double slope, double curvature) {
  return {g, slope * a.first, slope * a.second + curvature * a.first * a.first};
}
inline Taylor inverse(Taylor a) {
  const double g = 1.0 / a.value;
  return chain(a, g, -g * g, 2.0 * g * g * g);
}
inline Taylor sqrt(Taylor a) {
  const double g = std::sqrt(a.value);
  return chain(a, g, 0.5 / g, -0.25 / (g * a.value));
}
inline Taylor acos(Taylor a) {
  const double w = 1.0 - a.value * a.value;
  return chain(a, std::acos(a.value), -1.0 / std::sqrt(w), -a.value / (w * std::sqrt(w)));
}
/// Angle of the point (x, y) from the x axis, x > 0 or y > 0.
inline Taylor angle(Taylor y, Taylor x) {
  // d atan2 = (x dy - y dx) / r^2, and once more.
  const double r2 = x.value * x.value + y.value * y.value;
  const double turn = x.value * y.first - y.value * x.first;
  const double first = turn / r2;
  const double r2_first = 2.0 * (x.value * x.first + y.value * y.first);
  const double turn_first = x.value * y.second - y.value * x.second;
  return {std::atan2(y.value, x.value), first, (turn_first - first * r2_first) / r2};
}

}  // namespace palpate::reference
