// SPDX-License-Identifier: MIT
#include "reference/static_response.hpp"

#include "reference/linear_problem.hpp"
#include "reference/static_equilibrium.hpp"
#include "tests/check.hpp"
#include "tests/reference/sample_problems.hpp"

using Eigen::VectorXd;
using palpate::NetworkProblem;
using namespace palpate::reference;

namespace {

NetworkProblem free_block() {
  auto network = sample::block({.nodes = 3});
  std::ranges::fill(network.fixed, std::uint8_t{0});
  return NetworkProblem(network);
}

}  // namespace

TEST("the response is the limit of small loads") {
  const Eigen::Vector3d load(3e-7, -1e-7, -2e-6);
  const NetworkProblem problem = sample::tripod(load);
  const VectorXd linear = StaticResponse(problem)(load);
  const VectorXd moved = static_equilibrium(problem).position - problem.initial_position();
  CHECK_NEAR(moved / linear.norm(), VectorXd(linear / linear.norm()), 1e-5);
  CHECK_NEAR(LinearProblem(problem).stiffness() * linear, VectorXd(load), 1e-18);
}

TEST("factors and conjugate gradients give the same answer") {
  const NetworkProblem problem(sample::block({.nodes = 5}));
  VectorXd load = VectorXd::Zero(problem.dof());
  load(2) = 1.0;
  load(7) = -0.3;
  const StaticResponse factorised(problem);
  const VectorXd exact = factorised(load);
  // A relative residual of 1e-10, times a condition of a few hundred.
  CHECK_NEAR(StaticResponse(problem, 0)(load) / exact.norm(), VectorXd(exact / exact.norm()), 1e-7);
  CHECK_NEAR(factorised.compliance(load), load.dot(exact), 1e-18);
}

TEST("Maxwell and Betti: pushing here moves there as pushing there moves here") {
  const NetworkProblem problem(sample::block({.nodes = 4}));
  const StaticResponse response(problem);
  VectorXd here = VectorXd::Zero(problem.dof());
  VectorXd there = here;
  here(0) = 1.0;
  there(20) = 1.0;
  CHECK_NEAR(response(here)(20) / response(there)(0), 1.0, 1e-12);
}

TEST("a body that can move freely is an error") {
  const NetworkProblem problem = free_block();
  CHECK_THROWS(StaticResponse(problem)(VectorXd::Unit(problem.dof(), 0)), "move freely");
}
