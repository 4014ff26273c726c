// SPDX-License-Identifier: MIT
#include "reference/mode_response.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::reference {

namespace {

/// cos(sqrt(z)) and sin(sqrt(z)) / sqrt(z), analytic in z.
template <class Real>
ModeState<Real> circular(Real z) {
  if (std::abs(z) < Real(1)) {
    Real cosine = 1, sine = 1, cosine_term = 1, sine_term = 1;
    for (int n = 1; n < 14; ++n) {
      cosine_term *= -z / Real((2 * n - 1) * (2 * n));
      sine_term *= -z / Real((2 * n) * (2 * n + 1));
      cosine += cosine_term;
      sine += sine_term;
    }
    return {cosine, sine};
  }
  const Real root = std::sqrt(std::abs(z));
  if (z > 0) { return {std::cos(root), std::sin(root) / root}; }
  return {std::cosh(root), std::sinh(root) / root};
}

template <class Real>
using Harmonic = typename ModeForce<Real>::Harmonic;

/// Particular solution for one harmonic: amplitudes of its cosine and sine.
template <class Real>
Harmonic<Real> steady(const Mode<Real>& mode, const Harmonic<Real>& force) {
  const Real w = force.frequency;
  const Real detuning = mode.omega_squared - w * w;
  const Real drag = 2 * mode.gamma * w;
  const Real norm = detuning * detuning + drag * drag;
  return {w, (detuning * force.cosine - drag * force.sine) / norm,
          (drag * force.cosine + detuning * force.sine) / norm};
}

/// Whether the particular solution is much larger than the motion, so that digits would cancel.
template <class Real>
bool cancels(const Mode<Real>& mode, const ModeForce<Real>& force, Real t) {
  constexpr Real close = Real(0.1);
  const Real elastic = std::abs(mode.omega_squared);
  if ((force.constant != 0 || force.slope != 0) && elastic * t * t < close) { return true; }
  if (force.slope != 0 && std::abs(mode.gamma) > 10 * elastic * t) { return true; }
  return std::ranges::any_of(force.harmonics, [&](const Harmonic<Real>& h) {
    const Real square = h.frequency * h.frequency;
    const Real size = std::hypot(mode.omega_squared - square, 2 * mode.gamma * h.frequency);
    return size * t * t < close || size < close * std::max(elastic, square);
  });
}

template <class Real>
ModeState<Real> particular(const Mode<Real>& mode, const ModeForce<Real>& force, Real t) {
  ModeState<Real> state;
  if (force.constant != 0 || force.slope != 0) {
    const Real drift = force.slope / mode.omega_squared;
    state.position = (force.constant - 2 * mode.gamma * drift) / mode.omega_squared + drift * t;
    state.velocity = drift;
  }
  for (const Harmonic<Real>& h : force.harmonics) {
    const Harmonic<Real> s = steady(mode, h);
    const Real cosine = std::cos(h.frequency * t);
    const Real sine = std::sin(h.frequency * t);
    state.position += s.cosine * cosine + s.sine * sine;
    state.velocity += h.frequency * (s.sine * cosine - s.cosine * sine);
  }
  return state;
}

template <class Real>
using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;

/// Exponential by scaling and squaring of the Taylor series; the norm is halved to below 1/4.
template <class Real>
Matrix<Real> exponential(const Matrix<Real>& matrix) {
  const Real norm = matrix.cwiseAbs().rowwise().sum().maxCoeff();
  const int halvings = norm > Real(0.25) ? static_cast<int>(std::ceil(std::log2(norm * 4))) : 0;
  const Matrix<Real> small = matrix * std::ldexp(Real(1), -halvings);
  Matrix<Real> term = Matrix<Real>::Identity(matrix.rows(), matrix.cols());
  Matrix<Real> sum = term;
  for (int n = 1; n < 18; ++n) {
    term = (term * small / Real(n)).eval();
    sum += term;
  }
  for (int n = 0; n < halvings; ++n) { sum = (sum * sum).eval(); }
  return sum;
}

/// [eta, eta'/rate, 1, t rate, (cos, sin) of each harmonic] obeys one linear system.
template <class Real>
ModeState<Real> coupled_response(const Mode<Real>& mode, const ModeState<Real>& initial,
                                 const ModeForce<Real>& force, Real t) {
  const auto count = static_cast<Eigen::Index>(force.harmonics.size());
  Real rate = std::max(std::sqrt(std::abs(mode.omega_squared)), 1 / t);
  for (const Harmonic<Real>& h : force.harmonics) { rate = std::max(rate, std::abs(h.frequency)); }
  Matrix<Real> generator = Matrix<Real>::Zero(4 + 2 * count, 4 + 2 * count);
  Eigen::Matrix<Real, Eigen::Dynamic, 1> start(4 + 2 * count);
  start.setZero();
  start.template head<3>() << initial.position, initial.velocity / rate, Real(1);
  generator(0, 1) = rate;
  generator.template block<1, 4>(1, 0) << -mode.omega_squared / rate, -2 * mode.gamma,
      force.constant / rate, force.slope / (rate * rate);
  generator(3, 2) = rate;
  for (Eigen::Index k = 0; k < count; ++k) {
    const Harmonic<Real>& h = force.harmonics[static_cast<std::size_t>(k)];
    const Eigen::Index c = 4 + 2 * k;
    generator(1, c) = h.cosine / rate;
    generator(1, c + 1) = h.sine / rate;
    generator(c, c + 1) = -h.frequency;
    generator(c + 1, c) = h.frequency;
    start(c) = 1;
  }
  const Eigen::Matrix<Real, Eigen::Dynamic, 1> end = exponential<Real>(generator * t) * start;
  return {end(0), end(1) * rate};
}

}  // namespace

