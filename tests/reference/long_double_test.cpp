// SPDX-License-Identifier: MIT
#include "reference/long_double.hpp"

#include "reference/arkode.hpp"
#include "reference/trajectory_error.hpp"
#include "tests/check.hpp"
#include "tests/reference/sample_problems.hpp"

using palpate::Load;
using palpate::NetworkProblem;
using palpate::PrintedForm;
using palpate::Problem;
using palpate::Profile;
using palpate::reference::peak_displacement;
using palpate::reference::Solution;
using palpate::reference::solve_arkode_explicit;
using palpate::reference::solve_long_double;
using palpate::reference::trajectory_error;

namespace {

const std::vector<double> times = sample::instants(0.03, 6);

palpate::SpringNetwork moving_block() {
  auto network = sample::block({.nodes = 3});
  const Eigen::Index n = network.node_count();
  network.initial_displacement = palpate::NodeVectors::Zero(3, n);
  network.initial_velocity = palpate::NodeVectors::Zero(3, n);
  network.initial_displacement.col(4) << 2e-4, -1e-4, 3e-4;
  network.initial_velocity.col(13) << 0.1, 0.05, -0.2;
  return network;
}

std::vector<Load> all_loads() {
  const Load step{.nodes = {3, 5}, .force = {0.0, 0.2, 0.0}, .start = 0.0, .end = 8e-3};
  const Load ramp{.nodes = {7},
                  .force = {0.1, 0.0, 0.2},
                  .start = 2e-3,
                  .end = 12e-3,
                  .profile = Profile::ramp};
  return {sample::pulse(0.5), step, ramp};
}

double disagreement(const Problem& specification, const NetworkProblem& truth) {
  const Solution a = solve_arkode_explicit(specification, times, {.relative = 1e-12});
  const Solution b = solve_long_double(truth, times, {.relative = 1e-14});
  return trajectory_error(a.position, b.position, peak_displacement(b.position));
}

}  // namespace

TEST("the specification and the equations written afresh agree, all terms at work") {
  const NetworkProblem problem(moving_block(), all_loads(), {1.0, -2.0, 9.81});
  const double error = disagreement(problem, problem);
  std::printf("  %.1e\n", error);
  CHECK_NEAR(error, 0.0, 3e-12);  // tolerance 1e-12; positions of 1e-2 m for motions of 5e-4 m
}

TEST("a stiffness that is 1.0001 times too large in the specification shows") {
  auto stiffer = moving_block();
  stiffer.springs.change_each([&](palpate::Spring& spring) { spring.stiffness *= 1.0001; });
  const NetworkProblem truth(moving_block(), all_loads());
  const NetworkProblem wrong(stiffer, all_loads());
  const double error = disagreement(wrong, truth);
  std::printf("  %.1e\n", error);
  CHECK(error > 1e-6);
}

TEST("one spring missing, a load switched late and half the damping show") {
  const NetworkProblem truth(moving_block(), all_loads());
  auto one_less = moving_block();
  one_less.springs.edit([&](std::vector<palpate::Spring>& all) { all.erase(all.begin()); });
  CHECK(disagreement(NetworkProblem(one_less, all_loads()), truth) > 1e-6);
  auto late = all_loads();
  late[1].start = 1e-5;
  CHECK(disagreement(NetworkProblem(moving_block(), late), truth) > 1e-6);
  auto slippery = moving_block();
  slippery.springs.change_each([&](palpate::Spring& spring) { spring.viscosity *= 0.5; });
  CHECK(disagreement(NetworkProblem(slippery, all_loads()), truth) > 1e-6);
}

TEST("the printed forms of the force law show") {
  const NetworkProblem truth(moving_block(), all_loads());
  for (const PrintedForm& form :
       {PrintedForm{.direction = true}, PrintedForm{.half_force = true}}) {
    CHECK(disagreement(NetworkProblem(moving_block(), all_loads(), {0.0, 0.0, 0.0}, form), truth) >
          1e-3);
  }
}

TEST("tightening the tolerance goes on improving where double has stopped") {
  const NetworkProblem problem(moving_block(), all_loads());
  const Solution finest = solve_long_double(problem, times, {.relative = 1e-17});
  const double peak = peak_displacement(finest.position);
  double before = 1.0;
  for (const double relative : {1e-8, 1e-10, 1e-12, 1e-14}) {
    const Solution s = solve_long_double(problem, times, {.relative = relative});
    const double error = trajectory_error(s.position, finest.position, peak);
    std::printf("  %.0e: %.1e\n", relative, error);
    CHECK(error < 0.2 * before);
    before = error;
  }
  CHECK(before < 1e-14);
}

TEST("an unknown kind of problem is refused") {
  const NetworkProblem problem(moving_block());
  const sample::Wrapped unknown(problem);
  CHECK_THROWS(solve_long_double(unknown, times, {}), "only networks and the oscillator");
}
