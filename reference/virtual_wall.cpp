// SPDX-License-Identifier: MIT
#include "reference/virtual_wall.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace palpate::reference {

namespace {

/// Coefficients of the characteristic polynomial, highest power first, in extended precision.
std::vector<long double> characteristic(const WallLoop& loop, double stiffness) {
  const long double b = loop.viscosity;
  const long double period = loop.period;
  const long double tau = loop.mass / b;
  const long double one_less_a = -std::expm1(-period / tau);
  const long double a = 1.0L - one_less_a;
  const long double n1 = (period - tau * one_less_a) / b;
  const long double n0 = (tau * one_less_a - period * a) / b;
  const long double h1 = stiffness + loop.damping / period;
  const long double h0 = -loop.damping / period;
  std::vector<long double> p(static_cast<std::size_t>(loop.delay) + 4, 0.0L);
  p[0] = 1.0L;
  p[1] = -(1.0L + a);
  p[2] = a;
  const std::size_t last = p.size() - 1;
  p[last - 2] += n1 * h1;
  p[last - 1] += n1 * h0 + n0 * h1;
  p[last] += n0 * h0;
  return p;
}

}  // namespace

double largest_root(const WallLoop& loop, double stiffness) {
  std::vector<long double> p = characteristic(loop, stiffness);
  while (p.size() > 1 && p.back() == 0.0L) { p.pop_back(); }  // roots at zero
  const auto degree = static_cast<Eigen::Index>(p.size()) - 1;
  using Matrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  Matrix companion = Matrix::Zero(degree, degree);
  for (Eigen::Index n = 0; n < degree; ++n) {
    companion(0, n) = -p[static_cast<std::size_t>(n) + 1];
    if (n > 0) { companion(n, n - 1) = 1.0L; }
  }
  return static_cast<double>(companion.eigenvalues().cwiseAbs().maxCoeff());
}

double critical_stiffness(const WallLoop& loop) {
  // Without a wall the root at 1 is that of standing still: any small K must bring it inside.
  double low = 1e-9 * loop.viscosity / loop.period;
  if (!(largest_root(loop, low) < 1.0)) { return 0.0; }
  double high = low;
  while (largest_root(loop, high) < 1.0) { high *= 2.0; }
  while (high - low > 1e-12 * high) {
    const double middle = 0.5 * (low + high);
    (largest_root(loop, middle) < 1.0 ? low : high) = middle;
  }
  return low;
}

double passive_stiffness(const WallLoop& loop) {
  return 2.0 * (loop.viscosity - std::abs(loop.damping)) / loop.period;
}

double linear_rule(const WallLoop& loop) {
  return (loop.viscosity + loop.damping) / ((0.5 + loop.delay) * loop.period);
}

double quantised_stiffness(const WallLoop& loop, double encoder_step, double coulomb_friction) {
  return std::min(2.0 * loop.viscosity / loop.period, 2.0 * coulomb_friction / encoder_step);
}

}  // namespace palpate::reference
