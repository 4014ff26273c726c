// SPDX-License-Identifier: MIT

#include "reference/oscillator.hpp"

#include <cmath>
#include <functional>
#include <map>
#include <string_view>
#include <unsupported/Eigen/MatrixFunctions>
#include <vector>

#include "tests/check.hpp"
#include "tests/reference/sample_problems.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using namespace palpate::reference;

/// Oscillator and drive as one linear system (x, v, cos W t, sin W t), whose matrix exponential
/// does not depend on the damping regime or on resonance.
Eigen::Vector4<long double> truth(const Oscillator& o, double t) {
  Eigen::Matrix4<long double> a = Eigen::Matrix4<long double>::Zero();
  a(0, 1) = 1.0L;
  a.row(1) << -o.stiffness, -o.viscosity, o.drive_amplitude, 0.0L;
  a.row(1) /= o.mass;
  a(2, 3) = -o.drive_frequency;
  a(3, 2) = o.drive_frequency;
  a *= t;
  return a.exp() * Eigen::Vector4<long double>(o.displacement, o.velocity, 1.0L, 0.0L);
}

/// Error of (x, v / omega0), relative to the exact amplitude at that time plus the amplitude of the
/// driven response.
double relative_error(const Oscillator& o, double t) {
  const long double omega = std::sqrt(o.stiffness / o.mass);
  const auto expected = truth(o, t);
  const OscillatorState found = exact_motion(o, t);
  const long double size = std::hypot(expected(0), expected(1) / omega) +
                           std::abs(o.drive_amplitude) / (o.mass * omega * omega);
  return static_cast<double>(
      std::hypot(found.position - expected(0), (found.velocity - expected(1)) / omega) / size);
}

TEST("the exact motion is that of the matrix exponential, in every regime, free and driven") {
  std::vector<double> ratios{-0.3, -0.01, 0.0, 0.01, 0.05, 0.35, 0.9, 1.0, 1.5, 2.0, 4.0};
  for (double gap = 1e-16; gap < 0.2; gap *= 10.0) {
    ratios.insert(ratios.end(), {1.0 - gap, 1.0 + gap});
  }
  for (const double s : ratios) {
    Oscillator o{
        .mass = 2.0, .stiffness = 8.0, .viscosity = 8.0 * s, .displacement = 0.7, .velocity = -1.3};
    // exact_motion promises 1e-13; over omega t = 50 the phase itself rounds to 50 eps.
    for (const double t : {0.0, 0.01, 0.1, 0.3, 1.0, 3.0, 4.0, 10.0, 12.0, 25.0}) {
      CHECK_NEAR(relative_error(o, t), 0.0, 1e-13);
    }
    o.drive_amplitude = 3.0;
    for (const double w : {0.0, 0.5, 1.9, 2.0 - 1e-9, 2.0, 2.0 + 1e-6, 5.0}) {
      o.drive_frequency = w;
      for (const double t : {0.2, 2.0, 20.0}) { CHECK_NEAR(relative_error(o, t), 0.0, 1e-12); }
    }
  }
}

TEST("undamped resonance grows as t sin(w t) F / (2 m w)") {
  const Oscillator o{.mass = 1.0,
                     .stiffness = 4.0,
                     .viscosity = 0.0,
                     .displacement = 0.0,
                     .drive_amplitude = 1.0,
                     .drive_frequency = 2.0};
  for (const double t : {1.0, 10.0, 100.0}) {
    CHECK_NEAR(exact_motion(o, t).position, t * std::sin(2.0 * t) / 4.0, 1e-13 * t);
  }
}

TEST("a free mass with drag slows down exponentially") {
  const Oscillator o{
      .mass = 2.0, .stiffness = 0.0, .viscosity = 1.0, .displacement = 0.0, .velocity = 3.0};
  for (const double t : {0.1, 1.0, 20.0}) {
    CHECK_NEAR(exact_motion(o, t).velocity, 3.0 * std::exp(-0.5 * t), 1e-15);
    CHECK_NEAR(exact_motion(o, t).position, 6.0 * (1.0 - std::exp(-0.5 * t)), 1e-14);
  }
}

TEST("the class of damping follows c, and a drive comes first") {
  Oscillator o{.mass = 1.0, .stiffness = 1.0};
  for (const auto& [c, expected] :
       std::vector<std::pair<double, std::string_view>>{{-0.1, "negatively damped"},
                                                        {0.0, "undamped"},
                                                        {0.7, "underdamped"},
                                                        {1.8, "underdamped"},
                                                        {2.0, "critically damped"},
                                                        {2.1, "overdamped"}}) {
    o.viscosity = c;
    CHECK(std::string_view(damping_class(o)) == expected);
    CHECK_NEAR(damping_ratio(o), 0.5 * c, 1e-15);
  }
  o.drive_amplitude = 1.0;
  CHECK(std::string_view(damping_class(o)) == "driven");
}

