// SPDX-License-Identifier: MIT
#include "device/seeded.hpp"

#include <cmath>

#include "tests/check.hpp"

namespace {

using palpate::device::Seeded;

TEST("normal numbers have mean 0, variance 1 and the tails of twelve uniform ones") {
  constexpr double count = 100000;
  Seeded seeded(1);
  double sum = 0.0, squares = 0.0, fourths = 0.0, largest = 0.0;
  for (int n = 0; n < int(count); ++n) {
    const double x = seeded.normal();
    sum += x;
    squares += x * x;
    fourths += x * x * x * x;
    largest = std::fmax(largest, std::abs(x));
  }
  // Four standard errors: 1 of the mean, sqrt(1.9) of the square, below sqrt(96) of the fourth power.
  const double error = 4.0 / std::sqrt(count);
  CHECK_NEAR(sum / count, 0.0, error);
  CHECK_NEAR(squares / count, 1.0, std::sqrt(1.9) * error);
  CHECK_NEAR(fourths / count, 2.9, std::sqrt(96.0) * error);  // 3 less 1.2 / 12 (Irwin-Hall)
  CHECK(largest < 6.0 && largest > 3.0);
}

TEST("a seed gives the same numbers, another one others") {
  Seeded one(7), same(7), other(8);
  const double first = one.uniform(-2.0, 3.0);
  CHECK(first == same.uniform(-2.0, 3.0) && first != other.uniform(-2.0, 3.0));
  CHECK(first >= -2.0 && first < 3.0);
}

}  // namespace
