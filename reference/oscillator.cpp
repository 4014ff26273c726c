// SPDX-License-Identifier: MIT

#include "reference/oscillator.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>

namespace palpate::reference {

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
