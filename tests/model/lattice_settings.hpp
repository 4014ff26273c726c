// SPDX-License-Identifier: MIT
#pragma once
/// Small regular lattices of many shapes, in motion, and what their kernels make of them.

#include <array>
#include <vector>

#include "model/dynamics/network_builder.hpp"
#include "model/stepping/lattice_network.hpp"
#include "tests/model/random_network.hpp"

namespace palpate::lattice_settings {

using Eigen::VectorXd;

struct Setting {
  std::array<int, 3> nodes{};
  int connectivity = 26;
  bool damped = true;
  bool uneven = false;  ///< stiffness and viscosity of its own for every spring
  bool held = true;
};

inline NetworkProblem problem_of(const Setting& at) {
  const LatticeShape shape{at.nodes, 0.01, at.connectivity};
  SpringNetwork network = uniform_lattice(shape, 50.0, at.damped ? 0.05 : 0.0, 1e-3);
  Random random(3);
  network.springs.change_each([&](Spring& s) {
    if (!at.uneven) { return; }
    s.stiffness *= random(0.2, 5.0);
    s.viscosity *= random(0.2, 5.0);
  });
  if (at.held) {
    for (const int node : face_nodes(network.rest_position, Face::z_max)) {
      network.fixed[static_cast<std::size_t>(node)] = 1;
    }
    network.fixed[5] = 1;
  }
  const int count = shape.node_count();  // 7 twice, and further layers
  const std::vector<Load> loads{{.nodes = {2, 7, 7}, .force = {0.1, -0.2, 0.3}},
                                {.nodes = {count - 1, count / 2, 3, 2 * count / 3}, .force = {0.0, 0.4, -0.1}}};
  return NetworkProblem(network, loads, {0.3, -0.2, 9.81});
}

struct Motion {
  VectorXd q;
  VectorXd v;
};
inline Motion motion_of(const NetworkProblem& problem) {
  Random random(4);
  return {problem.initial_position() + random.vector(problem.dof(), 2e-3),
          random.vector(problem.dof(), 0.5)};
}

template <class Real>
struct InLanes {
  InLanes(const NetworkProblem& problem, const Motion& motion, bool skip = true,
          const lattice::Kernels<Real>& kernels = lattice_kernels<Real>().front(), int threads = 1)
      : system(problem, skip, threads, kernels), q(system.initial_position()), v(system.initial_velocity()) {
    scatter(motion.q, system.layout(), q);
    scatter(motion.v, system.layout(), v);
  }
  VectorXd packed(const Vector<Real>& all, Eigen::Index dof) {
    VectorXd out(dof);
    gather(all, system.layout(), out);
    return out;
  }
  LatticeNetwork<Real> system;
  Vector<Real> q, v;
};

inline const std::vector<Setting> settings{
    {.nodes = {4, 4, 4}},
    {.nodes = {10, 3, 5}},
    {.nodes = {2, 2, 2}, .held = false},
    {.nodes = {3, 9, 4}, .damped = false},
    {.nodes = {5, 4, 17}, .uneven = true},
    {.nodes = {11, 7, 3}, .damped = false, .uneven = true},
    {.nodes = {6, 5, 4}, .connectivity = 6},
    {.nodes = {9, 5, 4}, .connectivity = 18, .uneven = true, .held = false},
    // Short rows, which are folded into registers of four, eight and sixteen lanes.
    {.nodes = {10, 10, 10}, .uneven = true},
    {.nodes = {20, 20, 20}, .uneven = true},
    {.nodes = {20, 11, 13}, .damped = false, .uneven = true, .held = false},
    {.nodes = {3, 5, 9}, .uneven = true},
    {.nodes = {2, 2, 2}, .held = false}};

template <class Real>
VectorXd force_of(const NetworkProblem& problem, const Motion& motion, bool skip = true,
                  const lattice::Kernels<Real>& kernels = lattice_kernels<Real>().front()) {
  InLanes<Real> lanes(problem, motion, skip, kernels);
  Vector<Real> f = Vector<Real>::Constant(lanes.q.size(), Real(1e30));  // must be cleared
  lanes.system.force(0.0, 0.0, lanes.q, lanes.v, f);
  return lanes.packed(f, problem.dof());
}

}  // namespace palpate::lattice_settings