TEST("Eq. 6 as printed is a bare decay, and as plotted oscillates at omega0") {
  const Oscillator o{.mass = 1.0, .stiffness = 1.0, .viscosity = 0.3};
  CHECK_NEAR(equation_6_printed(o, 3.0, 2.0), 3.0 * std::exp(-0.3), 1e-15);
  CHECK_NEAR(equation_6_plotted(o, 3.0, 0.2, 2.0), 3.0 * std::exp(-0.3) * std::cos(2.2), 1e-15);
}

using Real = long double;

const Oscillator sample_oscillator{
    .mass = 0.7, .stiffness = 2.3, .viscosity = 0.4, .displacement = 0.9, .velocity = -0.3};

/// Schemes as ordered updates, from the table of the paper and its corrections.
using Update = std::function<void(Real& x, Real& v, Real h)>;

Real acceleration(Real x, Real v) {
  const Oscillator& o = sample_oscillator;
  return -(Real(o.stiffness) * x + Real(o.viscosity) * v) / Real(o.mass);
}

void euler(Real& x, Real& v, Real h) {
  const Real next = v + h * acceleration(x, v);
  x += h * v;
  v = next;
}

void euler_cromer(Real& x, Real& v, Real h) {
  v += h * acceleration(x, v);
  x += h * v;
}

void feynman_newton(Real& x, Real& v, Real h) {
  x += h * v;
  v += h * acceleration(x, v);
}

void leapfrog(Real& x, Real& v, Real h) {
  const Oscillator& o = sample_oscillator;
  const Real drag = Real(o.viscosity) * h / (2 * Real(o.mass));
  x += h * v;
  v = ((1 - drag) * v - h * Real(o.stiffness) / Real(o.mass) * x) / (1 + drag);
}

void velocity_verlet(Real& x, Real& v, Real h) {
  const Real before = acceleration(x, v);
  x += h * v + h * h / 2 * before;
  v += h / 2 * (before + acceleration(x, v + h * before));
}

void rk4(Real& x, Real& v, Real h) {
  const Real x1 = v, v1 = acceleration(x, v);
  const Real x2 = v + h / 2 * v1, v2 = acceleration(x + h / 2 * x1, v + h / 2 * v1);
  const Real x3 = v + h / 2 * v2, v3 = acceleration(x + h / 2 * x2, v + h / 2 * v2);
  const Real x4 = v + h * v3, v4 = acceleration(x + h * x3, v + h * v3);
  x += h / 6 * (x1 + 2 * x2 + 2 * x3 + x4);
  v += h / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
}

/// Acceleration at the fraction `weight` of the step; fixed-point iteration to rounding.
void implicit(Real& x, Real& v, Real h, Real weight) {
  Real x1 = x, v1 = v;
  for (int n = 0; n < 200; ++n) {
    const Real xm = x + weight * (x1 - x), vm = v + weight * (v1 - v);
    x1 = x + h * vm;
    v1 = v + h * acceleration(xm, vm);
  }
  x = x1;
  v = v1;
}

const std::map<std::string_view, Update> updates{
    {"euler", euler},
    {"euler-cromer", euler_cromer},
    {"feynman-newton", feynman_newton},
    {"feynman-newton-printed", feynman_newton},
    {"leapfrog", leapfrog},
    {"velocity-verlet", velocity_verlet},
    {"rk4", rk4},
    {"implicit-euler", [](Real& x, Real& v, Real h) { implicit(x, v, h, 1.0L); }},
    {"implicit-midpoint", [](Real& x, Real& v, Real h) { implicit(x, v, h, 0.5L); }},
};

double observed_order(std::string_view scheme, const Oscillator& o) {
  const double end = 2.0;
  double errors[2] = {};
  for (int n = 0; n < 2; ++n) {
    const long steps = 400L << n;
    const Real x = discrete_state(scheme, o, end / static_cast<double>(steps), steps)(0);
    errors[n] = std::abs(static_cast<double>(x) - sample::exact(o, end).position);
  }
  return std::log2(errors[0] / errors[1]);
}

TEST("powers of each matrix are the scheme stepped by its definition") {
  const double h = 0.11;
  for (const auto scheme : discrete_schemes()) {
    DiscreteState state = discrete_start(scheme, sample_oscillator, h);
    const Update& update = updates.at(scheme);
    for (int n = 0; n < 137; ++n) { update(state(0), state(1), h); }
    const DiscreteState closed = discrete_state(scheme, sample_oscillator, h, 137);
    const Real size = 1 + state.cwiseAbs().maxCoeff();
    CHECK_NEAR(static_cast<double>((closed - state).cwiseAbs().maxCoeff() / size), 0.0, 1e-16);
  }
}

