// SPDX-License-Identifier: MIT

#include "reference/least_squares.hpp"

#include <cmath>
#include <stdexcept>

#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate::reference;

TEST("a straight line gives the closed form of its normal equations") {
  Eigen::MatrixXd design(4, 2);
  design << 1, 0, 1, 1, 1, 2, 1, 3;
  const Eigen::Vector4d seen(1.0, 2.9, 5.2, 6.8);
  const LeastSquaresProblem line{
      .residuals = [&](const Eigen::VectorXd& x) { return Eigen::VectorXd(design * x - seen); },
      .jacobian = [&](const Eigen::VectorXd&) { return design; }};
  const LeastSquaresSolution found = least_squares(line, Eigen::Vector2d(10.0, -4.0));
  // Mean 3.975 at 1.5; slope sum (t - 1.5) y / 5 = (-1.5 - 1.45 + 2.6 + 10.2) / 5
  CHECK(found.converged);
  CHECK_NEAR(found.x[1], 1.97, 1e-6);  // the step tolerance, on a quadratic far better
  CHECK_NEAR(found.x[0], 3.975 - 1.5 * 1.97, 1e-6);
}

TEST("Rosenbrock's valley ends at (1, 1)") {
  const LeastSquaresProblem valley{
      .residuals =
          [](const Eigen::VectorXd& x) {
            return Eigen::VectorXd(Eigen::Vector2d(10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]));
          },
      .jacobian =
          [](const Eigen::VectorXd& x) {
            Eigen::MatrixXd j(2, 2);
            j << -20.0 * x[0], 10.0, -1.0, 0.0;
            return j;
          }};
  const LeastSquaresSolution found =
      least_squares(valley, Eigen::Vector2d(-1.2, 1.0), {.most_iterations = 100});
  CHECK(found.converged);
  CHECK_NEAR(found.x, Eigen::Vector2d(1.0, 1.0), 1e-4);  // the step tolerance
}

TEST("a start that no step improves is the solution, also on a staircase") {
  const LeastSquaresProblem stairs{
      .residuals =
          [](const Eigen::VectorXd& x) {
            return Eigen::VectorXd(
                Eigen::VectorXd::Constant(1, std::round(10.0 * x[0]) / 10.0 - 1.04));
          },
      .jacobian =
          [](const Eigen::VectorXd& x) { return Eigen::MatrixXd::Identity(x.size(), x.size()); }};
  const LeastSquaresSolution found = least_squares(stairs, Eigen::VectorXd::Constant(1, 1.0));
  CHECK(found.converged);
  CHECK_NEAR(found.residuals[0], -0.04, 1e-15);
}

TEST("what a residual throws passes through") {
  const LeastSquaresProblem broken{
      .residuals = [calls = 0](const Eigen::VectorXd& x) mutable -> Eigen::VectorXd {
        if (++calls > 2) { throw std::runtime_error("no such place"); }
        return x;
      },
      .jacobian =
          [](const Eigen::VectorXd& x) { return Eigen::MatrixXd::Identity(x.size(), x.size()); }};
  CHECK_THROWS(least_squares(broken, Eigen::Vector2d(1.0, 1.0)), "no such place");
}

TEST("a search that is cut short says so, and fewer residuals than parameters are refused") {
  const LeastSquaresProblem curve{
      .residuals =
          [](const Eigen::VectorXd& x) {
            return Eigen::VectorXd(Eigen::VectorXd::Constant(1, std::exp(x[0]) - 5.0));
          },
      .jacobian =
          [](const Eigen::VectorXd& x) {
            return Eigen::MatrixXd(Eigen::MatrixXd::Constant(1, 1, std::exp(x[0])));
          }};
  CHECK(
      !least_squares(curve, Eigen::VectorXd::Constant(1, -8.0), {.most_iterations = 1}).converged);
  CHECK_THROWS(least_squares(curve, Eigen::Vector2d(0.0, 0.0)), "fewer residuals");
}

}  // namespace PALPATE_FILE
