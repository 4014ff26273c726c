// SPDX-License-Identifier: MIT

#include "model/stepping/anderson_iteration.hpp"

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>

#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using Vector = Eigen::VectorXd;
using Correction = std::function<Vector(const Vector&)>;

/// Iterates until the correction at x is below 1e-10; returns the number of corrections.
int iterations(AndersonIteration<double>& anderson, const Correction& correction, Vector& x) {
  anderson.start();
  for (int n = 1; n <= 100; ++n) {
    Vector c = correction(x);
    if (c.lpNorm<Eigen::Infinity>() < 1e-10) { return n; }
    (void)anderson.advance(x, c);
    x += c;
  }
  return std::numeric_limits<int>::max();
}

AndersonIteration<double> prepared(Eigen::Index unknowns) {
  AndersonIteration<double> anderson;
  anderson.prepare(unknowns);
  return anderson;
}

TEST("a linear system of n unknowns takes n + 1 steps, and the next with its matrix two") {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (const Eigen::Index n : {1, 3, 6}) {
    check::row = "n = " + std::to_string(n);
    // Without acceleration an eigenvalue above 2 diverges.
    Eigen::MatrixXd a = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return 0.2 * any(random); });
    a.diagonal() += Vector::LinSpaced(n, 0.5, 3.0);
    AndersonIteration<double> anderson = prepared(n);
    for (const int most : {static_cast<int>(n) + 2, 3}) {
      const Vector right = Vector::NullaryExpr(n, [&] { return any(random); });
      Vector x = Vector::Zero(n);
      CHECK(iterations(
                anderson, [&](const Vector& at) { return Vector(right - a * at); }, x) <= most);
      CHECK_NEAR((a * x - right).norm(), 0.0, 1e-9);
    }
  }
}

TEST("a step that enlarges the correction is taken back") {
  AndersonIteration<double> anderson = prepared(1);
  anderson.start();
  Vector x = Vector::Constant(1, 0.5);
  Vector step = Vector::Constant(1, 2.0);
  CHECK_NEAR(anderson.advance(x, step), 0.0, 0.0);
  x += step;
  step(0) = -9.0;
  CHECK_NEAR(anderson.advance(x, step), 1.0, 0.0);
  CHECK_NEAR(x(0), 0.5, 0.0);
  CHECK_NEAR(step(0), 2.0, 0.0);  // without pairs
  x += step;
  step(0) = -9.0;
  CHECK_NEAR(anderson.advance(x, step), 1.0, 0.0);
  CHECK_NEAR(x(0), 0.5, 0.0);
  CHECK(std::abs(step(0)) <= 0.5);  // a quarter of the step at most
}

TEST("equations whose full corrections diverge are solved, over and over") {
  // c(x) = s - atan(10 x) - x / 10: full corrections jump back and forth over the solution.
  AndersonIteration<double> anderson = prepared(1);
  Vector x = Vector::Zero(1);
  for (int n = 0; n < 50; ++n) {
    const double s = 2.0 * std::sin(0.3 * n);
    const auto correction = [&](const Vector& at) {
      return Vector::Constant(1, s - std::atan(10.0 * at(0)) - 0.1 * at(0)).eval();
    };
    check::row = "s = " + std::to_string(s);
    CHECK(iterations(anderson, correction, x) <= 25);
  }
}

TEST("a correction that is not finite leaves no pair behind") {
  AndersonIteration<double> anderson = prepared(2);
  anderson.start();
  Vector x = Vector::Zero(2);
  Vector c = Vector::Ones(2);
  (void)anderson.advance(x, c);
  c.setConstant(std::numeric_limits<double>::quiet_NaN());
  (void)anderson.advance(x, c);
  const auto correction = [](const Vector& at) { return Vector(Vector::Ones(2) - 2.0 * at); };
  x.setZero();
  CHECK(iterations(anderson, correction, x) <= 4);
  CHECK_NEAR(x(0), 0.5, 1e-9);
}

}  // namespace PALPATE_FILE
