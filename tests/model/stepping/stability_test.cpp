// SPDX-License-Identifier: MIT

#include "model/stepping/stability.hpp"

#include <Eigen/SparseCore>
#include <cmath>
#include <limits>
#include <numbers>

#include "model/tissue/lattice.hpp"
#include "reference/modal.hpp"
#include "tests/check.hpp"
#include "tests/model/sample_scenes.hpp"
#include "tests/reference/sample_problems.hpp"

namespace PALPATE_FILE {

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
      // The slope of the growth is 2 S per step, and growth of 1e-13 is treated as rounding.
      if (s > 0.0) { CHECK_NEAR(limit("euler", omega, s) * omega, 2.0 * s, 1e-13 / s); }
    }
    CHECK_NEAR(limit("rk4", omega, 0.0) * omega, 2.0 * std::sqrt(2.0), 1e-10);
    CHECK_NEAR(limit("velocity-verlet", omega, 0.0) * omega, 2.0, 1e-9);
  }
}

TEST("Euler is limited by a fast rate, by drag alone, and without damping to no step") {
  for (const double s : {1.0, 1.5, 20.0}) {
    const double fast = s + std::sqrt(s * s - 1.0);
    CHECK_NEAR(limit("euler", 3.0, s) * 3.0 * fast, 2.0, 1e-9);
  }
  CHECK_NEAR(stable_step(*find_integrator("euler"), 0.0, 50.0), 2.0 / 50.0, 1e-12);
  CHECK(stable_step(*find_integrator("euler"), 0.0, 0.0) == infinite);
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

TEST("negative damping is stable at no step") {
  for (const char* name : {"euler", "euler-cromer", "rk4", "velocity-verlet"}) {
    CHECK(limit(name, 1.0, -0.01) == 0.0);
  }
}

TEST("the damping ratio of a step is that of the mode, and implicit Euler adds h omega / 2") {
  constexpr FirstMode mode{.omega = 400.0, .damping_ratio = 0.1};
  for (const char* exact : {"rk4", "velocity-verlet", "implicit-midpoint"}) {
    CHECK_NEAR(stepped_damping_ratio(*find_integrator(exact), mode, 1e-5), 0.1, 1e-5);
  }
  const IntegratorInfo& euler = *find_integrator("implicit-euler");
  for (const double h : {1e-6, 1e-5, 1e-4}) {
    const double added = stepped_damping_ratio(euler, mode, h) - 0.1;
    CHECK_NEAR(added, 0.5 * h * mode.omega, h * mode.omega * (0.1 + h * mode.omega));
  }
  // Undamped: l = 1 / (1 - i z), of size 1 / sqrt(1 + z^2) and angle atan z.
  const double z = 0.8;
  const double decay = 0.5 * std::log(1.0 + z * z);
  CHECK_NEAR(stepped_damping_ratio(euler, {.omega = 400.0}, z / 400.0),
             decay / std::hypot(decay, std::atan(z)), 1e-12);
  CHECK(stepped_damping_ratio(euler, {.omega = 400.0, .damping_ratio = 1.1}, 1e-4) == 1.0);
}

TEST("the first mode of a chain has its closed frequency and the damping of its dampers") {
  constexpr int masses = 20;
  SpringNetwork chain;
  chain.rest_position = NodeVectors::Zero(3, masses + 1);
  chain.mass = Eigen::VectorXd::Constant(masses + 1, 0.01);
  chain.fixed.assign(masses + 1, 0);
  chain.fixed[0] = 1;
  for (int n = 0; n <= masses; ++n) { chain.rest_position(0, n) = 0.01 * n; }
  // Springs across hold the chain on its line; they are stiff, so that the lowest mode is axial.
  for (int axis = 0; axis < 3; ++axis) {
    for (int n = 1; n <= masses; ++n) {
      if (axis == 0) {
        chain.springs.push_back({n - 1, n, 100.0, 0.02, 0.01});
        continue;
      }
      const int wall = static_cast<int>(chain.rest_position.cols());
      chain.rest_position.conservativeResize(Eigen::NoChange, wall + 1);
      chain.rest_position.col(wall) = chain.rest_position.col(n);
      chain.rest_position(axis, wall) = 0.01;
      chain.mass.conservativeResize(wall + 1);
      chain.mass(wall) = 1.0;
      chain.fixed.push_back(1);
      chain.springs.push_back({wall, n, 1e5, 0.0, 0.01});
    }
  }
  const auto mode = first_mode(NetworkProblem(chain)).value();
  const double omega = 2.0 * std::sqrt(100.0 / 0.01) * std::sin(std::numbers::pi / 2.0 / 41.0);
  CHECK_NEAR(mode.omega, omega, 1e-4 * omega);  // where the iteration ends
  CHECK_NEAR(mode.damping_ratio, 0.5 * omega * 0.02 / 100.0, 1e-4 * mode.damping_ratio);
  chain.fixed.assign(chain.fixed.size(), 0);
  CHECK(!first_mode(NetworkProblem(chain)));
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

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Truth {
  double omega;
  double damping;
};

double largest(const MatrixXd& a, const VectorXd& mass) {
  const VectorXd s = mass.cwiseSqrt().cwiseInverse();
  return reference::symmetric_eigenvalues(s.asDiagonal() * a * s.asDiagonal()).maxCoeff();
}

Truth truth_of(const NetworkProblem& problem) {
  Eigen::SparseMatrix<double> k, c;
  problem.jacobian(problem.initial_position(), VectorXd::Zero(problem.dof()), k, c);
  return {std::sqrt(largest(k, problem.mass())), largest(c, problem.mass())};
}

TEST("estimate <= true highest frequency <= upper bound on random networks") {
  double loosest = 1.0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const NetworkProblem problem(random_network(seed, {.nodes = 15,
                                                       .springs = 60,
                                                       .fixed = static_cast<int>(seed % 4),
                                                       .decades = static_cast<double>(seed % 7),
                                                       .stretch = 0.6}));
    const Truth truth = truth_of(problem);
    const SpectralBounds bounds = spectral_bounds(problem);
    CHECK(bounds.omega_estimate <= truth.omega * (1.0 + 1e-9));
    CHECK(bounds.omega_upper >= truth.omega * (1.0 - 1e-12));
    CHECK(bounds.damping_upper >= truth.damping * (1.0 - 1e-12));
    loosest = std::max(loosest, bounds.omega_upper / truth.omega);
  }
  CHECK(loosest < 1.5);  // looser than that, and automatic substeps waste a third of the work
}

TEST("the bound is exact for one spring between two masses") {
  SpringNetwork network;
  network.rest_position = NodeVectors::Zero(3, 2);
  network.rest_position(2, 1) = 0.01;
  network.mass = Eigen::Vector2d(1e-4, 3.0);
  network.fixed = {0, 0};
  network.springs = {{0, 1, 500.0, 0.2, 0.01}};
  const double reduced = 1.0 / (1.0 / 1e-4 + 1.0 / 3.0);
  const SpectralBounds bounds = spectral_bounds(NetworkProblem(network));
  CHECK_NEAR(bounds.omega_upper / std::sqrt(500.0 / reduced), 1.0, 1e-9);
  CHECK_NEAR(bounds.omega_estimate / std::sqrt(500.0 / reduced), 1.0, 1e-9);
  CHECK_NEAR(bounds.damping_upper / (0.2 / reduced), 1.0, 1e-9);
  CHECK_NEAR(bounds.relaxation_lower, 0.2 / 500.0, 1e-18);
}

TEST("a fixed-free chain has the highest frequency of its closed form") {
  constexpr int n = 12;
  const NetworkProblem problem(sample::chain(n, 80.0, 0.5, false));
  const double expected =
      2.0 * std::sqrt(80.0 / 0.5) * std::sin((2 * n - 1) * std::numbers::pi / (2 * (2 * n + 1)));
  CHECK_NEAR(truth_of(problem).omega / expected, 1.0, 1e-12);
  const SpectralBounds bounds = spectral_bounds(problem);
  CHECK_NEAR(bounds.omega_estimate / expected, 1.0, 1e-3);  // neighbours are close: slow to settle
  CHECK(bounds.omega_estimate <= expected);
  CHECK(bounds.omega_upper >= expected);
}

/// Stiffness sum of an infinite lattice with 26 equal springs per node: waves along an axis at the
/// edge of the Brillouin zone, where alternate layers move in opposite directions, give a sum over
/// neighbours of (1 - cos) (u.e)^2 = 4 + 8 + 16/3.
constexpr double fastest_wave = 52.0 / 3.0;

TEST("a network too large for all its modes is bounded from both sides too") {
  const SpringNetwork network = uniform_lattice({{22, 22, 22}, 0.01, 26}, 50.0, 0.05, 1e-3);
  const SpectralBounds bounds = spectral_bounds(NetworkProblem(network));
  const double wave = std::sqrt(fastest_wave * 50.0 / 1e-3);
  CHECK_NEAR(bounds.omega_upper / wave, 1.0, 1e-11);
  CHECK(bounds.omega_estimate <= wave);
  CHECK(bounds.omega_estimate > 0.98 * wave);
  CHECK_NEAR(bounds.damping_upper / (fastest_wave * 0.05 / 1e-3), 1.0, 1e-11);
}

TEST("in a large network the fastest mode is found where it is local") {
  SpringNetwork network = uniform_lattice({{22, 22, 22}, 0.01, 26}, 50.0, 0.0, 1e-3);
  network.springs.push_back(
      {0, 1, 5e5, 0.0, 0.01});  // in a corner, alone: its own two masses and no more
  const double pair = std::sqrt(2.0 * 5e5 / 1e-3);
  const SpectralBounds bounds = spectral_bounds(NetworkProblem(network));
  CHECK(bounds.omega_estimate >= pair);
  CHECK(bounds.omega_estimate <= bounds.omega_upper);
  CHECK(bounds.omega_upper < 1.01 * pair);
}

TEST("a network without springs has no frequency, and no bound is NaN") {
  SpringNetwork network;
  network.rest_position = NodeVectors::Zero(3, 1);
  network.mass = VectorXd::Ones(1);
  network.fixed = {0};
  const SpectralBounds bounds = spectral_bounds(NetworkProblem(network));
  CHECK(bounds.omega_estimate == 0.0);
  CHECK(bounds.omega_upper == 0.0);
  CHECK(bounds.damping_upper == 0.0);
  CHECK(bounds.relaxation_lower == 0.0);
}

TEST("every bound of an oscillator is exact") {
  const SpectralBounds bounds = spectral_bounds({.mass = 2.0, .stiffness = 8.0, .viscosity = 0.6});
  CHECK_NEAR(bounds.omega_upper, 2.0, 1e-15);
  CHECK_NEAR(bounds.damping_upper, 0.3, 1e-15);
  CHECK_NEAR(bounds.relaxation_lower, 0.075, 1e-15);
}

}  // namespace PALPATE_FILE
