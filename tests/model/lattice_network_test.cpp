// SPDX-License-Identifier: MIT
/// Kernels of regular lattices against NetworkProblem, the specification.
#include "model/stepping/lattice_network.hpp"

#include "model/dynamics/network_builder.hpp"
#include "tests/check.hpp"
#include "tests/model/lattice_settings.hpp"

namespace {

using namespace palpate;
using namespace palpate::lattice_settings;
using Eigen::VectorXd;

/// Roundings of a node's 26 springs, each k (L - L0) from lengths of 0.01 m.
double rounding_of(const VectorXd& force, double epsilon) {
  return 30.0 * epsilon * (force.cwiseAbs().maxCoeff() + 250.0 * 0.02);
}

/// With all instructions that this processor has, and with what every one of its kind has.
void check_forces(const NetworkProblem& problem, const Motion& motion) {
  VectorXd expected(problem.dof());
  problem.force(0.0, 0.0, motion.q, motion.v, expected);
  for (const auto& kernels : lattice_kernels<double>()) {
    CHECK_NEAR(force_of<double>(problem, motion, true, kernels), expected, rounding_of(expected, 2.3e-16));
  }
  for (const auto& kernels : lattice_kernels<float>()) {
    CHECK_NEAR(force_of<float>(problem, motion, true, kernels), expected, rounding_of(expected, 1.2e-7));
  }
}

TEST("forces equal the specification to rounding, whatever shape, springs, bonds and instructions") {
  for (const Setting& at : settings) {
    const NetworkProblem problem = problem_of(at);
    check_forces(problem, motion_of(problem));
  }
}

TEST("two nodes at one place exert no force on each other, whatever the instructions") {
  for (const bool damped : {true, false}) {
    const NetworkProblem problem = problem_of({.nodes = {10, 6, 5}, .damped = damped, .held = false});
    Motion motion = motion_of(problem);
    const LatticeShape shape{{10, 6, 5}, 0.01, 26};
    const auto place = [&](int i) { return motion.q.segment<3>(problem.coordinate(shape.index(i, 3, 2))); };
    place(4) = place(3);
    check_forces(problem, motion);
  }
}

TEST("a node displaced from its place changes the forces on its neighbours alone") {
  const NetworkProblem problem = problem_of({.nodes = {10, 6, 5}, .held = false});
  Motion motion{problem.initial_position(), VectorXd::Zero(problem.dof())};
  const VectorXd before = force_of<double>(problem, motion);
  const LatticeShape shape{{10, 6, 5}, 0.01, 26};
  motion.q(problem.coordinate(shape.index(2, 3, 2))) += 1e-3;
  const VectorXd change = force_of<double>(problem, motion) - before;
  for (int node = 0; node < shape.node_count(); ++node) {
    const auto [i, j, l] = shape.place(node);
    const bool near = std::abs(i - 2) <= 1 && std::abs(j - 3) <= 1 && std::abs(l - 2) <= 1;
    CHECK((change.segment<3>(3 * node).norm() > 0.0) == near);
  }
}

TEST("computing what a lattice does not need changes no bit") {
  for (const Setting& at : settings) {
    const NetworkProblem problem = problem_of(at);
    const Motion motion = motion_of(problem);
    CHECK_NEAR(force_of<double>(problem, motion, false), force_of<double>(problem, motion, true), 0.0);
    CHECK_NEAR(force_of<float>(problem, motion, false), force_of<float>(problem, motion, true), 0.0);
  }
}

TEST("damping and energy equal the specification") {
  for (const Setting& at : settings) {
    const NetworkProblem problem = problem_of(at);
    const Motion motion = motion_of(problem);
    InLanes<double> lanes(problem, motion);
    Eigen::SparseMatrix<double> stiffness;
    Eigen::SparseMatrix<double> damping;
    problem.jacobian(motion.q, motion.v, stiffness, damping);
    const VectorXd expected = damping * motion.v;
    Vector<double> f(lanes.q.size());
    lanes.system.damping(lanes.q, lanes.v, f);
    CHECK_NEAR(lanes.packed(f, problem.dof()), expected, 1e-13 * (1.0 + expected.norm()));
    const double energy = problem.energy(motion.q, motion.v);
    CHECK_NEAR(lanes.system.energy(lanes.q, lanes.v), energy, 1e-13 * std::abs(energy) + 1e-13);
  }
}

TEST("nodes of no distance pull at nothing") {
  const NetworkProblem problem = problem_of({.nodes = {4, 5, 3}, .held = false});
  Motion motion = motion_of(problem);
  motion.q.segment<3>(3) = motion.q.segment<3>(0);
  VectorXd expected(problem.dof());
  problem.force(0.0, 0.0, motion.q, motion.v, expected);
  CHECK_NEAR(force_of<double>(problem, motion), expected, rounding_of(expected, 2.3e-16));
}

TEST("fixed nodes, and what fills rows up, have no inverse mass") {
  const NetworkProblem problem = problem_of({.nodes = {10, 3, 5}});
  const LatticeNetwork<double> system(problem, true);
  const auto movable = (system.inverse_mass().array() > 0.0).count();
  CHECK(movable == problem.dof());
  CHECK(system.inverse_mass().allFinite());
}

TEST("a network is taken for a lattice only where every node and spring fits") {
  const LatticeShape shape{{4, 3, 5}, 0.01, 26};
  const SpringNetwork regular = uniform_lattice(shape, 50.0, 0.05, 1e-3);
  const auto found = lattice_of(regular);
  CHECK(found && found->nodes == shape.nodes);
  SpringNetwork mirrored = regular;
  mirrored.rest_position.row(0) *= -1.0;
  CHECK(lattice_of(mirrored).has_value());
  SpringNetwork flat = regular;
  flat.rest_position.row(2) *= 1.5;
  CHECK(!lattice_of(flat));
  SpringNetwork fewer = regular;
  fewer.springs.edit([&](std::vector<Spring>& all) { all.erase(all.begin() + 7); });
  CHECK(lattice_of(fewer).has_value());
  SpringNetwork moved = regular;
  moved.rest_position(1, 17) += 1e-6;
  CHECK(!lattice_of(moved));
  SpringNetwork longer = regular;
  longer.springs.edit([](std::vector<Spring>& all) { all[11].rest_length *= 1.0 + 1e-9; });
  CHECK(!lattice_of(longer));
  SpringNetwork reaching = regular;
  reaching.springs.push_back({0, 2, 50.0, 0.05, 0.02});
  CHECK(!lattice_of(reaching));
  SpringNetwork renumbered = regular;
  renumbered.rest_position.col(3).swap(renumbered.rest_position.col(9));
  CHECK(!lattice_of(renumbered));
  CHECK(!lattice_of(SpringNetwork{}));
}

TEST("rows are folded where that fills registers better, and not where they may sleep") {
  const LatticeShape cube{{20, 20, 20}, 0.01, 26};
  const LatticeRows folded(cube, 16, true);
  CHECK(folded.folds() == 4 && folded.pieces() == 4 && folded.vectors() == 5 && folded.rows1() == 5);
  CHECK(folded.row_of({0, 19, 0}) == 4 && folded.first_lane({0, 19, 0}) == 12);
  const LatticeRows plain(cube, 16, false);
  CHECK(plain.folds() == 1 && plain.vectors() == 2 && plain.rows1() == 20);
  CHECK(LatticeRows(cube, 4, true).folds() == 1);  // 20 nodes fill four lanes
  CHECK(LatticeRows({{2, 2, 2}, 0.01, 26}, 16, true).rows1() == 2);  // two rows of a layer stay
}

}  // namespace