template <class Real>
ModeState<Real> free_response(const Mode<Real>& mode, const ModeState<Real>& initial, Real t) {
  const Real x0 = initial.position;
  const Real v0 = initial.velocity;
  const Real gamma = mode.gamma;
  const Real z = (mode.omega_squared - gamma * gamma) * t * t;
  if (z < Real(-1)) {  // two real rates, written so that neither cancels nor overflows
    const Real root = std::sqrt(gamma * gamma - mode.omega_squared);
    const Real one = gamma >= 0 ? -(gamma + root) : root - gamma;
    const Real other = mode.omega_squared / one;
    const Real b = (v0 - other * x0) / (one - other);
    const Real a = x0 - b;
    const Real ea = std::exp(other * t);
    const Real eb = std::exp(one * t);
    return {a * ea + b * eb, a * other * ea + b * one * eb};
  }
  const auto [c, s] = circular(z);
  const Real decay = std::exp(-gamma * t);
  return {decay * (x0 * c + (v0 + gamma * x0) * t * s),
          decay * (v0 * c - (gamma * v0 + mode.omega_squared * x0) * t * s)};
}

template <class Real>
ModeState<Real> respond(const Mode<Real>& mode, const ModeState<Real>& initial,
                        const ModeForce<Real>& force, Real t) {
  if (t == 0) { return initial; }
  if (cancels(mode, force, t)) { return coupled_response(mode, initial, force, t); }
  const ModeState<Real> before = particular(mode, force, Real(0));
  const ModeState<Real> now = particular(mode, force, t);
  const ModeState<Real> free = free_response<Real>(
      mode, {initial.position - before.position, initial.velocity - before.velocity}, t);
  return {now.position + free.position, now.velocity + free.velocity};
}

template ModeState<double> free_response(const Mode<double>&, const ModeState<double>&, double);
template ModeState<long double> free_response(const Mode<long double>&,
                                              const ModeState<long double>&, long double);
template ModeState<double> respond(const Mode<double>&, const ModeState<double>&,
                                   const ModeForce<double>&, double);
template ModeState<long double> respond(const Mode<long double>&, const ModeState<long double>&,
                                        const ModeForce<long double>&, long double);

}  // namespace palpate::reference
