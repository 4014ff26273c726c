// SPDX-License-Identifier: MIT
#include "validation/calibration/posterior.hpp"

#include "tests/check.hpp"

using namespace palpate::calibration;

namespace {

TEST("one row and one parameter leave 1 / (1 + s^2) of the prior variance") {
  const Linearised at{.slope = Eigen::MatrixXd::Constant(1, 1, 6.0),
                      .considered = Eigen::MatrixXd(1, 0),
                      .covariance = Eigen::MatrixXd::Constant(1, 1, 4.0)};  // s = 6 / 2
  CHECK_NEAR(posterior_covariance(at)(0, 0), 0.1, 1e-15);
}

TEST("a parameter that was left adds its own uncertainty") {
  const Linearised at{.slope = Eigen::MatrixXd::Constant(1, 1, 6.0),
                      .considered = Eigen::MatrixXd::Constant(1, 1, 2.0),
                      .covariance = Eigen::MatrixXd::Constant(1, 1, 4.0)};
  // G = (1 / 10) 6 / 4, and G^2 2^2 more than before.
  CHECK_NEAR(posterior_covariance(at)(0, 0), 0.1 + 0.0225 * 4.0, 1e-15);
}

TEST("rows that err together do not count as many") {
  Eigen::MatrixXd slope = Eigen::MatrixXd::Constant(4, 1, 3.0);
  const Linearised together{
      .slope = slope,
      .considered = Eigen::MatrixXd(4, 0),
      .covariance = Eigen::MatrixXd::Ones(4, 4) + 1e-12 * Eigen::MatrixXd::Identity(4, 4)};
  const Linearised apart{
      .slope = slope, .considered = Eigen::MatrixXd(4, 0), .covariance = Eigen::MatrixXd::Identity(4, 4)};
  CHECK_NEAR(posterior_covariance(apart)(0, 0), 1.0 / 37.0, 1e-14);  // H = 4 9 + 1
  CHECK_NEAR(posterior_covariance(together)(0, 0), (12.0 * 12.0 + 1.0) / (37.0 * 37.0),
             1e-10);  // the 1e-12 above
}

TEST("of two parameters that do the same one is left, and what nothing depends on is left") {
  Eigen::MatrixXd slope(2, 4);
  slope << 5.0, 5.0, 0.0, 0.0, 0.0, 0.0, 7.0, 0.1;
  const auto told = told_columns(slope, Eigen::MatrixXd::Identity(2, 2), {0, 1, 2, 3});
  CHECK(told == (std::vector<Eigen::Index>{2}));  // either of the two has the other's uncertainty
  slope(0, 1) = 1.0;
  CHECK(told_columns(slope, Eigen::MatrixXd::Identity(2, 2), {0, 1, 2, 3}) ==
        (std::vector<Eigen::Index>{0, 2}));
  CHECK(told_columns(slope, Eigen::MatrixXd::Identity(2, 2), {1, 2}) == (std::vector<Eigen::Index>{2}));
}

TEST("correlation has ones on its diagonal") {
  Eigen::MatrixXd covariance(2, 2);
  covariance << 4.0, -3.0, -3.0, 9.0;
  CHECK_NEAR(correlation_of(covariance)(0, 1), -0.5, 1e-15);
  CHECK_NEAR(correlation_of(covariance)(1, 1), 1.0, 1e-15);
}

}  // namespace
