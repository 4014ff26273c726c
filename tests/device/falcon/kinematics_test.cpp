// SPDX-License-Identifier: MIT
/// Sample poses of the grip, and the kinematics as printed by Stamper in long double; only the
/// lengths are taken from device/.

#include "device/falcon/kinematics.hpp"

#include <Eigen/LU>

#include "device/falcon/driver.hpp"
#include "tests/check.hpp"

namespace poses {

using palpate::device::falcon::Geometry;
using Real = long double;
using Vector = Eigen::Matrix<Real, 3, 1>;

/// theta1, theta2, theta3 of one leg; NaN outside the workspace.
std::array<Real, 3> leg_angles(const Geometry& g, std::size_t leg, const Vector& position) {
  const Real phi = g.azimuth[leg];
  const Real u = position[0] * std::cos(phi) + position[1] * std::sin(phi) - Real(g.base_radius);
  const Real v = -position[0] * std::sin(phi) + position[1] * std::cos(phi) - Real(g.base_lateral);
  const Real a = g.thigh;
  const Real theta3 = std::acos((v + Real(g.effector_lateral)) / Real(g.shin));
  const Real reach = Real(g.knee_offset) + Real(g.foot_offset) + Real(g.shin) * std::sin(theta3);
  const Real outward = u + Real(g.effector_radius);
  const Real distance = std::hypot(outward, position[2]);
  const Real theta1 = std::atan2(position[2], outward) -
                      std::acos((distance * distance + a * a - reach * reach) / (2 * a * distance));
  const Real theta2 =
      std::atan2(position[2] - a * std::sin(theta1), outward - a * std::cos(theta1));
  return {theta1, theta2, theta3};
}

Vector theta1(const Geometry& g, const Vector& position) {
  Vector result;
  for (std::size_t leg = 0; leg < 3; ++leg) {
    result[static_cast<Eigen::Index>(leg)] = leg_angles(g, leg, position)[0];
  }
  return result;
}

/// All positions of a grid over the workspace between the joint stops (counts of -1600 to 1600).
std::vector<Eigen::Vector3d> reachable(const Geometry& g, double spacing = 0.006) {
  constexpr Real degree = 0.017453292519943295769L;
  std::vector<Eigen::Vector3d> result;
  for (double x = -0.11; x < 0.11; x += spacing) {
    for (double y = -0.11; y < 0.11; y += spacing) {
      for (double z = 0.05; z < 0.19; z += spacing) {
        const Vector theta = theta1(g, Eigen::Vector3d(x, y, z).cast<Real>());
        bool within = true;
        for (const Real angle : theta) {
          within = within && angle > -23 * degree && angle < 93 * degree;
        }
        if (within) { result.emplace_back(x, y, z); }
      }
    }
  }
  return result;
}

/// Positions 10 nm to 1 mm inside the outer border of the workspace, found by bisection.
std::vector<Eigen::Vector3d> at_the_edge(const Geometry& g) {
  std::vector<Eigen::Vector3d> result;
  for (int n = 0; n < 400; ++n) {
    const double turn = 2.399963229728653 * n;  // golden angle: even cover of a half sphere
    const double rise = (n + 0.5) / 400.0;
    const double flat = std::sqrt(1.0 - rise * rise);
    const Eigen::Vector3d direction(flat * std::cos(turn), flat * std::sin(turn), rise);
    const Eigen::Vector3d centre(0.0, 0.0, 0.125);
    double inside = 0.0;
    double outside = 0.3;
    for (int bisection = 0; bisection < 60; ++bisection) {
      const double middle = 0.5 * (inside + outside);
      const Eigen::Vector3d point = centre + middle * direction;
      const bool within = theta1(g, point.cast<Real>()).allFinite() && point.z() > 0.0;
      (within ? inside : outside) = middle;
    }
    for (const double gap : {1e-8, 1e-6, 1e-4, 1e-3}) {
      result.push_back(centre + (inside - gap) * direction);
    }
  }
  return result;
}

}  // namespace poses

