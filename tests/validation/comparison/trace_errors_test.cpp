// SPDX-License-Identifier: MIT
#include "validation/comparison/trace_errors.hpp"

#include <limits>
#include <vector>

#include "tests/check.hpp"

namespace {

using namespace palpate::comparison;
const double gap = std::numeric_limits<double>::quiet_NaN();

TEST("a factor is all magnitude and no phase") {
  const std::vector<double> recorded{1.0, -3.0, 2.0, 5.0};
  std::vector<double> simulated;
  for (const double r : recorded) { simulated.push_back(0.5 * r); }
  const TraceErrors errors = trace_errors(simulated, recorded);
  CHECK_NEAR(errors.magnitude, -0.5, 1e-15);
  CHECK_NEAR(errors.phase, 0.0, 1e-7);  // arc cosine of 1 to rounding: sqrt(2 eps) / pi
  CHECK_NEAR(errors.combined, 0.5, 1e-12);
}

TEST("a quarter period of a sine is half the way to opposite") {
  std::vector<double> sine;
  std::vector<double> cosine;
  for (int n = 0; n < 400; ++n) {
    sine.push_back(std::sin(2.0 * M_PI * n / 100.0));
    cosine.push_back(std::cos(2.0 * M_PI * n / 100.0));
  }
  CHECK_NEAR(trace_errors(sine, cosine).phase, 0.5, 1e-14);
  CHECK_NEAR(trace_errors(sine, cosine).magnitude, 0.0, 1e-14);
}

TEST("gaps in either trace are left out") {
  const std::vector<double> simulated{gap, 2.0, 3.0, 9.0};
  const std::vector<double> recorded{1.0, 1.0, 2.0, gap};
  const TraceErrors errors = trace_errors(simulated, recorded);
  CHECK(errors.samples == 2);
  CHECK_NEAR(errors.rmse, 1.0, 1e-15);
  CHECK_NEAR(errors.mean, 1.0, 1e-15);
  CHECK_NEAR(errors.nrmse, 1.0, 1e-15);
}

TEST("what is not defined is no number") {
  const std::vector<double> none{gap, gap};
  CHECK(std::isnan(trace_errors(none, none).rmse));
  const std::vector<double> zero{0.0, 0.0};
  const TraceErrors of_zero = trace_errors(std::vector<double>{1.0, 2.0}, zero);
  CHECK(std::isnan(of_zero.nrmse) && std::isnan(of_zero.magnitude) && std::isnan(of_zero.phase));
}

}  // namespace
