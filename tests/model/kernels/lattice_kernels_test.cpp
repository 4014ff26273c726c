// SPDX-License-Identifier: MIT
/// Kernels of small regular lattices of many shapes in motion.

#include <array>
#include <limits>
#include <vector>

#include "model/kernels/lattice_network.hpp"
#include "model/tissue/lattice.hpp"
#include "model/tissue/network_builder.hpp"
#include "tests/check.hpp"
#include "tests/model/sample_scenes.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using Eigen::VectorXd;

struct Setting {
  std::array<int, 3> nodes{};
  int connectivity = 26;
  bool damped = true;
  bool uneven = false;  ///< stiffness and viscosity of its own for every spring
  bool held = true;
};

NetworkProblem problem_of(const Setting& at) {
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
  const std::vector<Load> loads{
      {.nodes = {2, 7, 7}, .force = {0.1, -0.2, 0.3}},
      {.nodes = {count - 1, count / 2, 3, 2 * count / 3}, .force = {0.0, 0.4, -0.1}}};
  return NetworkProblem(network, loads, {0.3, -0.2, 9.81});
}

struct Motion {
  VectorXd q;
  VectorXd v;
};
Motion motion_of(const NetworkProblem& problem) {
  Random random(4);
  return {problem.initial_position() + random.vector(problem.dof(), 2e-3),
          random.vector(problem.dof(), 0.5)};
}

template <class Real> struct InLanes {
  InLanes(const NetworkProblem& problem, const Motion& motion, bool skip = true,
          const lattice::Kernels<Real>& kernels = lattice_kernels<Real>().front(), int threads = 1)
      : owner(make_lattice_network<Real>(problem,
                                         {.skip = skip, .threads = threads, .kernels = kernels})),
        system(*owner),
        q(system.initial_position()),
        v(system.initial_velocity()) {
    scatter(motion.q, system.layout(), q);
    scatter(motion.v, system.layout(), v);
  }
  VectorXd packed(const Vector<Real>& all, Eigen::Index dof) {
    VectorXd out(dof);
    gather(all, system.layout(), out);
    return out;
  }
  std::unique_ptr<NetworkSystem<Real>> owner;
  NetworkSystem<Real>& system;
  Vector<Real> q, v;
};

