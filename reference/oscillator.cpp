// SPDX-License-Identifier: MIT

#include "reference/oscillator.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>

namespace palpate::reference {

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

namespace {

using Real = long double;
using Make = Amplification (*)(Real stiffness, Real damping, Real h);  // k/m [1/s^2], c/m [1/s]

Amplification matrix(Real xx, Real xv, Real vx, Real vv) {
  Amplification a;
  a << xx, xv, vx, vv;
  return a;
}

/// Returns L of d(x, v)/dt = L (x, v).
Amplification generator(Real stiffness, Real damping) { return matrix(0, 1, -stiffness, -damping); }

Amplification euler(Real k, Real c, Real h) {
  return Amplification::Identity() + h * generator(k, c);
}

Amplification kick(Real k, Real c, Real h) { return matrix(1, 0, -h * k, 1 - h * c); }
Amplification drift(Real h) { return matrix(1, h, 0, 1); }

Amplification euler_cromer(Real k, Real c, Real h) { return drift(h) * kick(k, c, h); }
Amplification feynman_newton(Real k, Real c, Real h) { return kick(k, c, h) * drift(h); }

Amplification leapfrog(Real k, Real c, Real h) {
  const Real half_drag = c * h / 2;
  return matrix(1, 0, -h * k / (1 + half_drag), (1 - half_drag) / (1 + half_drag)) * drift(h);
}

Amplification velocity_verlet(Real k, Real c, Real h) {
  // Rows of a = -k x - c v, of x', of the predicted velocity v + h a, and of a' = -k x' - c (v + h
  // a).
  using Row = Eigen::Matrix<Real, 1, 2>;
  const Row x(1, 0), v(0, 1), a(-k, -c);
  const Row x_next = x + h * v + h * h / 2 * a;
  const Row a_next = -k * x_next - c * (v + h * a);
  Amplification result;
  result << x_next, v + h / 2 * (a + a_next);
  return result;
}

Amplification rk4(Real k, Real c, Real h) {
  const Amplification step = h * generator(k, c);
  Amplification term = Amplification::Identity();
  Amplification sum = term;
  for (int n = 1; n <= 4; ++n) {
    term = (term * step / Real(n)).eval();
    sum += term;
  }
  return sum;
}

Amplification implicit_euler(Real k, Real c, Real h) {
  return (Amplification::Identity() - h * generator(k, c)).inverse();
}

Amplification implicit_midpoint(Real k, Real c, Real h) {
  const Amplification half = h / 2 * generator(k, c);
  return (Amplification::Identity() - half).inverse() * (Amplification::Identity() + half);
}

struct Scheme {
  std::string_view name;
  Make make;
  bool staggered;
};

constexpr Scheme schemes[] = {
    {"euler", euler, false},
    {"euler-cromer", euler_cromer, false},
    {"feynman-newton", feynman_newton, true},
    {"feynman-newton-printed", feynman_newton, false},
    {"leapfrog", leapfrog, true},
    {"velocity-verlet", velocity_verlet, false},
    {"rk4", rk4, false},
    {"implicit-euler", implicit_euler, false},
    {"implicit-midpoint", implicit_midpoint, false},
};

const Scheme& find(std::string_view name) {
  const auto* scheme = std::ranges::find(schemes, name, &Scheme::name);
  if (scheme == std::end(schemes)) {
    throw std::invalid_argument("no closed form of a scheme named " + std::string(name));
  }
  return *scheme;
}

/// Returns the theoretical limit of h omega0 for S >= 0, if known
/// (model/EQUATIONS.md, "Stepping schemes").
std::optional<double> known_limit(std::string_view name, double s) {
  if (name == "implicit-euler" || name == "implicit-midpoint") {
    return std::numeric_limits<double>::infinity();
  }
  if (name == "euler") { return s < 1.0 ? 2.0 * s : 2.0 / (s + std::sqrt(s * s - 1.0)); }
  if (name == "leapfrog") { return 2.0; }
  if (name == "euler-cromer" || name.starts_with("feynman-newton")) {
    return 2.0 / (std::sqrt(1.0 + s * s) + s);  // = 2 (sqrt(1 + S^2) - S) without cancellation
  }
  if (name == "rk4" && s == 0.0) { return 2.0 * std::sqrt(2.0); }
  return std::nullopt;
}

/// Finds the first crossing of spectral radius 1 over h omega0, by scanning and bisection.
double searched_limit(const Scheme& scheme, Real s) {
  constexpr Real rounding = 1e-15L;
  const auto stable = [&](Real h) {
    return spectral_radius(scheme.make(1, 2 * s, h)) <= 1 + rounding;
  };
  Real good = 0;
  Real step = 1e-3L / (1 + s);  // a real root reaches -1 near h omega0 = 1 / S
  for (Real bad = step; bad < 1e3L; bad += step) {
    if (stable(bad)) {
      good = bad;
      continue;
    }
    while (bad - good > 1e-17L * bad) {
      const Real middle = (good + bad) / 2;
      if (middle == good || middle == bad) { break; }
      (stable(middle) ? good : bad) = middle;
    }
    return static_cast<double>(good);
  }
  return std::numeric_limits<double>::infinity();
}

Amplification power(Amplification base, long exponent) {
  Amplification result = Amplification::Identity();
  for (; exponent > 0; exponent /= 2) {
    if (exponent % 2 == 1) { result = (result * base).eval(); }
    base = (base * base).eval();
  }
  return result;
}

}  // namespace

const std::vector<std::string_view>& discrete_schemes() {
  static const std::vector<std::string_view> names = [] {
    std::vector<std::string_view> all;
    for (const Scheme& scheme : schemes) { all.push_back(scheme.name); }
    return all;
  }();
  return names;
}

bool velocity_is_staggered(std::string_view scheme) { return find(scheme).staggered; }

Amplification amplification(std::string_view scheme, const Oscillator& oscillator, double h) {
  const Real mass = oscillator.mass;
  return find(scheme).make(oscillator.stiffness / mass, oscillator.viscosity / mass, h);
}

DiscreteState discrete_start(std::string_view scheme, const Oscillator& o, double h) {
  DiscreteState start(o.displacement, o.velocity);
  if (velocity_is_staggered(scheme)) {
    const Real force = -Real(o.stiffness) * start(0) - Real(o.viscosity) * start(1);
    start(1) += Real(h) / 2 * force / Real(o.mass);
  }
  return start;
}

DiscreteState discrete_state(std::string_view scheme, const Oscillator& oscillator, double h,
                             long steps) {
  return power(amplification(scheme, oscillator, h), steps) * discrete_start(scheme, oscillator, h);
}

long double spectral_radius(const Amplification& a) {
  const Real half_trace = (a(0, 0) + a(1, 1)) / 2;
  const Real half_gap = (a(0, 0) - a(1, 1)) / 2;
  const Real discriminant = half_gap * half_gap + a(0, 1) * a(1, 0);
  if (discriminant < 0) { return std::sqrt(std::abs(a(0, 0) * a(1, 1) - a(0, 1) * a(1, 0))); }
  return std::abs(half_trace) + std::sqrt(discriminant);
}

double stability_limit(std::string_view name, double omega0, double damping_ratio) {
  const Scheme& scheme = find(name);
  if (damping_ratio < 0.0) { return 0.0; }  // the exact motion itself grows
  const std::optional<double> known = known_limit(name, damping_ratio);
  return (known ? *known : searched_limit(scheme, damping_ratio)) / omega0;
}

}  // namespace palpate::reference
