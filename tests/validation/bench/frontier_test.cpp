// SPDX-License-Identifier: MIT
#include "validation/bench/frontier.hpp"

#include <cmath>

#include "tests/check.hpp"

namespace {

using namespace palpate::bench;

/// A scheme of an order: error = scale / cost^order.
void add_scheme(std::vector<Effort>& efforts, const char* name, double scale, double order) {
  for (double cost = 100.0; cost <= 6400.0; cost *= 2.0) {
    efforts.push_back({.method = name, .cost = cost, .error = scale / std::pow(cost, order)});
  }
}

TEST("cost at an error is the scheme's own law, between its points too") {
  std::vector<Effort> efforts;
  add_scheme(efforts, "second", 1e2, 2.0);
  CHECK_NEAR(cost_at(efforts, 1e-3) / std::sqrt(1e5), 1.0, 1e-12);  // on a straight line nothing is lost
  CHECK_NEAR(digits_at(efforts, 3000.0), 2.0 * std::log10(3000.0) - 2.0, 1e-12);
}

TEST("the better scheme counts: the simple one for a coarse error, the higher order for a fine one") {
  std::vector<Effort> efforts;
  add_scheme(efforts, "first", 10.0, 1.0);
  add_scheme(efforts, "fourth", 1e9, 4.0);
  CHECK_NEAR(cost_at(efforts, 0.05), 200.0, 1e-9);
  CHECK_NEAR(cost_at(efforts, 1e-5) / std::pow(1e14, 0.25), 1.0, 1e-12);
}

TEST("nobody is cheaper than what was measured") {
  std::vector<Effort> efforts;
  add_scheme(efforts, "second", 1e2, 2.0);
  CHECK_NEAR(cost_at(efforts, 0.5), 100.0, 1e-9);
  CHECK_NEAR(digits_at(efforts, 1e9), -std::log10(1e2 / (6400.0 * 6400.0)), 1e-12);
}

TEST("an error that nobody reaches and a cost that nobody offers are no number") {
  std::vector<Effort> efforts;
  add_scheme(efforts, "second", 1e2, 2.0);
  CHECK(std::isnan(cost_at(efforts, 1e-9)) && std::isnan(digits_at(efforts, 99.0)));
  CHECK(std::isnan(cost_at({}, 1e-3)) && std::isnan(digits_at({}, 1e3)));
}

TEST("a scheme that lost an order costs more at a fine error, and has fewer digits") {
  std::vector<Effort> good, damaged;
  add_scheme(good, "x", 1.0, 2.0);
  add_scheme(damaged, "x", 1.0 / 100.0, 1.0);  // as near at the first point
  CHECK(cost_at(damaged, 1e-5) > 1.5 * cost_at(good, 1e-5));
  CHECK(digits_at(damaged, 1600.0) < digits_at(good, 1600.0) - 1.0);
}

}  // namespace
