// SPDX-License-Identifier: MIT
#include "reports/margin.hpp"

#include <cmath>

#include "tests/check.hpp"

using namespace palpate;

TEST("the share of a bound is at most one exactly when the quantity holds") {
  const double values[] = {-9.0,        -1.0, -1e-300, 0.0,       1e-12,
                           0.5,         0.85, 0.95,    1.0,       std::nextafter(1.2, 2.0),
                           1.2,         1.3,  9.0,     unbounded, -unbounded,
                           std::nan("")};
  const double bounds[][2] = {
      {0.5, 1.2},       {-unbounded, 1e-8}, {-unbounded, -1.0},     {-unbounded, 0.0},
      {8.0, unbounded}, {-2.0, unbounded},  {0.0, unbounded},       {1.0, 1.0},
      {0.85, 1.15},     {-1e-300, 1.2},     {-unbounded, unbounded}};
  for (const double value : values) {
    for (const auto& [lower, upper] : bounds) {
      const Quantity q{.value = value, .lower = lower, .upper = upper, .bound_from = "theory"};
      CHECK((share_of_bound(q) <= 1.0) == q.holds());
    }
  }
}

TEST("a count that is met says nothing about how near another quantity is") {
  Outcome outcome;
  outcome.judge({.name = "cases found", .value = 9.0, .lower = 9.0});
  outcome.judge({.name = "error", .value = 0.3, .upper = 1.0});
  CHECK(tightest_quantity(outcome)->name == "error");
  outcome.judge({.name = "cases lost", .value = 1.0, .upper = 0.0});
  CHECK(tightest_quantity(outcome)->name == "cases lost");
  outcome.judge({.name = "nothing", .value = std::nan(""), .upper = 1.0});
  CHECK(tightest_quantity(outcome)->name == "nothing");
}

TEST("a value and a bound that differ never read the same") {
  const Quantity q{.value = 6.0205999131, .unit = "dB", .lower = 6.0205999128};
  CHECK(measured_text(q) != allowed_text(q).substr(4));
  CHECK(allowed_text(q).starts_with("≥ 6.02059991"));
  CHECK(allowed_text({.value = 1.0, .lower = 1.0, .upper = 1.0}) == "= 1");
}
