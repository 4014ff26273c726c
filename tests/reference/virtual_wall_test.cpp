// SPDX-License-Identifier: MIT
#include "reference/virtual_wall.hpp"

#include <cmath>

#include "tests/check.hpp"

using namespace palpate::reference;

TEST("without wall damping and delay the boundary is the closed form") {
  for (const double mass : {0.1, 0.2}) {
    for (const double b : {0.5, 2.0}) {
      const WallLoop loop{.mass = mass, .viscosity = b};
      const double tau = mass / b;
      const double a = std::exp(-loop.period / tau);
      const double closed = b * (1.0 - a) / (tau * (1.0 - a) - loop.period * a);
      // The closed form loses 2 log10(tau / T) digits to cancellation.
      CHECK_NEAR(critical_stiffness(loop) / closed, 1.0, 1e-9);
    }
  }
}

TEST("published digits of the boundary") {
  // Root locus of the same loop, computed elsewhere; two decimals given.
  CHECK_NEAR(critical_stiffness({.mass = 0.1, .viscosity = 0.5}), 1000.83, 5e-3);
  CHECK_NEAR(critical_stiffness({.mass = 0.1, .viscosity = 0.5, .delay = 1}), 333.80, 5e-3);
  CHECK_NEAR(critical_stiffness({.mass = 0.1, .viscosity = 0.5, .damping = 1.0}), 2972.70, 5e-3);
  CHECK_NEAR(critical_stiffness({.mass = 0.1, .viscosity = 2.0, .damping = 1.0}), 5960.76, 5e-3);
}

TEST("the rules of thumb hold where they say they do") {
  const WallLoop light{.mass = 10.0, .viscosity = 0.5, .delay = 2};  // T much shorter than m / b
  CHECK_NEAR(linear_rule(light) / critical_stiffness(light), 1.0, 1e-3);
  CHECK_NEAR(passive_stiffness({.viscosity = 0.5}), 1000.0, 1e-9);
  CHECK(passive_stiffness({.viscosity = 0.5, .damping = 1.0}) < 0.0);
  CHECK_NEAR(quantised_stiffness({.viscosity = 5.0}, 5e-5, 0.08), 3200.0, 1e-9);
}

TEST("too much wall damping leaves no stable stiffness") {
  CHECK(critical_stiffness({.mass = 0.1, .viscosity = 0.5, .damping = 500.0}) == 0.0);
}
