// SPDX-License-Identifier: MIT

#include "validation/certificate/tail.hpp"

#include <functional>

#include "device/seeded.hpp"
#include "tests/check.hpp"

namespace {

using namespace palpate::certificate;
using namespace palpate;
using palpate::device::Seeded;

double exponential(Seeded& random) { return -std::log(1.0 - random.uniform(0.0, 1.0)); }

std::vector<double> pareto_sample(double shape, double scale, int count, std::uint64_t seed) {
  Seeded random(seed);
  std::vector<double> sample;
  for (int n = 0; n < count; ++n) {
    const double e = exponential(random);
    sample.push_back(scale * (shape == 0.0 ? e : std::expm1(shape * e) / shape));
  }
  return sample;
}

TEST("fitted shape and scale are within their standard errors of the true ones") {
  for (const double shape : {-0.2, 0.0, 0.3, 1.0}) {
    const ParetoFit fit = fit_pareto(pareto_sample(shape, 20e-6, 5000, 1));
    // Smith 1985: (1 + xi)^2 / n and 2 sigma^2 (1 + xi) / n; four standard errors.
    CHECK_NEAR(fit.shape, shape, 4.0 * fit.shape_error());
    CHECK_NEAR(fit.scale, 20e-6, 4.0 * 20e-6 * std::sqrt(2.0 * (1.0 + shape) / 5000.0));
  }
}

TEST("the fit is a maximum of the likelihood: its two equations hold") {
  // d/d sigma and d/d xi of n log sigma + (1 + 1/xi) sum log(1 + xi y / sigma) are zero.
  const std::vector<double> sample = pareto_sample(0.3, 1.0, 400, 2);
  const ParetoFit fit = fit_pareto(sample);
  double logs = 0.0, shares = 0.0;
  for (const double y : sample) {
    logs += std::log1p(fit.shape * y / fit.scale);
    shares += y / (fit.scale + fit.shape * y);
  }
  CHECK_NEAR(logs / 400.0, fit.shape, 1e-6);  // Grimshaw 1993
  // A flat maximum: half the digits of a double.
  CHECK_NEAR((1.0 + fit.shape) * shares / 400.0, 1.0, 1e-3);
}

TEST("the excess at q is exceeded with probability q, and the end of a bounded tail never") {
  for (const double shape : {-0.3, 0.0, 0.5}) {
    const ParetoFit fit{.shape = shape, .scale = 3.0, .count = 10};
    for (const double q : {0.5, 1e-3, 1e-8}) {
      CHECK_NEAR(fit.exceeded(fit.excess_at(q)) / q, 1.0, 1e-7);
    }
  }
  const ParetoFit bounded{.shape = -0.5, .scale = 1.0};  // ends at 2
  CHECK_NEAR(bounded.exceeded(2.5), 0.0, 0.0);
}

TEST("the interval holds the estimate, grows with confidence, and is wider above than below") {
  const std::vector<double> sample = pareto_sample(0.0, 1.0, 200, 3);
  const ParetoFit fit = fit_pareto(sample);
  const double value = fit.excess_at(1e-4);
  const ExcessInterval narrow = excess_interval(fit, sample, 1e-4, 0.5);
  const ExcessInterval wide = excess_interval(fit, sample, 1e-4, 0.95);
  CHECK(wide.lower < narrow.lower);
  CHECK(narrow.lower < value);
  CHECK(value < narrow.upper);
  CHECK(narrow.upper < wide.upper);
  CHECK(wide.upper - value > value - wide.lower);
}

std::vector<LargeTick> largest_of(long ticks, const std::function<double(long)>& time) {
  LargestTicks largest(kept_responses);
  for (long n = 0; n < ticks; ++n) { largest.add({time(n), n}); }
  return largest.sorted();
}

TEST("a tail of independent times is extrapolated one and two decades and no further") {
  Seeded random(5);
  constexpr long ticks = 20000;
  const std::vector<LargeTick> largest =
      largest_of(ticks, [&](long) { return 20e-6 * exponential(random); });
  const Tail tail = judge_tail(largest, ticks, 1e-3);
  CHECK(tail.refusal.empty());
  REQUIRE(tail.levels.size() == 2);
  CHECK(tail.fits.size() == 3);
  CHECK_NEAR(tail.levels.back().probability, 1e-2 / ticks, 1e-20);
  const double truth = 20e-6 * std::log(100.0 * ticks);
  CHECK(tail.levels.back().lower < truth);
  CHECK(truth < tail.levels.back().upper);
  CHECK(!tail.beyond_deadline);  // exp(-50): far beyond two decades
  // A deadline that one tick in 20 000 exceeds has its probability.
  const Tail near = judge_tail(largest, ticks, 20e-6 * std::log(ticks));
  REQUIRE(near.beyond_deadline.has_value());
  CHECK_NEAR(std::log(*near.beyond_deadline * ticks), 0.0, 1.5);
}

TEST("times that are correlated, change, are few or equal have no tail, and a reason") {
  Seeded random(7);
  double before = 0.0;
  const auto in_pairs = [&](long) {
    const double now = exponential(random);
    return std::max(std::exchange(before, now), now);
  };
  const Tail paired = judge_tail(largest_of(8000, in_pairs), 8000, 1e-3);
  CHECK_CONTAINS(paired.refusal, "late ticks do not follow each other");
  CHECK(!std::ranges::find(paired.checks, "alone-in-time", &Quantity::name)->holds());
  CHECK(paired.levels.empty());
  random = Seeded(9);
  const auto growing = [&](long n) {
    return exponential(random) * (1.0 + static_cast<double>(n) / 8000.0);
  };
  CHECK_CONTAINS(judge_tail(largest_of(8000, growing), 8000, 1e-3).refusal, "both halves");
  const auto rising = [](long n) { return 1e-6 * static_cast<double>(n); };
  CHECK_CONTAINS(judge_tail(largest_of(1000, rising), 1000, 1e-3).refusal, "too few");
  const auto equal = [](long) { return 1e-4; };
  CHECK_CONTAINS(judge_tail(largest_of(5000, equal), 5000, 1e-3).refusal, "all alike");
}

TEST("the extremal index of maxima over m neighbours is 1/m") {
  for (const int m : {1, 2, 4}) {
    Seeded random(8);
    std::vector<double> recent(static_cast<std::size_t>(m), 0.0);
    const auto largest = largest_of(50000, [&](long n) {
      recent[static_cast<std::size_t>(n % m)] = exponential(random);
      return *std::ranges::max_element(recent);
    });
    // About 2500/m clusters: 1/sqrt(n) of the index, four times
    CHECK_NEAR(extremal_index(exceedances(largest, 2500, 50000)), 1.0 / m,
               4.0 / m / std::sqrt(2500.0 / m));
  }
}

}  // namespace
