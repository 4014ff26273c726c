// SPDX-License-Identifier: MIT
#include "validation/gate/quantity_change.hpp"

#include <cmath>
#include <limits>

#include "tests/check.hpp"

namespace {

using namespace palpate;
using namespace palpate::gate;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Quantity error_of(double value) {
  return {.name = "error", .value = value, .upper = 1e-3, .bound_from = "theory"};
}

Judgement judged(Quantity before, Quantity now, double spread = 0.0) {
  return judge_quantity(before, now, spread).judgement;
}

TEST("the same bits need no allowance") { CHECK(judged(error_of(1e-6), error_of(1e-6)) == Judgement::same); }

TEST("an error may lose a tenth of a digit and no more") {
  CHECK(judged(error_of(1e-6), error_of(1e-6 * std::pow(10.0, 0.099))) == Judgement::within);
  CHECK(judged(error_of(1e-6), error_of(1e-6 * std::pow(10.0, 0.101))) == Judgement::worse);
  CHECK(judged(error_of(1e-6), error_of(1e-6 / 2.0)) == Judgement::better);
}

TEST("an error that was nothing and is something is worse") {
  CHECK(judged(error_of(0.0), error_of(1e-15)) == Judgement::worse);
  CHECK(judged(error_of(1e-15), error_of(0.0)) == Judgement::better);
}

TEST("rounding is what it was measured to be, tenfold") {
  CHECK(judged(error_of(0.0), error_of(9e-16), 1e-16) == Judgement::rounding);
  CHECK(judged(error_of(0.0), error_of(2e-15), 1e-16) == Judgement::worse);
}

TEST("what is no number passes nowhere") {
  for (const double value : {nan, unbounded, -unbounded}) {
    CHECK(judged(error_of(1e-6), error_of(value), 1.0) == Judgement::broken);
  }
  CHECK(judged(error_of(nan), error_of(nan)) == Judgement::broken);
}

TEST("a value that should be large may not shrink") {
  Quantity before{.name = "digits agreed", .value = 10.0, .lower = 9.0, .bound_from = "theory"};
  Quantity now = before;
  now.value = 9.5;
  CHECK(judged(before, now) == Judgement::within);
  now.value = 20.0;
  CHECK(judged(before, now) == Judgement::better);
  before.value = 20.0;
  now.value = 12.0;
  CHECK(judged(before, now) == Judgement::worse);
}

TEST("between two bounds the middle is the truth, and a hundredth of the way is nothing") {
  Quantity before{.name = "order", .value = 2.0001, .lower = 1.85, .upper = 2.15, .bound_from = "theory"};
  Quantity now = before;
  now.value = 2.001;  // ten times as far, and still nothing
  CHECK(judged(before, now) == Judgement::within);
  now.value = 2.05;
  CHECK(judged(before, now) == Judgement::worse);
  now.value = 1.9999;
  CHECK(judged(before, now) == Judgement::within);
}

TEST("a number that no bound judges may move by one per cent either way") {
  const Quantity before{.name = "energy", .value = 2.0, .unit = "J"};
  Quantity now = before;
  now.value = 2.019;
  CHECK(judged(before, now) == Judgement::within);
  for (const double value : {2.021, 1.979, -2.0}) {
    now.value = value;
    CHECK(judged(before, now) == Judgement::moved);
  }
}

TEST("more work is worse, less is better, and digits are digits") {
  const Quantity work{.name = "tick", .value = 1e6, .unit = "instructions"};
  Quantity now = work;
  now.value = 1.0099e6;
  CHECK(judged(work, now) == Judgement::within);
  now.value = 1.0101e6;
  CHECK(judged(work, now) == Judgement::worse);
  now.value = 0.98e6;
  CHECK(judged(work, now) == Judgement::better);
  const Quantity digits{.name = "digits", .value = 3.0, .unit = "digits"};
  now = digits;
  now.value = 2.85;
  CHECK(judged(digits, now) == Judgement::worse);
  now.value = 2.95;
  CHECK(judged(digits, now) == Judgement::within);
}

TEST("another unit or another bound is another claim") {
  Quantity now = error_of(1e-6);
  now.unit = "mm";
  CHECK(judged(error_of(1e-6), now) == Judgement::broken);
  now = error_of(1e-6);
  now.upper = 2e-3;
  CHECK(judged(error_of(1e-6), now) == Judgement::broken);
}

TEST("a number that fell out of its bound is broken, whatever the allowance") {
  CHECK(judged(error_of(0.99e-3), error_of(1.01e-3)) == Judgement::broken);
}

}  // namespace
