// SPDX-License-Identifier: MIT
#include "reference/mode_response.hpp"

#include <cmath>

#include "tests/check.hpp"

using namespace palpate::reference;

namespace {

/// The equation of motion itself, integrated by classical RK4 in long double: slow, and blind to
/// resonance and to damping regimes.
ModeState<long double> stepped(const Mode<long double>& mode, ModeState<long double> y,
                               const ModeForce<long double>& force, long double end) {
  using State = ModeState<long double>;
  const auto rate = [&](long double t, const State& s) {
    long double p = force.constant + force.slope * t;
    for (const auto& h : force.harmonics) {
      p += h.cosine * std::cos(h.frequency * t) + h.sine * std::sin(h.frequency * t);
    }
    return State{s.velocity, p - 2 * mode.gamma * s.velocity - mode.omega_squared * s.position};
  };
  const auto moved = [](const State& s, const State& r, long double h) {
    return State{s.position + h * r.position, s.velocity + h * r.velocity};
  };
  const int steps = 50 + static_cast<int>(5000 * end);
  const long double h = end / steps;
  for (int n = 0; n < steps; ++n) {
    const long double t = n * h;
    const State a = rate(t, y);
    const State b = rate(t + h / 2, moved(y, a, h / 2));
    const State c = rate(t + h / 2, moved(y, b, h / 2));
    const State d = rate(t + h, moved(y, c, h));
    y.position += h / 6 * (a.position + 2 * b.position + 2 * c.position + d.position);
    y.velocity += h / 6 * (a.velocity + 2 * b.velocity + 2 * c.velocity + d.velocity);
  }
  return y;
}

template <class Real>
ModeForce<Real> all_shapes(Real frequency) {
  return {.constant = Real(0.7),
          .slope = Real(-0.4),
          .harmonics = {{frequency, Real(0.3), Real(-0.8)}, {Real(0.5), Real(0.1), Real(0.2)}}};
}

struct Case {
  double omega_squared, gamma, frequency, t;
};

template <class Real>
double error(const Case& c, const ModeState<long double>& truth) {
  const auto exact = respond<Real>({Real(c.omega_squared), Real(c.gamma)}, {Real(0.5), Real(-1.25)},
                                   all_shapes<Real>(Real(c.frequency)), Real(c.t));
  const long double size = 1 + std::abs(truth.position) + std::abs(truth.velocity);
  return static_cast<double>(std::fmax(std::abs(exact.position - truth.position),
                                       std::abs(exact.velocity - truth.velocity)) /
                             size);
}

}  // namespace

TEST("the response to every shape of load solves the equation of motion in every regime") {
  // omega^2 < 0 (unstable), 0 (rigid), near 0, and up; gamma through critical damping; the second
  // harmonic stays, the first sweeps through resonance at 3 rad/s.
  for (const double omega_squared : {-0.5, 0.0, 1e-9, 9.0}) {
    for (const double gamma : {0.0, 0.5, 3.0000001, 8.0}) {
      for (const double frequency : {0.1, 2.999, 3.0, 12.0}) {
        for (const double t : {1e-3, 0.6, 4.0}) {
          const Case c{omega_squared, gamma, frequency, t};
          const auto truth = stepped({omega_squared, gamma}, {0.5L, -1.25L},
                                     all_shapes<long double>(frequency), t);
          CHECK_NEAR(error<double>(c, truth), 0.0, 2e-13);
          CHECK_NEAR(error<long double>(c, truth), 0.0, 2e-13);
        }
      }
    }
  }
}

TEST("at resonance without damping the amplitude grows in proportion to time") {
  const ModeForce<double> force{.harmonics = {{3.0, 0.0, 1.0}}};
  const double t = 40.0;
  const auto state = respond<double>({9.0, 0.0}, {}, force, t);
  const double exact = (std::sin(3.0 * t) - 3.0 * t * std::cos(3.0 * t)) / (2.0 * 9.0);
  CHECK_NEAR(state.position, exact, 1e-12);  // 120 rad of phase, some 1e-14 each
}

TEST("a rigid mode falls freely") {
  const auto state = respond<double>({0.0, 0.0}, {1.0, 2.0}, {.constant = -9.81}, 3.0);
  CHECK_NEAR(state.position, 1.0 + 6.0 - 9.81 * 4.5, 1e-13);
  CHECK_NEAR(state.velocity, 2.0 - 9.81 * 3.0, 1e-13);
}

TEST("free motion does not overflow when strongly overdamped") {
  const auto state = free_response<double>({1.0, 1e4}, {1.0, 0.0}, 100.0);
  CHECK_NEAR(state.position, std::exp(-100.0 / 2e4), 1e-8);  // slow rate omega^2 / 2 gamma
}