const std::vector<Setting> settings{
    {.nodes = {4, 4, 4}},
    {.nodes = {10, 3, 5}},
    {.nodes = {2, 2, 2}, .held = false},
    {.nodes = {3, 9, 4}, .damped = false},
    {.nodes = {5, 4, 17}, .uneven = true},
    {.nodes = {11, 7, 3}, .damped = false, .uneven = true},
    {.nodes = {6, 5, 4}, .connectivity = 6},
    {.nodes = {9, 5, 4}, .connectivity = 18, .uneven = true, .held = false},
    // Short rows, which are interleaved in registers of four, eight and sixteen lanes.
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

// Kernels of regular lattices compared with NetworkProblem, the specification.

/// Roundings of a node's 26 springs, each k (L - L0) from lengths of 0.01 m.
double rounding_of(const VectorXd& force, double epsilon) {
  return 30.0 * epsilon * (force.cwiseAbs().maxCoeff() + 250.0 * 0.02);
}

/// Compares forces with all instruction sets of this processor, and with the baseline of its
/// architecture.
void check_forces(const NetworkProblem& problem, const Motion& motion) {
  VectorXd expected(problem.dof());
  problem.force(0.0, 0.0, motion.q, motion.v, expected);
  for (const auto& kernels : lattice_kernels<double>()) {
    CHECK_NEAR(force_of<double>(problem, motion, true, kernels), expected,
               rounding_of(expected, 2.3e-16));
  }
  for (const auto& kernels : lattice_kernels<float>()) {
    CHECK_NEAR(force_of<float>(problem, motion, true, kernels), expected,
               rounding_of(expected, 1.2e-7));
  }
}

TEST("forces equal the specification to rounding, for any shape, springs and instructions") {
  for (const Setting& at : settings) {
    const NetworkProblem problem = problem_of(at);
    check_forces(problem, motion_of(problem));
  }
}

TEST("two nodes at one place exert no force on each other, whatever the instructions") {
  for (const bool damped : {true, false}) {
    const NetworkProblem problem =
        problem_of({.nodes = {10, 6, 5}, .damped = damped, .held = false});
    Motion motion = motion_of(problem);
    const LatticeShape shape{{10, 6, 5}, 0.01, 26};
    const auto place = [&](int i) {
      return motion.q.segment<3>(problem.coordinate(shape.index(i, 3, 2)));
    };
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

TEST("computing the parts that a lattice does not need changes no bit") {
  for (const Setting& at : settings) {
    const NetworkProblem problem = problem_of(at);
    const Motion motion = motion_of(problem);
    CHECK_NEAR(force_of<double>(problem, motion, false), force_of<double>(problem, motion, true),
               0.0);
    CHECK_NEAR(force_of<float>(problem, motion, false), force_of<float>(problem, motion, true),
               0.0);
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

TEST("fixed nodes and the padding of rows have no inverse mass") {
  const NetworkProblem problem = problem_of({.nodes = {10, 3, 5}});
  const auto system = make_lattice_network<double>(problem);
  const auto movable = (system->inverse_mass().array() > 0.0).count();
  CHECK(movable == problem.dof());
  CHECK(system->inverse_mass().allFinite());
}

/// Checks whether a changed copy of a lattice still is one.
void check_lattice(SpringNetwork network, bool expected, auto change) {
  change(network);
  CHECK(network.springs.lattice().has_value() == expected);
}

TEST("a list of springs is a lattice until one spring does not belong to it") {
  const LatticeShape shape{{4, 3, 5}, 0.01, 26};
  const SpringNetwork regular = uniform_lattice(shape, 50.0, 0.05, 1e-3);
  REQUIRE(regular.springs.lattice());
  CHECK(regular.springs.lattice()->nodes == shape.nodes);
  using Springs = std::vector<Spring>;
  check_lattice(regular, true, [](SpringNetwork& n) {
    n.springs.change_each([](Spring& spring) { spring.stiffness *= 2.0; });
  });
  check_lattice(regular, true, [](SpringNetwork& n) {
    n.springs.edit([](Springs& all) { all.erase(all.begin() + 7); });
  });
  check_lattice(regular, false, [](SpringNetwork& n) {
    n.springs.edit([](Springs& all) { all[11].rest_length *= 1.0 + 1e-9; });
  });
  check_lattice(regular, false, [](SpringNetwork& n) {
    n.springs.push_back({0, 2, 50.0, 0.05, 0.02});
  });
}

TEST("a network of a list is recognised as a lattice only where every node and spring fits") {
  SpringNetwork regular = uniform_lattice({{4, 3, 5}, 0.01, 26}, 50.0, 0.05, 1e-3);
  regular.springs = SpringList(regular.springs.listed());
  const auto recognised = [&](bool expected, auto change) {
    check_lattice(regular, expected, [&](SpringNetwork& n) {
      change(n);
      recognise_lattice(n);
    });
  };
  recognised(true, [](SpringNetwork&) {});
  recognised(true, [](SpringNetwork& n) { n.rest_position.row(0) *= -1.0; });
  recognised(false, [](SpringNetwork& n) { n.rest_position.row(2) *= 1.5; });
  recognised(false, [](SpringNetwork& n) { n.rest_position(1, 17) += 1e-6; });
  recognised(false, [](SpringNetwork& n) { n.springs.push_back({0, 2, 50.0, 0.05, 0.02}); });
  recognised(false, [](SpringNetwork& n) { n.rest_position.col(3).swap(n.rest_position.col(9)); });
  recognised(false, [](SpringNetwork& n) { n = {}; });
}

TEST("rows are interleaved where that fills registers better, and not where they may sleep") {
  const LatticeShape cube{{20, 20, 20}, 0.01, 26};
  const LatticeRows folded(cube, 16, true);
  CHECK(folded.folds == 4);
  CHECK(folded.pieces == 4);
  CHECK(folded.vectors == 5);
  CHECK(folded.rows1 == 5);
  CHECK(folded.row_of({0, 19, 0}) == 4);
  CHECK(folded.first_lane({0, 19, 0}) == 12);
  const LatticeRows plain(cube, 16, false);
  CHECK(plain.folds == 1);
  CHECK(plain.vectors == 2);
  CHECK(plain.rows1 == 20);
  CHECK(LatticeRows(cube, 4, true).folds == 1);                    // 20 nodes fill four lanes
  CHECK(LatticeRows({{2, 2, 2}, 0.01, 26}, 16, true).rows1 == 2);  // two rows of a layer stay
}

// Regular lattices with several threads, single-pass integration and prefetch: results are
// identical.

/// Maximum number of threads for the lattices of `settings`, independent of the machine.
constexpr int most_threads = 4;

TEST("threads that share a lattice compute the same bits as one") {
  for (const Setting& at : settings) {
    const NetworkProblem problem = problem_of(at);
    const Motion motion = motion_of(problem);
    const VectorXd expected = force_of<double>(problem, motion);
    for (int threads = 2; threads <= most_threads; ++threads) {
      InLanes<double> lanes(problem, motion, true, lattice_kernels<double>().front(), threads);
      for (int round = 0; round < 3; ++round) {
        Vector<double> f(lanes.q.size());
        lanes.system.force(0.0, 0.0, lanes.q, lanes.v, f);
        CHECK(lanes.packed(f, problem.dof()) == expected);
        const double energy = lanes.system.measure(0.0, 0.0, lanes.q, lanes.v, f);
        CHECK(lanes.packed(f, problem.dof()) == expected);
        CHECK_NEAR(energy,
                   InLanes<double>(problem, motion).system.measure(0.0, 0.0, lanes.q, lanes.v, f),
                   1e-14 * energy);
      }
    }
  }
}

enum class Steps { sweeps, one_pass };

/// 20 steps of semi-implicit Euler, as a single pass or as the separate sweeps of the scheme.
template <class Real>
VectorXd stepped(const NetworkProblem& problem, const Motion& motion, int threads, Steps steps,
                 const lattice::Kernels<Real>& kernels = lattice_kernels<Real>().front()) {
  InLanes<Real> lanes(problem, motion, true, kernels, threads);
  State<Real> state{lanes.q, lanes.v};
  Vector<Real> a(lanes.q.size());
  const Real h = Real(1e-4);
  lanes.system.prepare_one_pass();
  for (int n = 0; n < 20; ++n) {
    if (steps != Steps::sweeps) {
      const double squares = lanes.system.one_pass(0.0, 0.0, h, state);
      CHECK_NEAR(squares, static_cast<double>(state.velocity.squaredNorm()),
                 100.0 * static_cast<double>(std::numeric_limits<Real>::epsilon()) * squares);
      continue;
    }
    lanes.system.acceleration(0.0, 0.0, state.position, state.velocity, a);
    state.velocity += h * a;
    state.position += h * state.velocity;
  }
  VectorXd all(2 * problem.dof());
  all << lanes.packed(state.position, problem.dof()), lanes.packed(state.velocity, problem.dof());
  return all;
}

TEST("a step in one pass gives the bits of sweeps one after another, with any number of threads") {
  for (const Setting& at : settings) {
    const NetworkProblem problem = problem_of(at);
    const Motion motion = motion_of(problem);
    const VectorXd expected = stepped<double>(problem, motion, 1, Steps::sweeps);
    const VectorXd expected_float = stepped<float>(problem, motion, 1, Steps::sweeps);
    CHECK(expected.allFinite());
    for (int threads = 1; threads <= most_threads; ++threads) {
      CHECK(stepped<double>(problem, motion, threads, Steps::one_pass) == expected);
      CHECK(stepped<float>(problem, motion, threads, Steps::one_pass) == expected_float);
    }
  }
}

/// Kernels with prefetch, used in place of those for a lattice that fits into the caches.
lattice::Kernels<double> asking(lattice::Kernels<double> kernels, lattice::Fetch fetch) {
  for (auto* of_task :
       {&kernels.force, &kernels.undamped_force, &kernels.step, &kernels.undamped_step}) {
    of_task->kernels[0] = of_task->at(fetch);
  }
  return kernels;
}

TEST("kernels with prefetch give the same bits, with every instruction set of this processor") {
  for (const Setting& at : settings) {
    const NetworkProblem problem = problem_of(at);
    const Motion motion = motion_of(problem);
    for (const lattice::Kernels<double>& kernels : lattice_kernels<double>()) {
      for (const int threads : check::sanitized ? std::vector{2} : std::vector{1, 2}) {
        for (const Steps steps : {Steps::sweeps, Steps::one_pass}) {
          const auto plain = stepped<double>(problem, motion, threads, steps, kernels);
          for (const auto fetch : {lattice::Fetch::rows, lattice::Fetch::rows_and_constants}) {
            const lattice::Kernels<double> fetching = asking(kernels, fetch);
            CHECK(stepped<double>(problem, motion, threads, steps, fetching) == plain);
          }
        }
      }
    }
  }
}

TEST("a lattice is shared by no more threads than have two layers each, in rows of two vectors") {
  CHECK(most_lattice_threads(5, 3, 4) == 2);
  CHECK(most_lattice_threads(3, 3, 4) == 1);
  CHECK(most_lattice_threads(80, 20, 2) == 2);
  CHECK(most_lattice_threads(80, 1, 2) == 1);
}

}  // namespace PALPATE_FILE
