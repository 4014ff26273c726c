// SPDX-License-Identifier: MIT
#include "model/stepping/spectral_bounds.hpp"

#include <cmath>
#include <cstdio>
#include <numbers>

#include "model/dynamics/lattice.hpp"
#include "reference/dense_modes.hpp"
#include "tests/check.hpp"
#include "tests/model/random_network.hpp"

namespace {

using namespace palpate;
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
  std::printf("  loosest upper bound: %.3f of the true frequency\n", loosest);
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
  SpringNetwork network;
  network.rest_position = NodeVectors::Zero(3, n + 1);
  network.mass = VectorXd::Constant(n + 1, 0.5);
  network.fixed.assign(n + 1, 0);
  network.fixed[0] = 1;
  for (int i = 1; i <= n; ++i) {
    network.rest_position(0, i) = 0.01 * i;
    network.springs.push_back({i - 1, i, 80.0, 0.0, 0.01});
  }
  const NetworkProblem problem(network);
  const double expected =
      2.0 * std::sqrt(80.0 / 0.5) * std::sin((2 * n - 1) * std::numbers::pi / (2 * (2 * n + 1)));
  CHECK_NEAR(truth_of(problem).omega / expected, 1.0, 1e-12);
  const SpectralBounds bounds = spectral_bounds(problem);
  CHECK_NEAR(bounds.omega_estimate / expected, 1.0, 1e-3);  // neighbours are close: slow to settle
  CHECK(bounds.omega_estimate <= expected && bounds.omega_upper >= expected);
}

/// Of an unbounded lattice of 26 equal springs a node: waves along an axis at the zone's edge, where every second
/// layer moves against the others, have sum over neighbours of (1 - cos) (u.e)^2 = 4 + 8 + 16/3.
constexpr double fastest_wave = 52.0 / 3.0;

TEST("a network too large to seek its modes as a whole is bounded from both sides too") {
  const SpringNetwork network = uniform_lattice({{22, 22, 22}, 0.01, 26}, 50.0, 0.05, 1e-3);
  const SpectralBounds bounds = spectral_bounds(NetworkProblem(network));
  const double wave = std::sqrt(fastest_wave * 50.0 / 1e-3);
  CHECK_NEAR(bounds.omega_upper / wave, 1.0, 1e-11);
  CHECK(bounds.omega_estimate <= wave && bounds.omega_estimate > 0.98 * wave);
  CHECK_NEAR(bounds.damping_upper / (fastest_wave * 0.05 / 1e-3), 1.0, 1e-11);
}

TEST("in a large network the mode is sought where it is fastest") {
  SpringNetwork network = uniform_lattice({{22, 22, 22}, 0.01, 26}, 50.0, 0.0, 1e-3);
  network.springs.push_back({0, 1, 5e5, 0.0, 0.01});  // in a corner, alone: its own two masses and no more
  const double pair = std::sqrt(2.0 * 5e5 / 1e-3);
  const SpectralBounds bounds = spectral_bounds(NetworkProblem(network));
  CHECK(bounds.omega_estimate >= pair && bounds.omega_estimate <= bounds.omega_upper);
  CHECK(bounds.omega_upper < 1.01 * pair);
}

TEST("a network without springs has no frequency, and no bound is NaN") {
  SpringNetwork network;
  network.rest_position = NodeVectors::Zero(3, 1);
  network.mass = VectorXd::Ones(1);
  network.fixed = {0};
  const SpectralBounds bounds = spectral_bounds(NetworkProblem(network));
  CHECK(bounds.omega_estimate == 0.0 && bounds.omega_upper == 0.0);
  CHECK(bounds.damping_upper == 0.0 && bounds.relaxation_lower == 0.0);
}

TEST("of an oscillator every bound is exact") {
  const SpectralBounds bounds = spectral_bounds({.mass = 2.0, .stiffness = 8.0, .viscosity = 0.6});
  CHECK_NEAR(bounds.omega_upper, 2.0, 1e-15);
  CHECK_NEAR(bounds.damping_upper, 0.3, 1e-15);
  CHECK_NEAR(bounds.relaxation_lower, 0.075, 1e-15);
}

}  // namespace
