// SPDX-License-Identifier: MIT
#include "model/stepping/stability.hpp"

#include <cmath>
#include <limits>

#include "tests/check.hpp"

namespace {

using namespace palpate;

constexpr double infinite = std::numeric_limits<double>::infinity();

double limit(const char* name, double omega, double damping_ratio) {
  return stable_step(*find_integrator(name), omega, 2.0 * damping_ratio * omega);
}

TEST("stable steps agree with the closed forms of the schemes") {
  for (const double omega : {0.3, 1.0, 2e4}) {
    for (const double s : {0.0, 1e-3, 0.1, 0.5, 0.9}) {
      const double cromer = 2.0 * (std::sqrt(1.0 + s * s) - s);
      CHECK_NEAR(limit("euler-cromer", omega, s) * omega, cromer, 1e-10);
      CHECK_NEAR(limit("feynman-newton-printed", omega, s) * omega, cromer, 1e-10);
      CHECK_NEAR(limit("feynman-newton", omega, s) * omega, cromer, 1e-10);
      CHECK_NEAR(limit("leapfrog", omega, s) * omega, 2.0, 1e-9);
      // The slope of the growth is 2 S per step there, and 1e-13 of growth counts as rounding.
      if (s > 0.0) { CHECK_NEAR(limit("euler", omega, s) * omega, 2.0 * s, 1e-13 / s); }
    }
    CHECK_NEAR(limit("rk4", omega, 0.0) * omega, 2.0 * std::sqrt(2.0), 1e-10);
    CHECK_NEAR(limit("velocity-verlet", omega, 0.0) * omega, 2.0, 1e-9);
  }
}

TEST("overdamped Euler is limited by its fast rate") {
  for (const double s : {1.0, 1.5, 20.0}) {
    const double fast = s + std::sqrt(s * s - 1.0);
    CHECK_NEAR(limit("euler", 3.0, s) * 3.0 * fast, 2.0, 1e-9);
  }
}

TEST("no step of undamped explicit Euler is stable") {
  for (const double omega : {1e-3, 1.0, 1e5}) { CHECK(limit("euler", omega, 0.0) == 0.0); }
}

TEST("implicit schemes have no limit") {
  for (const char* name : {"implicit-euler", "implicit-midpoint"}) {
    CHECK(limit(name, 5.0, 0.0) == infinite);
    CHECK(stable_step(*find_integrator(name), {10.0, 10.0, 1.0, 0.1}) == infinite);
    for (const double h : {1.0, 10.0, 1e3}) {
      CHECK(amplification(*find_integrator(name), 1.0, 0.2, h) <= 1.0 + 1e-9);
    }
  }
}

TEST("amplification is the growth per step: Euler's is sqrt(1 + (h omega)^2)") {
  CHECK_NEAR(amplification(*find_integrator("euler"), 2.0, 0.0, 0.25), std::sqrt(1.25), 1e-14);
  // Cromer beyond its limit: the larger root of l^2 - (2 - z^2) l + 1, z = 3.
  CHECK_NEAR(amplification(*find_integrator("euler-cromer"), 1.0, 0.0, 3.0),
             3.5 + std::sqrt(3.5 * 3.5 - 1.0), 1e-13);
}

TEST("drag without a spring limits Euler to two over its rate") {
  CHECK_NEAR(stable_step(*find_integrator("euler"), 0.0, 50.0), 2.0 / 50.0, 1e-12);
  CHECK(stable_step(*find_integrator("euler"), 0.0, 0.0) == infinite);
}

TEST("negative damping is stable at no step") {
  for (const char* name : {"euler", "euler-cromer", "rk4", "velocity-verlet"}) {
    CHECK(limit(name, 1.0, -0.01) == 0.0);
  }
}

TEST("the bound of a network holds for every oscillator that it can contain") {
  const SpectralBounds bounds{900.0, 1000.0, 3000.0, 1e-4};
  for (const IntegratorInfo* scheme : integrators()) {
    const double bound = stable_step(*scheme, bounds);
    for (int i = 1; i <= 60; ++i) {
      const double omega = bounds.omega_upper * i / 60.0;
      const double least = bounds.relaxation_lower * omega * omega;
      for (int j = 0; j <= 60; ++j) {
        const double damping = least + (bounds.damping_upper - least) * j / 60.0;
        // The grid of the bound is coarser than this one by five: a dip between its points.
        CHECK(bound <= 1.002 * stable_step(*scheme, omega, damping));
      }
    }
  }
}

TEST("an undamped network's bound is the limit of its fastest mode") {
  const SpectralBounds bounds{900.0, 1000.0, 0.0, 0.0};
  CHECK_NEAR(stable_step(*find_integrator("leapfrog"), bounds), 2e-3, 1e-11);
  CHECK(stable_step(*find_integrator("euler"), bounds) == 0.0);
}

}  // namespace
