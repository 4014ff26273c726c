// SPDX-License-Identifier: MIT
#include "device/falcon/kinematics.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <numbers>

#include "tests/check.hpp"
#include "tests/device/falcon_poses.hpp"

namespace {

using namespace palpate::device::falcon;

const Kinematics falcon{};
constexpr double degree = std::numbers::pi / 180.0;

TEST("both published geometries give the five combinations that enter the kinematics") {
  const Geometry a = libnifalcon();
  CHECK_NEAR(a.link_offset(), 22.5e-3, 1e-15);
  CHECK_NEAR(a.radial_offset(), 25.57e-3, 1e-15);
  CHECK_NEAR(a.lateral_offset(), -1.91e-3, 1e-15);
  CHECK_NEAR(a.counts_per_radian() * degree, 27.446, 5e-4);  // to the digits published
  const Geometry b = martin_hillier();
  CHECK(b.thigh == 0.060 && b.shin == 0.1025);
  CHECK_NEAR(b.link_offset(), 23.0e-3, 1e-15);
  CHECK_NEAR(b.radial_offset(), 20.9e-3, 1e-15);
  CHECK_NEAR(b.lateral_offset(), 1.0e-3, 1e-15);
  CHECK_NEAR(b.counts_per_radian() * degree, 27.093, 5e-4);
}

TEST("the angles agree with Stamper's formulas in long double over the whole lens") {
  for (const Geometry& geometry : {libnifalcon(), martin_hillier()}) {
    const Kinematics kinematics(geometry);
    const auto lens = poses::reachable(geometry);
    CHECK(lens.size() > 4000);
    double worst = 0.0;
    int refused = 0;
    for (const Eigen::Vector3d& position : lens) {
      const auto angles = kinematics.inverse(position);
      refused += angles ? 0 : 1;
      if (!angles) { continue; }
      for (std::size_t leg = 0; leg < 3; ++leg) {
        const auto i = static_cast<Eigen::Index>(leg);
        const auto [t1, t2, t3] = poses::leg_angles(geometry, leg, position.cast<poses::Real>());
        worst = std::max({worst, std::abs(angles->theta1[i] - static_cast<double>(t1)),
                          std::abs(angles->theta2[i] - static_cast<double>(t2)),
                          std::abs(angles->theta3[i] - static_cast<double>(t3))});
      }
    }
    CHECK(refused <= 1);           // a corner of the second lens is another assembly
    CHECK_NEAR(worst, 0.0, 1e-8);  // asked for; reached: rounding
    std::printf("  worst angle error %.2g rad in %zu poses\n", worst, lens.size());
  }
}

TEST("forward undoes inverse, cold and warm, over the lens and at the edge of reach") {
  for (const Geometry& geometry : {libnifalcon(), martin_hillier()}) {
    const Kinematics kinematics(geometry);
    auto all = poses::reachable(geometry);
    const auto edge = poses::at_the_edge(geometry);
    all.insert(all.end(), edge.begin(), edge.end());
    std::erase_if(all, [&](const auto& p) { return !kinematics.inverse(p); });  // other assemblies
    CHECK(all.size() > 8000);
    double worst = 0.0;
    std::size_t lost = 0;
    for (const Eigen::Vector3d& position : all) {
      const auto angles = kinematics.inverse(position);
      CHECK(angles.has_value());
      if (!angles) { continue; }
      for (const Eigen::Vector3d& start :
           {Kinematics::cold_start(), Eigen::Vector3d(0.98 * position)}) {
        const auto back = kinematics.forward(angles->theta1, start);
        lost += back ? 0 : 1;
        if (back) { worst = std::max(worst, (*back - position).norm()); }
      }
    }
    CHECK(lost == 0);
    CHECK_NEAR(worst, 0.0, 1e-9);
    std::printf("  worst forward error %.2g m in %zu poses\n", worst, all.size());
  }
}

/// d(position)/d(theta1) by central differences of a forward solution in long double.
Eigen::Matrix3d differences(const Kinematics& kinematics, const Eigen::Vector3d& position) {
  const Geometry& geometry = kinematics.geometry();
  const poses::Real h = 1e-5L;
  const poses::Vector at = position.cast<poses::Real>();
  const poses::Vector theta = poses::theta1(geometry, at);
  const auto solve = [&](const poses::Vector& wanted) {
    poses::Vector guess = at;
    for (int n = 0; n < 8; ++n) {
      const Eigen::Matrix3d slope = *kinematics.jacobian(guess.cast<double>());
      guess += slope.cast<poses::Real>() * (wanted - poses::theta1(geometry, guess));
    }
    return guess;
  };
  Eigen::Matrix3d result;
  for (int leg = 0; leg < 3; ++leg) {
    const poses::Vector turn = h * poses::Vector::Unit(leg);
    result.col(leg) = ((solve(theta + turn) - solve(theta - turn)) / (2 * h)).cast<double>();
  }
  return result;
}

TEST("the Jacobian is the derivative of the forward solution") {
  for (const Geometry& geometry : {libnifalcon(), martin_hillier()}) {
    const Kinematics kinematics(geometry);
    for (const Eigen::Vector3d& position : poses::reachable(geometry, 0.012)) {
      const auto J = kinematics.jacobian(position);
      CHECK(J.has_value());
      if (J->cwiseAbs().maxCoeff() > 0.2) { continue; }  // about to collapse: differences blur
      // h^2/6 of the third derivative: at most some 10 m/rad^3 here
      CHECK_NEAR(*J, differences(kinematics, position), 1e-9);
      CHECK_NEAR(*J * inverse_jacobian(*kinematics.legs(position)), Eigen::Matrix3d::Identity(),
                 1e-12);
    }
  }
}

TEST("the curvature of the angles is the second derivative along a straight motion") {
  const Geometry geometry = libnifalcon();
  const Eigen::Vector3d velocity(0.3, -0.2, 0.4);
  const poses::Real h = 1e-5L;
  for (const Eigen::Vector3d& position : poses::reachable(geometry, 0.018)) {
    const auto legs = falcon.legs(position);
    const poses::Vector at = position.cast<poses::Real>();
    const poses::Vector step = h * velocity.cast<poses::Real>();
    const poses::Vector expected =
        (poses::theta1(geometry, at + step) - 2 * poses::theta1(geometry, at) +
         poses::theta1(geometry, at - step)) /
        (h * h);
    for (int i = 0; i < 3; ++i) {
      const double found = curvature_acceleration(geometry, falcon.frame(i),
                                                  (*legs)[static_cast<std::size_t>(i)], velocity);
      // h^2/12 of the fourth derivative, and rounding 1e-19 / h^2
      CHECK_NEAR(found, static_cast<double>(expected[i]), 1e-4 * (1.0 + std::abs(found)));
    }
  }
}

TEST("on the axis the arms stand at the published angles") {
  const std::array<std::array<double, 2>, 4> published{
      {{0.100, 8.0}, {0.125, 27.7}, {0.150, 47.2}, {0.175, 73.5}}};
  for (const auto& [z, angle] : published) {
    const auto angles = falcon.inverse({0.0, 0.0, z});
    CHECK(angles.has_value());
    for (const double theta1 : angles->theta1) {
      CHECK_NEAR(theta1 / degree, angle, 0.051);  // half a unit of the last digit
    }
  }
  CHECK(falcon.inverse({0.0, 0.0, 0.1829}).has_value());  // straightens at 0.183
  CHECK(!falcon.inverse({0.0, 0.0, 0.1835}).has_value());
}

TEST("at the centre a count, a radian and a newton are worth what was published") {
  const Eigen::Matrix3d J = *falcon.jacobian(Kinematics::centre());
  const double per_count = J.row(2).sum() / falcon.geometry().counts_per_radian();
  CHECK_NEAR(1e3 * per_count, 0.0482, 5e-5);
  CHECK_NEAR(1e3 * J.row(2).transpose(), Eigen::Vector3d::Constant(25.2), 0.05);
  const Eigen::Vector3d x = torque_of_force(J, Eigen::Vector3d::UnitX()).cwiseAbs();
  const Eigen::Vector3d y = torque_of_force(J, Eigen::Vector3d::UnitY()).cwiseAbs();
  const Eigen::Vector3d z = torque_of_force(J, Eigen::Vector3d::UnitZ());
  CHECK_NEAR(x, Eigen::Vector3d(0.018, 0.061, 0.043), 5e-4);
  CHECK_NEAR(y, Eigen::Vector3d(0.060, 0.014, 0.045), 5e-4);
  CHECK_NEAR(z, Eigen::Vector3d::Constant(0.0252), 5e-5);
}

TEST("force and torque undo each other, and do the same work") {
  const Eigen::Vector3d position(0.02, -0.03, 0.11);
  const Eigen::Matrix3d J = *falcon.jacobian(position);
  const Eigen::Vector3d force(1.0, -2.0, 3.0);
  const Eigen::Vector3d torque = torque_of_force(J, force);
  CHECK_NEAR(force_of_torque(J, torque), force, 1e-13);
  const Eigen::Vector3d velocity(0.1, 0.2, -0.3);
  const Eigen::Vector3d rate = inverse_jacobian(*falcon.legs(position)) * velocity;
  CHECK_NEAR(torque.dot(rate), force.dot(velocity), 1e-14);
}

TEST("what is beyond reach, behind the base or no number is refused") {
  const double nan = std::nan("");
  for (const Eigen::Vector3d& position :
       {Eigen::Vector3d(0.0, 0.0, 0.3), Eigen::Vector3d(0.5, 0.0, 0.1),
        Eigen::Vector3d(0.0, 0.0, 0.0), Eigen::Vector3d(0.0, 0.0, -0.125),
        Eigen::Vector3d(nan, 0.0, 0.1), Eigen::Vector3d(0.0, nan, 0.1),
        Eigen::Vector3d(0.0, 0.0, nan), Eigen::Vector3d(0.0, 0.0, HUGE_VAL)}) {
    CHECK(!falcon.inverse(position));
    CHECK(!falcon.jacobian(position));
  }
  CHECK(!falcon.forward({nan, 0.5, 0.5}));
  CHECK(!falcon.forward({-2.0, 2.0, 0.5}));  // these arms cannot hold one plate
}

TEST("the two geometries place the same counts a few millimetres apart") {
  const Kinematics other(martin_hillier());
  for (const Eigen::Vector3d& position : poses::reachable(libnifalcon(), 0.02)) {
    if ((position - Kinematics::centre()).norm() > 0.04) { continue; }
    const Eigen::Vector3d counts = (falcon.inverse(position)->theta1.array() - 35.0 * degree) *
                                   falcon.geometry().counts_per_radian();
    const auto there = other.forward((counts / other.geometry().counts_per_radian()).array() +
                                     other.geometry().zero_angle);
    CHECK(there.has_value());
    CHECK((*there - position).norm() < 9e-3);  // 9 mm and more only with the other zeros
  }
}

}  // namespace
