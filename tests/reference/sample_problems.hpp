// SPDX-License-Identifier: MIT
#pragma once
// Problems for several tests of the references.

#include <Eigen/SparseCore>
#include <cmath>
#include <complex>
#include <vector>

#include "model/problem/problem.hpp"
#include "model/tissue/lattice.hpp"

namespace sample {

using namespace palpate;

/// Exact motion of m x'' + c x' + k x = F0 cos(W t), from the roots of the characteristic
/// polynomial; c^2 = 4 m k, c = k = 0 and undamped resonance excepted.
struct Motion {
  double position;
  double velocity;
};

inline Motion exact(const Oscillator& o, double t) {
  using Complex = std::complex<double>;
  const double gamma = o.viscosity / (2.0 * o.mass);
  const Complex root = std::sqrt(Complex(gamma * gamma - o.stiffness / o.mass));
  const Complex r1 = -gamma + root;
  const Complex r2 = -gamma - root;
  const Complex drive(0.0, o.drive_frequency);
  const Complex steady = o.drive_amplitude / o.mass / ((drive - r1) * (drive - r2));
  const double x0 = o.displacement - steady.real();
  const double v0 = o.velocity - (drive * steady).real();
  const Complex a = (v0 - r2 * x0) / (r1 - r2);
  const Complex b = x0 - a;
  const Complex ea = a * std::exp(r1 * t);
  const Complex eb = b * std::exp(r2 * t);
  const Complex es = steady * std::exp(drive * t);
  return {(ea + eb + es).real(), (r1 * ea + r2 * eb + drive * es).real()};
}

/// Critically damped free motion, c^2 = 4 m k.
inline Motion exact_critical(const Oscillator& o, double t) {
  const double gamma = o.viscosity / (2.0 * o.mass);
  const double rise = o.velocity + gamma * o.displacement;
  const double decay = std::exp(-gamma * t);
  return {(o.displacement + rise * t) * decay, (o.velocity - gamma * rise * t) * decay};
}

inline std::vector<double> instants(double end, int count) {
  std::vector<double> times;
  for (int n = 0; n <= count; ++n) { times.push_back(end * n / count); }
  return times;
}

/// Tripod: one free node with three springs to the ground and a load.
inline NetworkProblem tripod(const Eigen::Vector3d& force, const PrintedForm& printed = {}) {
  SpringNetwork network;
  network.rest_position.resize(3, 4);
  network.rest_position << 0.0, 0.01, -0.01, 0.0,  //
      0.01, -0.01, -0.01, 0.0,                     //
      0.0, 0.0, 0.0, 0.02;
  network.mass = Eigen::VectorXd::Ones(4);
  network.fixed = {1, 1, 1, 0};
  for (const int foot : {0, 1, 2}) {
    const double length = (network.rest_position.col(3) - network.rest_position.col(foot)).norm();
    network.springs.push_back({foot, 3, 100.0, 0.0, length});
  }
  return NetworkProblem(network, {Load{.nodes = {3}, .force = force}}, {0.0, 0.0, 0.0}, printed);
}

struct Block {
  int nodes = 4;              ///< nodes per edge
  double stiffness = 1000.0;  ///< [N/m]
  double viscosity = 0.05;    ///< [N s/m]
  double node_mass = 0.5e-3;  ///< [kg]
};

/// A cube of 5 mm spacing whose z-max face is fixed.
inline SpringNetwork block(const Block& b = {}) {
  const LatticeShape shape{.nodes = {b.nodes, b.nodes, b.nodes}, .spacing = 5e-3};
  SpringNetwork network = uniform_lattice(shape, b.stiffness, b.viscosity, b.node_mass);
  for (int j = 0; j < b.nodes; ++j) {
    for (int i = 0; i < b.nodes; ++i) {
      network.fixed[static_cast<std::size_t>(shape.index(i, j, b.nodes - 1))] = 1;
    }
  }
  return network;
}

/// Load of 10 ms on the first node, from 5 ms.
inline Load pulse(double newton) {
  return {.nodes = {0},
          .force = {0.3 * newton, 0.1 * newton, newton},
          .start = 5e-3,
          .end = 15e-3,
          .profile = Profile::half_sine};
}

/// N equal masses on a line along z, connected by springs. The first is connected to a fixed node,
/// with `both_ends` also the last. Nodes 1 to N are free.
inline SpringNetwork chain(int masses, double stiffness, double mass, bool both_ends) {
  const int nodes = masses + (both_ends ? 2 : 1);
  SpringNetwork network;
  network.rest_position = NodeVectors::Zero(3, nodes);
  network.rest_position.row(2).setLinSpaced(nodes, 0.0, 0.01 * (nodes - 1));
  network.mass = Eigen::VectorXd::Constant(nodes, mass);
  network.fixed.assign(static_cast<std::size_t>(nodes), 0);
  network.fixed.front() = 1;
  if (both_ends) { network.fixed.back() = 1; }
  for (int i = 1; i < nodes; ++i) { network.springs.push_back({i - 1, i, stiffness, 0.0, 0.01}); }
  return network;
}

}  // namespace sample
