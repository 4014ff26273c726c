// SPDX-License-Identifier: MIT
#include "model/stepping/held_response.hpp"

#include <random>

#include <Eigen/LU>

#include "tests/check.hpp"

using namespace palpate;
using Eigen::VectorXd;
using Square = Eigen::Matrix<double, 10, 10>;

namespace {

struct Setting {
  Square p = Square::Zero();  ///< symmetric, positive definite
  Eigen::Matrix<double, 10, 1> mass{};
};

/// Three nodes and a tool as the last coordinate, which no spring touches.
Setting setting() {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  Setting made;
  Square some;
  for (double& entry : some.reshaped()) { entry = any(random); }
  made.p = some * some.transpose();
  made.p.row(9).setZero();
  made.p.col(9).setZero();
  for (int node = 0; node < 3; ++node) { made.mass.segment<3>(3 * node).setConstant(2.0 + any(random)); }
  made.mass(9) = 1.5;
  made.p.diagonal() += made.mass;
  return made;
}

}  // namespace

TEST("a corrected solution is that of the saddle system") {
  const Setting s = setting();
  using Response = HeldResponse<double>;
  const std::vector<Response::Support> supports{{0, 0.25, 1.0 / s.mass(0)},
                                                {3, 0.75, 1.0 / s.mass(3)},
                                                {3, 0.5, 1.0 / s.mass(3)},
                                                {6, 0.5, 1.0 / s.mass(6)}};
  Response response;
  const Eigen::PartialPivLU<Square> factors(s.p);
  response.learn(supports, {0, 2, 4}, 9, s.mass(9), 10,
                 [&](const VectorXd& right, VectorXd& x) { x = factors.solve(right); });
  const Eigen::Vector3d along(0.0, 0.6, 0.8);
  Eigen::Matrix<double, 2, 10> w;
  w.setZero();
  const auto knot_row = [&](std::size_t knot, const Eigen::Vector3d& direction, Eigen::Index row) {
    for (std::size_t i = 2 * knot; i < 2 * knot + 2; ++i) {
      w.row(row).segment<3>(supports[i].coordinate) += supports[i].weight * direction.transpose();
    }
  };
  response.clear();
  const auto tip = response.add_row(0, 2, 1.0);
  tip[0] = -0.3 * along;
  tip[1] = -0.7 * along;
  response.add_row(1, 1, 0.0)[0] = Eigen::Vector3d::UnitX();
  response.factorise();
  knot_row(0, -0.3 * along, 0);
  knot_row(1, -0.7 * along, 0);
  w(0, 9) = 1.0;
  knot_row(1, Eigen::Vector3d::UnitX(), 1);

  const VectorXd r = VectorXd::LinSpaced(10, -1.0, 2.0);
  VectorXd x = factors.solve(r);
  response.correct(r, x);
  Eigen::Matrix<double, 12, 12> saddle = Eigen::Matrix<double, 12, 12>::Zero();
  saddle.topLeftCorner(10, 10) = s.p;
  saddle.topRightCorner(10, 2) = -w.transpose();
  saddle.bottomLeftCorner(2, 10) = w;
  Eigen::Matrix<double, 12, 1> right;
  right.head(10) = r;
  right.tail(2) = w * r.cwiseQuotient(s.mass);
  const Eigen::Matrix<double, 12, 1> exact = saddle.partialPivLu().solve(right);
  CHECK_NEAR(x, VectorXd(exact.head(10)), 1e-12);
}

TEST("the response of a row, and of a place between two knots, is that of the matrix") {
  const Setting s = setting();
  HeldResponse<double> response;
  const Eigen::PartialPivLU<Square> factors(s.p);
  response.learn({{0, 1.0, 1.0}, {3, 1.0, 1.0}}, {0, 1, 2}, -1, 1.0, 10,
                 [&](const VectorXd& right, VectorXd& x) { x = factors.solve(right); });
  const Eigen::Vector3d along(0.0, 0.6, 0.8);
  VectorXd w = VectorXd::Zero(10);
  w.segment<3>(0) = 0.3 * along;
  w.segment<3>(3) = 0.7 * along;
  const double expected = w.dot(VectorXd(factors.solve(w)));
  CHECK_NEAR(response.response_at(0, 0.7, along), expected, 1e-12);
  CHECK_NEAR(response.response_at(1, 0.0, along),
             along.dot(factors.inverse().block<3, 3>(3, 3) * along), 1e-12);
  response.clear();
  response.add_row(1, 1, 0.0)[0] = Eigen::Vector3d::UnitX();
  const auto row = response.add_row(0, 2, 0.0);
  row[0] = 0.3 * along;
  row[1] = 0.7 * along;
  response.factorise();
  CHECK_NEAR(response.response_of(1), expected, 1e-12);
}

TEST("nothing held changes nothing") {
  const Setting s = setting();
  HeldResponse<double> response;
  const Eigen::PartialPivLU<Square> factors(s.p);
  response.learn({{0, 1.0, 1.0}}, {0, 1}, -1, 1.0, 10,
                 [&](const VectorXd& right, VectorXd& x) { x = factors.solve(right); });
  response.clear();
  response.factorise();
  VectorXd x = VectorXd::Ones(10);
  response.correct(VectorXd::Ones(10), x);
  CHECK(x == VectorXd::Ones(10));
}
