// SPDX-License-Identifier: MIT
#include "validation/certificate/pareto_tail.hpp"

#include <cmath>
#include <vector>

#include "device/seeded.hpp"
#include "tests/check.hpp"

namespace {

using namespace palpate::certificate;
using palpate::device::Seeded;

std::vector<double> pareto_sample(double shape, double scale, int count, std::uint64_t seed) {
  Seeded random(seed);
  std::vector<double> sample;
  for (int n = 0; n < count; ++n) {
    const double e = -std::log(1.0 - random.uniform(0.0, 1.0));
    sample.push_back(scale * (shape == 0.0 ? e : std::expm1(shape * e) / shape));
  }
  return sample;
}

TEST("shape and scale come back within their standard errors") {
  for (const double shape : {-0.2, 0.0, 0.3, 1.0}) {
    const ParetoFit fit = fit_pareto(pareto_sample(shape, 20e-6, 5000, 1));
    // Smith 1985: (1 + xi)^2 / n and 2 sigma^2 (1 + xi) / n; four standard errors.
    CHECK_NEAR(fit.shape, shape, 4.0 * fit.shape_error());
    CHECK_NEAR(fit.scale, 20e-6, 4.0 * 20e-6 * std::sqrt(2.0 * (1.0 + shape) / 5000.0));
  }
}

TEST("the fit is a maximum of the likelihood: its two equations hold") {
  // d/d sigma and d/d xi of n log sigma + (1 + 1/xi) sum log(1 + xi y / sigma) vanish.
  const std::vector<double> sample = pareto_sample(0.3, 1.0, 400, 2);
  const ParetoFit fit = fit_pareto(sample);
  double logs = 0.0;
  double shares = 0.0;
  for (const double y : sample) {
    logs += std::log1p(fit.shape * y / fit.scale);
    shares += y / (fit.scale + fit.shape * y);
  }
  CHECK_NEAR(logs / 400.0, fit.shape, 1e-6);                  // Grimshaw 1993
  CHECK_NEAR((1.0 + fit.shape) * shares / 400.0, 1.0, 1e-3);  // a flat maximum: half the digits of a double
}

TEST("the excess at q is exceeded with probability q") {
  for (const double shape : {-0.3, 0.0, 0.5}) {
    const ParetoFit fit{.shape = shape, .scale = 3.0, .count = 10};
    for (const double q : {0.5, 1e-3, 1e-8}) { CHECK_NEAR(fit.exceeded(fit.excess_at(q)) / q, 1.0, 1e-7); }
  }
}

TEST("a bounded tail is exceeded beyond its end by nothing") {
  const ParetoFit fit{.shape = -0.5, .scale = 1.0};  // ends at 2
  CHECK_NEAR(fit.exceeded(2.5), 0.0, 0.0);
}

TEST("the interval holds the estimate, grows with confidence, and is wider above than below") {
  const std::vector<double> sample = pareto_sample(0.0, 1.0, 200, 3);
  const ParetoFit fit = fit_pareto(sample);
  const double value = fit.excess_at(1e-4);
  const ExcessInterval narrow = excess_interval(fit, sample, 1e-4, 0.5);
  const ExcessInterval wide = excess_interval(fit, sample, 1e-4, 0.95);
  CHECK(wide.lower < narrow.lower && narrow.lower < value && value < narrow.upper &&
        narrow.upper < wide.upper);
  CHECK(wide.upper - value > value - wide.lower);
}

}  // namespace
