// SPDX-License-Identifier: MIT
/// Regular lattices shared by threads, moved in one pass, and asked for ahead: the same bits.
#include <limits>

#include "model/stepping/lattice_network.hpp"
#include "tests/check.hpp"
#include "tests/model/lattice_settings.hpp"

namespace {

using namespace palpate;
using namespace palpate::lattice_settings;

/// Threads from 1 to this share the lattices of `settings`, whatever the machine has.
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
        CHECK_NEAR(energy, InLanes<double>(problem, motion).system.measure(0.0, 0.0, lanes.q, lanes.v, f),
                   1e-14 * energy);
      }
    }
  }
}

enum class Steps { sweeps, one_pass };

/// 20 steps of semi-implicit Euler, in one pass each or in the scheme's own sweeps.
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

/// Those that ask memory ahead stand for those of a lattice that the caches hold.
lattice::Kernels<double> asking(lattice::Kernels<double> kernels, lattice::Fetch fetch) {
  for (auto* of_task : {&kernels.force, &kernels.undamped_force, &kernels.step, &kernels.undamped_step}) {
    of_task->kernels[0] = of_task->at(fetch);
  }
  return kernels;
}

TEST("kernels that ask memory ahead give the same bits, with all instructions that this processor has") {
  for (const Setting& at : settings) {
    const NetworkProblem problem = problem_of(at);
    const Motion motion = motion_of(problem);
    for (const lattice::Kernels<double>& kernels : lattice_kernels<double>()) {
      for (const auto fetch : {lattice::Fetch::rows, lattice::Fetch::rows_and_constants}) {
        const lattice::Kernels<double> fetching = asking(kernels, fetch);
        for (const int threads : {1, 2}) {
          for (const Steps steps : {Steps::sweeps, Steps::one_pass}) {
            CHECK(stepped<double>(problem, motion, threads, steps, fetching) ==
                  stepped<double>(problem, motion, threads, steps, kernels));
          }
        }
      }
    }
  }
}

TEST("a lattice is shared by no more threads than have two layers each, in rows of two vectors") {
  CHECK(LatticeSlabs<double>::most_threads(5, 3, 4) == 2);
  CHECK(LatticeSlabs<double>::most_threads(3, 3, 4) == 1);
  CHECK(LatticeSlabs<double>::most_threads(80, 20, 2) == 2);
  CHECK(LatticeSlabs<double>::most_threads(80, 1, 2) == 1);
}

}  // namespace