TEST("staggered schemes begin half a step ahead and the others do not") {
  const Oscillator& o = sample_oscillator;
  const double a0 = -(o.stiffness * o.displacement + o.viscosity * o.velocity) / o.mass;
  for (const auto scheme : discrete_schemes()) {
    const double ahead = velocity_is_staggered(scheme) ? 0.05 * a0 : 0.0;
    const DiscreteState start = discrete_start(scheme, o, 0.1);
    CHECK_NEAR(static_cast<double>(start(1)), o.velocity + ahead, 1e-15);
  }
}

TEST("symplectic Euler oscillates at 2/h asin(omega h / 2)") {
  const Oscillator undamped{.mass = 1.0, .stiffness = 4.0, .viscosity = 0.0};
  for (const double h : {0.01, 0.25, 0.9}) {
    for (const auto scheme : {"euler-cromer", "feynman-newton-printed", "leapfrog"}) {
      const Amplification a = amplification(scheme, undamped, h);
      const Real angle = std::acos((a(0, 0) + a(1, 1)) / 2);
      const Real exact = 2 / Real(h) * std::asin(Real(2.0) * Real(h) / 2);
      CHECK_NEAR(static_cast<double>(angle / Real(h) / exact), 1.0, 1e-14);
      CHECK_NEAR(static_cast<double>(spectral_radius(a)), 1.0, 1e-15);
    }
  }
}

TEST("each scheme converges at the order that theory gives it") {
  const Oscillator damped{.viscosity = 0.3, .velocity = 0.4};
  const Oscillator undamped{.viscosity = 0.0, .velocity = 0.4};
  const auto check = [](std::string_view scheme, const Oscillator& o, double order) {
    CHECK_NEAR(observed_order(scheme, o), order, 0.05);  // remaining curvature
  };
  for (const char* scheme : {"euler", "euler-cromer", "feynman-newton-printed", "implicit-euler"}) {
    check(scheme, damped, 1.0);
  }
  check("feynman-newton", undamped, 2.0);
  check("feynman-newton", damped, 1.0);
  for (const char* scheme : {"leapfrog", "velocity-verlet", "implicit-midpoint"}) {
    check(scheme, damped, 2.0);
    check(scheme, undamped, 2.0);
  }
  check("rk4", damped, 4.0);
}

TEST("stability limits separate decay from growth") {
  const double omega0 = 30.0;
  for (const auto scheme : discrete_schemes()) {
    for (const double s : {0.01, 0.35, 0.9, 1.0, 1.0001, 1.5, 4.0}) {
      const double limit = stability_limit(scheme, omega0, s);
      const Oscillator o{.mass = 1.0, .stiffness = omega0 * omega0, .viscosity = 2.0 * s * omega0};
      if (std::isinf(limit)) {
        CHECK(spectral_radius(amplification(scheme, o, 1e3)) <= 1.0L);
        continue;
      }
      CHECK(spectral_radius(amplification(scheme, o, limit * (1.0 - 1e-6))) <= 1.0L);
      CHECK(spectral_radius(amplification(scheme, o, limit * (1.0 + 1e-6))) > 1.0L);
      CHECK(spectral_radius(amplification(scheme, o, 0.5 * limit)) <= 1.0L);
    }
  }
}

TEST("stability limits without damping are those of theory") {
  CHECK(stability_limit("euler", 2.0, 0.0) == 0.0);
  CHECK_NEAR(stability_limit("euler-cromer", 2.0, 0.0), 1.0, 1e-15);
  CHECK_NEAR(stability_limit("leapfrog", 2.0, 0.0), 1.0, 1e-15);
  CHECK_NEAR(stability_limit("velocity-verlet", 2.0, 0.0), 1.0, 1e-12);
  CHECK_NEAR(stability_limit("rk4", 2.0, 0.0), std::sqrt(2.0), 1e-15);
  CHECK_NEAR(stability_limit("rk4", 1.0, 1e-7), 2.0 * std::sqrt(2.0), 1e-5);  // searched
  CHECK(std::isinf(stability_limit("implicit-midpoint", 2.0, 0.0)));
  CHECK(std::isinf(stability_limit("implicit-euler", 2.0, 0.0)));
  CHECK_NEAR(stability_limit("euler", 1.0, 0.05), 0.1, 1e-16);  // the paper: c = 0.1, m = k = 1
}

TEST("a motion that itself grows has no stable step") {
  for (const auto scheme : discrete_schemes()) { CHECK(stability_limit(scheme, 1.0, -0.1) == 0.0); }
}

TEST("an unknown scheme is refused") {
  CHECK_THROWS(amplification("heun", sample_oscillator, 0.1), "heun");
}

}  // namespace PALPATE_FILE
