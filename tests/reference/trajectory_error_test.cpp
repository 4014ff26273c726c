// SPDX-License-Identifier: MIT
#include "reference/trajectory_error.hpp"

#include <limits>

#include "tests/check.hpp"

using Eigen::MatrixXd;
using namespace palpate::reference;

namespace {
MatrixXd ramp() {  // two coordinates, three instants; moves by at most 4
  MatrixXd q(2, 3);
  q << 1.0, 2.0, 5.0, -1.0, -1.0, -2.0;
  return q;
}
}  // namespace

TEST("the peak is measured from the first instant, not from the origin") {
  CHECK(peak_displacement(ramp()) == 4.0);
  CHECK(peak_speed(ramp()) == 5.0);
}

TEST("the error is the worst coordinate at the worst instant over the scale") {
  MatrixXd candidate = ramp();
  candidate(1, 1) += 0.4;
  candidate(0, 2) -= 0.2;
  CHECK_NEAR(trajectory_error(candidate, ramp(), 4.0), 0.1, 1e-15);
  CHECK_NEAR(instant_errors(candidate, ramp(), 4.0)[2], 0.05, 1e-15);
}

TEST("a NaN or an infinity anywhere makes the error infinite") {
  for (const double poison : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    for (Eigen::Index i = 0; i < 2; ++i) {
      MatrixXd candidate = ramp();
      candidate(i, 1) = poison;
      CHECK(std::isinf(trajectory_error(candidate, ramp(), 4.0)));
      CHECK(std::isinf(trajectory_error(ramp(), candidate, peak_displacement(candidate))));
      CHECK(digits(trajectory_error(candidate, ramp(), 4.0)) == 0.0);
    }
    MatrixXd candidate = ramp();
    candidate(0, 2) = poison;
    CHECK(mixed_error_digits(candidate, ramp(), 1.0) == 0.0);
  }
}

TEST("where nothing moves equal is zero and different is infinite") {
  const MatrixXd still = MatrixXd::Ones(2, 3);
  MatrixXd moved = still;
  moved(0, 1) = 1.5;
  CHECK(trajectory_error(still, still, peak_displacement(still)) == 0.0);
  CHECK(std::isinf(trajectory_error(moved, still, peak_displacement(still))));
}

TEST("trajectories of different size are refused") {
  CHECK_THROWS(trajectory_error(MatrixXd::Zero(2, 2), ramp(), 1.0), "different size");
  CHECK_THROWS(trajectory_error(MatrixXd(), MatrixXd(), 1.0), "different size");
}

TEST("digits are the negative logarithm, between 0 and 17") {
  CHECK_NEAR(digits(1e-9), 9.0, 1e-12);
  CHECK(digits(0.0) == 17.0);
  CHECK(digits(3.0) == 0.0);
  CHECK(digits(std::nan("")) == 0.0);
}

TEST("mixed-error digits weigh each coordinate by its own motion") {
  MatrixXd candidate = ramp();
  candidate(1, 2) += 2e-3;  // that coordinate has moved by 1; the scale adds 1
  CHECK_NEAR(mixed_error_digits(candidate, ramp(), 1.0), 3.0, 1e-10);
}
