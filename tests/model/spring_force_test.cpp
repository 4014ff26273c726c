// SPDX-License-Identifier: MIT
#include "model/dynamics/spring_force.hpp"

#include "model/dynamics/problem.hpp"
#include "tests/check.hpp"

namespace {

using namespace palpate;
using Eigen::Vector3d;

constexpr double k = 200.0;
constexpr double c = 0.4;
constexpr double rest = 0.5;

/// Force on end a at the origin; end b lies at d and leaves with velocity w.
Vector3d force_on_a(const PrintedForm& printed, const Vector3d& d, const Vector3d& w) {
  return spring_force<double>(SpringLaw::from(printed), k, c, rest, d, d.norm(),
                              w.dot(d) / d.norm());
}

const Vector3d stretched(0.0, 0.6, 0.8);  // length 1: 0.5 longer than at rest
const Vector3d unit = stretched;
const Vector3d still = Vector3d::Zero();

TEST("a stretched spring pulls its ends together and a compressed one pushes them apart") {
  CHECK_NEAR(force_on_a({}, stretched, still), Vector3d(k * 0.5 * unit), 1e-13);
  CHECK_NEAR(force_on_a({}, 0.25 * stretched, still), Vector3d(-k * 0.25 * unit), 1e-13);
}

TEST("a spring at rest length exerts no force") {
  CHECK_NEAR(force_on_a({}, 0.5 * stretched, still).norm(), 0.0, 1e-15);
}

TEST("the damper resists the extension rate and ignores sideways motion") {
  const Vector3d sideways(1.0, 0.0, 0.0);
  CHECK_NEAR(force_on_a({}, 0.5 * stretched, 3.0 * unit + sideways), Vector3d(3.0 * c * unit),
             1e-13);
}

TEST("the printed sign pushes a stretched spring's ends apart and keeps the damper") {
  const PrintedForm sign{.sign = true};
  CHECK_NEAR(force_on_a(sign, stretched, unit), Vector3d((-k * 0.5 + c) * unit), 1e-13);
}

TEST("the printed force turned round feeds energy in through the damper") {
  const PrintedForm reversed{.sign = true, .reversed = true};
  CHECK_NEAR(force_on_a(reversed, stretched, unit), Vector3d((k * 0.5 - c) * unit), 1e-13);
}

TEST("the printed direction scales the force with the length") {
  const Vector3d twice = 2.0 * stretched;
  CHECK_NEAR(force_on_a({.direction = true}, twice, still), Vector3d(k * 1.5 * twice), 1e-12);
  CHECK_NEAR(force_on_a({}, twice, still), Vector3d(k * 1.5 * unit), 1e-12);
}

TEST("the printed half force is half of each spring's force") {
  CHECK_NEAR(force_on_a({.half_force = true}, stretched, unit),
             Vector3d(0.5 * (k * 0.5 + c) * unit), 1e-13);
}

/// Two nodes joined by one spring, `gap` apart.
NetworkProblem pair_with_gap(double gap) {
  SpringNetwork network;
  network.rest_position = NodeVectors::Zero(3, 2);
  network.rest_position(0, 1) = gap;
  network.mass = Eigen::VectorXd::Ones(2);
  network.fixed = {0, 0};
  network.springs = {{0, 1, k, c, rest}};
  return NetworkProblem(network);
}

TEST("a spring of zero length exerts no force and makes no NaN") {
  for (const double gap : {0.0, 0.5 * zero_length}) {
    const NetworkProblem problem = pair_with_gap(gap);
    Eigen::VectorXd f(6);
    problem.force(0.0, 0.0, problem.initial_position(), Eigen::VectorXd::Ones(6), f);
    CHECK_NEAR(f.norm(), 0.0, 0.0);
  }
  const NetworkProblem short_one = pair_with_gap(2.0 * zero_length);
  Eigen::VectorXd f(6);
  short_one.force(0.0, 0.0, short_one.initial_position(), Eigen::VectorXd::Zero(6), f);
  CHECK_NEAR(f(0), k * (2.0 * zero_length - rest), 1e-9);
}

}  // namespace
