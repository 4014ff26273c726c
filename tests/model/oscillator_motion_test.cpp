// SPDX-License-Identifier: MIT
#include "model/dynamics/oscillator_motion.hpp"

#include <cmath>
#include <string_view>

#include "tests/check.hpp"

namespace {

using namespace palpate;

using Matrix = Eigen::Matrix<long double, 4, 4>;
using Column = Eigen::Matrix<long double, 4, 1>;

/// exp(a) by Taylor series after halving; knows nothing of damping regimes or resonance.
Matrix exponential(Matrix a) {
  int halvings = 0;
  for (; a.cwiseAbs().maxCoeff() > 0.05L; ++halvings) { a /= 2; }
  Matrix term = Matrix::Identity();
  Matrix sum = term;
  for (int n = 1; n < 20; ++n) {
    term = (term * a / n).eval();
    sum += term;
  }
  for (; halvings > 0; --halvings) { sum = (sum * sum).eval(); }
  return sum;
}

/// Oscillator and drive as one linear system (x, v, cos W t, sin W t).
Column truth(const Oscillator& o, double t) {
  const long double m = o.mass;
  const long double w = o.drive_frequency;
  Matrix a = Matrix::Zero();
  a(0, 1) = 1;
  a.row(1) << -o.stiffness / m, -o.viscosity / m, o.drive_amplitude / m, 0;
  a(2, 3) = -w;
  a(3, 2) = w;
  return exponential(a * static_cast<long double>(t)) * Column(o.displacement, o.velocity, 1, 0);
}

/// Distance of (x, v / omega0) from the truth, over the size of the truth at that instant plus that
/// of the drive's response.
double relative_error(const Oscillator& o, double t) {
  const long double omega = std::sqrt(o.stiffness / o.mass);
  const Column expected = truth(o, t);
  const OscillatorState got = exact_motion(o, t);
  const long double size = std::hypot(expected(0), expected(1) / omega) +
                           std::abs(o.drive_amplitude) / (o.mass * omega * omega);
  return static_cast<double>(
      std::hypot(got.position - expected(0), (got.velocity - expected(1)) / omega) / size);
}

Oscillator with_ratio(double s) {
  return {.mass = 2.0,
          .stiffness = 8.0,
          .viscosity = 2.0 * s * 4.0,
          .displacement = 0.7,
          .velocity = -1.3};
}

// exact_motion promises 1e-13 relative; over omega t = 50 the phase itself rounds to 50 eps.
constexpr double promised = 1e-13;

TEST("free motion is exact in every regime, S < 0 and S > 1 included") {
  for (const double s : {-0.3, -0.01, 0.0, 0.05, 0.35, 0.9, 0.99, 1.0, 1.01, 1.5, 4.0}) {
    for (const double t : {0.0, 0.01, 0.3, 1.0, 3.0, 10.0, 25.0}) {
      CHECK_NEAR(relative_error(with_ratio(s), t), 0.0, promised);
    }
  }
}

TEST("nothing is lost as S approaches 1 from either side") {
  for (double gap = 1e-16; gap < 0.2; gap *= 10.0) {
    for (const double t : {0.1, 1.0, 4.0, 12.0}) {
      CHECK_NEAR(relative_error(with_ratio(1.0 - gap), t), 0.0, promised);
      CHECK_NEAR(relative_error(with_ratio(1.0 + gap), t), 0.0, promised);
    }
  }
}

TEST("driven motion is exact below, at and above resonance") {
  for (const double s : {0.0, 0.01, 0.35, 1.0, 2.0}) {
    for (const double w : {0.0, 0.5, 1.9, 2.0 - 1e-9, 2.0, 2.0 + 1e-6, 5.0}) {
      Oscillator o = with_ratio(s);
      o.drive_amplitude = 3.0;
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

TEST("the paper's c = 0.7 and c = 1.8 are underdamped and critical is c = 2") {
  Oscillator o{.mass = 1.0, .stiffness = 1.0};
  const auto class_of = [&](double c) {
    o.viscosity = c;
    return std::string_view(damping_class(o));
  };
  CHECK(class_of(0.7) == "underdamped" && class_of(1.8) == "underdamped");
  CHECK_NEAR(damping_ratio(o), 0.9, 1e-15);
  CHECK(class_of(2.0) == "critically damped" && class_of(2.1) == "overdamped");
  CHECK(class_of(0.0) == "undamped" && class_of(-0.1) == "negatively damped");
  o.drive_amplitude = 1.0;
  CHECK(class_of(0.7) == "driven");
}

TEST("Eq. 6 as printed is a bare decay, and as plotted oscillates at omega0") {
  const Oscillator o{.mass = 1.0, .stiffness = 1.0, .viscosity = 0.3};
  CHECK_NEAR(equation_6_printed(o, 3.0, 2.0), 3.0 * std::exp(-0.3), 1e-15);
  CHECK_NEAR(equation_6_plotted(o, 3.0, 0.2, 2.0), 3.0 * std::exp(-0.3) * std::cos(2.2), 1e-15);
}

}  // namespace
