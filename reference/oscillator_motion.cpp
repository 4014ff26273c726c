// SPDX-License-Identifier: MIT

#include "reference/oscillator_motion.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

namespace palpate {

namespace {

/// Functions cos(sqrt(z)) and sin(sqrt(z)) / sqrt(z), continued to z <= 0 as cosh and sinh. They
/// are analytic in z and express every free motion without a singularity at S = 1.
struct Circular {
  double cosine;
  double sine_over_root;
};

Circular circular(double z) {
  if (std::abs(z) < 1e-3) {  // Taylor; the next term is below 1e-21
    return {
        1.0 - z / 2.0 * (1.0 - z / 12.0 * (1.0 - z / 30.0 * (1.0 - z / 56.0 * (1.0 - z / 90.0)))),
        1.0 - z / 6.0 * (1.0 - z / 20.0 * (1.0 - z / 42.0 * (1.0 - z / 72.0 * (1.0 - z / 110.0))))};
  }
  const double root = std::sqrt(std::abs(z));
  if (z > 0.0) { return {std::cos(root), std::sin(root) / root}; }
  return {std::cosh(root), std::sinh(root) / root};
}

/// Returns the free motion x'' + 2 gamma x' + omega0^2 x = 0 from (x0, v0).
OscillatorState free_motion(double gamma, double omega0_squared, double x0, double v0, double t) {
  const double z = (omega0_squared - gamma * gamma) * t * t;
  if (z < -1.0) {
    // Overdamped: two real rates, in a form without cancellation or overflow.
    const double root = std::sqrt(gamma * gamma - omega0_squared);
    const double fast = gamma >= 0.0 ? -(gamma + root) : -gamma + root;
    const double slow = fast != 0.0 ? omega0_squared / fast : 0.0;
    const double b = (v0 - slow * x0) / (fast - slow);
    const double a = x0 - b;
    const double ea = std::exp(slow * t);
    const double eb = std::exp(fast * t);
    return {a * ea + b * eb, a * slow * ea + b * fast * eb};
  }
  const auto [c, s] = circular(z);
  const double decay = std::exp(-gamma * t);
  return {decay * (x0 * c + (v0 + gamma * x0) * t * s),
          decay * (v0 * c - (gamma * v0 + omega0_squared * x0) * t * s)};
}

using Complex = std::complex<double>;

/// Returns the first divided difference of z -> exp(z t) at a and b, without cancellation for a
/// near b.
Complex exponential_difference(Complex a, Complex b, double t) {
  const Complex half = 0.5 * (a - b) * t;
  if (std::abs(half) > 1.0) { return (std::exp(a * t) - std::exp(b * t)) / (a - b); }
  Complex sinhc = 1.0;
  Complex term = 1.0;
  for (int n = 1; n < 12; ++n) {  // |half| <= 1: the last term is below 1e-22
    term *= half * half / static_cast<double>(2 * n * (2 * n + 1));
    sinhc += term;
  }
  return t * std::exp(0.5 * (a + b) * t) * sinhc;
}

/// Returns the second divided difference of z -> exp(z t): the motion from rest of x'' - (b + c) x'
/// + b c x = exp(a t), also at resonance and for two equal free rates.
Complex exponential_difference(Complex a, Complex b, Complex c, double t) {
  const double ab = std::abs(a - b);
  const double bc = std::abs(b - c);
  const double ca = std::abs(c - a);
  if (std::max({ab, bc, ca}) * t < 0.5) {  // all close: Taylor series about their mean
    const Complex mean = (a + b + c) / 3.0;
    const Complex za = (a - mean) * t;
    const Complex zb = (b - mean) * t;
    const Complex zc = (c - mean) * t;
    Complex power_c = 1.0;  // complete homogeneous polynomials h_n(zc), h_n(zb, zc), h_n(all)
    Complex power_bc = 1.0;
    Complex power_abc = 1.0;
    double factorial = 2.0;
    Complex sum = 0.5;
    for (int n = 1; n < 18; ++n) {
      power_c *= zc;
      power_bc = zb * power_bc + power_c;
      power_abc = za * power_abc + power_bc;
      factorial *= n + 2;
      sum += power_abc / factorial;
    }
    return t * t * std::exp(mean * t) * sum;
  }
  if (ab >= bc && ab >= ca) {
    return (exponential_difference(a, c, t) - exponential_difference(b, c, t)) / (a - b);
  }
  if (bc >= ca) {
    return (exponential_difference(b, a, t) - exponential_difference(c, a, t)) / (b - c);
  }
  return (exponential_difference(c, b, t) - exponential_difference(a, b, t)) / (c - a);
}

/// Returns the motion from rest of x'' + 2 gamma x' + omega0^2 x = cos(w t), transient and steady
/// state together.
OscillatorState driven_from_rest(double gamma, double omega0_squared, double w, double t) {
  const Complex root = std::sqrt(Complex(gamma * gamma - omega0_squared, 0.0));
  const Complex fast = gamma >= 0.0 ? -gamma - root : -gamma + root;
  const Complex slow = fast != 0.0 ? omega0_squared / fast : Complex(0.0);
  const Complex drive(0.0, w);
  const Complex position = exponential_difference(drive, fast, slow, t);
  const Complex velocity = drive * position + exponential_difference(fast, slow, t);
  return {position.real(), velocity.real()};
}

}  // namespace

double damping_ratio(const Oscillator& o) {
  return o.viscosity / (2.0 * std::sqrt(o.mass * o.stiffness));
}

const char* damping_class(const Oscillator& o) {
  if (o.drive_amplitude != 0.0) { return "driven"; }
  const double discriminant = o.viscosity * o.viscosity - 4.0 * o.mass * o.stiffness;
  if (o.viscosity < 0.0) { return "negatively damped"; }
  if (o.viscosity == 0.0) { return "undamped"; }
  if (discriminant == 0.0) { return "critically damped"; }
  return discriminant < 0.0 ? "underdamped" : "overdamped";
}

OscillatorState exact_motion(const Oscillator& o, double t) {
  const double gamma = o.viscosity / (2.0 * o.mass);
  const double omega0_squared = o.stiffness / o.mass;
  if (o.drive_amplitude == 0.0) {
    return free_motion(gamma, omega0_squared, o.displacement, o.velocity, t);
  }
  const OscillatorState free = free_motion(gamma, omega0_squared, o.displacement, o.velocity, t);
  const OscillatorState driven = driven_from_rest(gamma, omega0_squared, o.drive_frequency, t);
  const double f = o.drive_amplitude / o.mass;
  return {free.position + f * driven.position, free.velocity + f * driven.velocity};
}

double equation_6_printed(const Oscillator& o, double amplitude, double t) {
  const double phase = 0.0;
  return amplitude * std::exp(-o.viscosity / (2.0 * o.mass) * t) *
         std::cos(std::sqrt(o.stiffness / o.mass) * t * phase);
}

double equation_6_plotted(const Oscillator& o, double amplitude, double phase, double t) {
  return amplitude * std::exp(-o.viscosity / (2.0 * o.mass) * t) *
         std::cos(std::sqrt(o.stiffness / o.mass) * t + phase);
}

}  // namespace palpate