namespace PALPATE_FILE {

using namespace palpate::device::falcon;

const Kinematics falcon{};
constexpr double degree = std::numbers::pi / 180.0;

TEST("both published geometries give the five combinations that enter the kinematics") {
  const Geometry a = libnifalcon();
  const auto offsets = [](const Geometry& g) {
    return Eigen::Vector3d(g.link_offset(), g.radial_offset(), g.lateral_offset());
  };
  CHECK_NEAR(offsets(a), Eigen::Vector3d(22.5e-3, 25.57e-3, -1.91e-3), 1e-15);
  CHECK_NEAR(a.counts_per_radian() * degree, 27.446, 5e-4);  // to the digits published
  const Geometry b = martin_hillier();
  CHECK(b.thigh == 0.060);
  CHECK(b.shin == 0.1025);
  CHECK_NEAR(offsets(b), Eigen::Vector3d(23.0e-3, 20.9e-3, 1.0e-3), 1e-15);
  CHECK_NEAR(b.counts_per_radian() * degree, 27.093, 5e-4);
}

TEST("the angles agree with Stamper's formulas in long double over the whole lens") {
  for (const Geometry& geometry : {libnifalcon(), martin_hillier()}) {
    const Kinematics kinematics(geometry);
    const auto lens = poses::reachable(geometry);
    CHECK(lens.size() > 4000);
    int refused = 0;
    for (const Eigen::Vector3d& position : lens) {
      const auto angles = kinematics.inverse(position);
      refused += angles ? 0 : 1;
      if (!angles) { continue; }
      for (int leg = 0; leg < 3; ++leg) {
        const auto [t1, t2, t3] = poses::leg_angles(geometry, static_cast<std::size_t>(leg),
                                                    position.cast<poses::Real>());
        const Eigen::Vector3d found(angles->theta1[leg], angles->theta2[leg], angles->theta3[leg]);
        CHECK_NEAR(found, poses::Vector(t1, t2, t3).cast<double>(), 1e-8);  // required
      }
    }
    CHECK(refused <= 1);  // a corner of the second lens is another assembly
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
    for (const Eigen::Vector3d& position : all) {
      const auto angles = kinematics.inverse(position);
      REQUIRE(angles.has_value());
      for (const Eigen::Vector3d& start :
           {Kinematics::cold_start(), Eigen::Vector3d(0.98 * position)}) {
        const auto back = kinematics.forward(angles->theta1, start);
        REQUIRE(back.has_value());
        CHECK_NEAR((*back - position).norm(), 0.0, 1e-9);
      }
    }
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
      REQUIRE(J.has_value());
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

TEST("on the axis the arms have the published angles") {
  const std::array<std::array<double, 2>, 4> published{
      {{0.100, 8.0}, {0.125, 27.7}, {0.150, 47.2}, {0.175, 73.5}}};
  for (const auto& [z, angle] : published) {
    const auto angles = falcon.inverse({0.0, 0.0, z});
    REQUIRE(angles.has_value());
    for (const double theta1 : angles->theta1) {
      CHECK_NEAR(theta1 / degree, angle, 0.051);  // half a unit of the last digit
    }
  }
  CHECK(falcon.inverse({0.0, 0.0, 0.1829}).has_value());  // straightens at 0.183
  CHECK(!falcon.inverse({0.0, 0.0, 0.1835}).has_value());
}

TEST("at the centre a count, a radian and a newton have their published effect") {
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

TEST("positions beyond reach, behind the base or not finite are refused") {
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
    REQUIRE(there.has_value());
    CHECK((*there - position).norm() < 9e-3);  // 9 mm and more only with the other zeros
  }
}

using Vector = Eigen::Vector3d;

/// Force of the exact mechanism for torques computed with the stock Jacobian.
Eigen::Matrix3d stock_gain(const Vector& position) {
  const Eigen::Matrix3d J = *falcon.jacobian(position);
  return J.transpose().inverse() * stock_jacobian(falcon, position)->transpose();
}

/// Core of the workspace: these limits give the published range of the displacement per count,
/// 0.030 to 0.059 mm.
std::vector<Vector> core() {
  std::vector<Vector> result;
  for (double x = -0.030; x < 0.031; x += 0.005) {
    for (double y = -0.030; y < 0.031; y += 0.005) {
      for (double z = 0.095; z < 0.156; z += 0.005) { result.emplace_back(x, y, z); }
    }
  }
  return result;
}

double quantile(std::vector<double> values, double share) {
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

TEST("the stock Jacobian gives too much force in z on the axis, as published") {
  for (const auto& [z, gain] :
       {std::pair{0.095, 1.37}, std::pair{0.125, 1.29}, std::pair{0.155, 1.16}}) {
    CHECK_NEAR(stock_gain({0.0, 0.0, z})(2, 2), gain, 0.0051);  // half a unit of the last digit
  }
}

TEST("the stock Jacobian leaves x and y exact everywhere and leaks them into z") {
  std::vector<double> leak, gain;
  for (const Vector& position : core()) {
    const Eigen::Matrix3d G = stock_gain(position);
    CHECK_NEAR(G.topRows<2>(), Eigen::Matrix3d::Identity().topRows<2>(), 1e-12);
    leak.push_back(std::abs(G(2, 0)));
    leak.push_back(std::abs(G(2, 1)));
    gain.push_back(G(2, 2));
  }
  // Published for other poses: median 0.11, 95 % 0.24, largest 0.31; gain 0.95 to 1.36.
  CHECK_NEAR(quantile(leak, 0.5), 0.11, 0.03);
  CHECK_NEAR(quantile(leak, 0.95), 0.24, 0.04);
  CHECK_NEAR(quantile(leak, 1.0), 0.31, 0.04);
  CHECK_NEAR(quantile(gain, 0.0), 0.95, 0.02);
  CHECK_NEAR(quantile(gain, 1.0), 1.36, 0.02);
}

/// Largest displacement of half a count on each leg [m].
double rounding_at(const Vector& position) {
  const Eigen::Matrix3d J = *falcon.jacobian(position);
  double worst = 0.0;
  for (int signs = 0; signs < 8; ++signs) {
    const Vector half(signs & 1 ? 0.5 : -0.5, signs & 2 ? 0.5 : -0.5, signs & 4 ? 0.5 : -0.5);
    worst = std::max(worst, (J * half).norm() / libnifalcon().counts_per_radian());
  }
  return worst;
}

TEST("a correct read-out is within the rounding of the counts, a stock one is not") {
  DriverProfile correct(DriverProfile::Kind::correct);
  std::vector<double> cold;
  for (const Vector& position : core()) {
    const Counts counts = counts_of_angles(libnifalcon(), falcon.inverse(position)->theta1);
    // Rounding, and the curvature within a count.
    CHECK((correct.position(counts) - position).norm() < rounding_at(position) + 1e-6);
    DriverProfile fresh(DriverProfile::Kind::stock);
    cold.push_back((fresh.position(counts) - position).norm());
  }
  CHECK_NEAR(1e3 * quantile(cold, 0.5), 0.20, 0.03);  // published median
  CHECK(quantile(cold, 1.0) < 1.8e-3);                // published maximum
}

/// Remaining part of a small error after one step of the stock solution, along an axis.
double residual(int axis) {
  DriverProfile stock(DriverProfile::Kind::stock);
  const Geometry geometry = libnifalcon();
  const Vector from = Kinematics::centre();
  const Counts counts = counts_of_angles(geometry, falcon.inverse(from)->theta1);
  const Vector target = *falcon.forward(angles_of_counts(geometry, counts));
  for (int n = 0; n < 100; ++n) { stock.position(counts); }
  const Vector beside = target + 1e-4 * Vector::Unit(axis);
  const Counts moved = counts_of_angles(geometry, falcon.inverse(beside)->theta1);
  const Vector goal = *falcon.forward(angles_of_counts(geometry, moved));
  const Vector before = stock.position(counts) - goal;
  const Vector after = stock.position(moved) - goal;
  return after[axis] / before[axis];
}

TEST("at loop rate the stock read-out leaves 0.36 of an error in z and half in x and y") {
  CHECK_NEAR(residual(2), 0.36, 0.01);
  CHECK_NEAR(residual(0), 0.50, 0.03);  // the counts' rounding turns the step by a few degrees
  CHECK_NEAR(residual(1), 0.50, 0.03);
}

TEST("in a steady ramp along z the stock read-out lags by 0.55 sample") {
  DriverProfile stock(DriverProfile::Kind::stock);
  const double speed = 2e-4;  // per sample; slow enough for one half step a call
  double lag = 0.0;
  for (int n = 0; n < 100; ++n) {
    const Vector position(0.0, 0.0, 0.115 + speed * n);
    const Counts counts = counts_of_angles(libnifalcon(), falcon.inverse(position)->theta1);
    const Vector truth = *falcon.forward(angles_of_counts(libnifalcon(), counts));
    const double behind = (truth - stock.position(counts)).z() / speed;
    if (n >= 40 && n < 60) { lag += 0.05 * behind; }  // about the centre
  }
  CHECK_NEAR(lag, 0.55, 0.03);  // the sum of 0.36^n from n = 1 is 0.56
}

}  // namespace PALPATE_FILE
