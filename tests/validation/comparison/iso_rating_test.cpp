// SPDX-License-Identifier: MIT
#include "validation/comparison/iso_rating.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "tests/check.hpp"

namespace {

using namespace palpate::comparison;

std::vector<double> bump(double centre, std::size_t count = 300) {
  std::vector<double> trace(count);
  for (std::size_t n = 0; n < count; ++n) {
    trace[n] = 5.0 * std::exp(-std::pow((static_cast<double>(n) - centre) / 20.0, 2));
  }
  return trace;
}

TEST("a trace against itself is rated 1 in every part") {
  const IsoRating rating = rate(bump(120.0), bump(120.0));
  CHECK_NEAR(rating.overall, 1.0, 1e-12);
  CHECK(rating.corridor == 1.0 && rating.phase == 1.0 && rating.magnitude == 1.0 && rating.slope == 1.0);
  CHECK(rating.shift == 0);
}

TEST("late is positive, early is negative, and both cost the same") {
  const IsoRating late = rate(bump(150.0), bump(135.0));
  const IsoRating early = rate(bump(120.0), bump(135.0));
  CHECK(late.shift == 15 && early.shift == -15);
  CHECK_NEAR(late.phase, 1.0 - 15.0 / 60.0, 1e-12);
  CHECK_NEAR(early.phase, late.phase, 1e-12);
  CHECK_NEAR(late.magnitude, 1.0, 1e-6);
}

TEST("a shift of a fifth of the samples or more has no phase score") {
  CHECK(rate(bump(200.0), bump(140.0)).phase == 0.0);
}

TEST("slopes are means over nine differences") {
  std::vector<double> ramp(200);
  for (std::size_t n = 0; n < 200; ++n) { ramp[n] = static_cast<double>(n); }
  std::vector<double> spiked = ramp;
  spiked[100] += 18.0;
  // Differences of +9 and -9 at 99 and 101 meet in every window of nine but the two at either edge: 4 x 1.
  CHECK_NEAR(rate(spiked, ramp).slope, 1.0 - 4.0 / 200.0 / 2.0, 1e-12);
}

TEST("units cancel: Pa, mmHg and a mirrored sign rate the same") {
  std::vector<double> simulated = bump(140.0);
  std::vector<double> recorded = bump(130.0);
  for (double& v : simulated) { v *= 0.8; }
  const IsoRating one = rate(simulated, recorded);
  for (double& v : simulated) { v *= -133.322; }
  for (double& v : recorded) { v *= -133.322; }
  const IsoRating other = rate(simulated, recorded);
  CHECK_NEAR(one.overall, other.overall, 1e-9);
  CHECK(one.shift == other.shift);
}

TEST("a constant has no phase: 0 and a note, whichever of the two it is") {
  const std::vector<double> constant(300, 2.5);
  for (const IsoRating& rating :
       {rate(constant, bump(100.0)), rate(bump(100.0), constant), rate(constant, constant)}) {
    CHECK(rating.phase == 0.0);
    CHECK(!rating.note.empty());
  }
}

TEST("a constant with rounding on it is a constant") {
  std::vector<double> constant(300, 2.5);
  for (std::size_t n = 0; n < 300; n += 2) { constant[n] = std::nextafter(2.5, 3.0); }
  CHECK(rate(constant, bump(100.0)).phase == 0.0);
}

TEST("zeros against zeros are the same and leave no scale to divide by") {
  const std::vector<double> zero(50, 0.0);
  const IsoRating rating = rate(zero, zero);
  CHECK(rating.corridor == 1.0 && rating.magnitude == 1.0 && rating.slope == 1.0);
  const std::vector<double> one(50, 1.0);
  const IsoRating off = rate(one, zero);
  CHECK(off.corridor == 0.0 && off.magnitude == 0.0);
}

TEST("what cannot be rated is refused") {
  std::vector<double> broken = bump(100.0);
  broken[7] = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS(rate(broken, bump(100.0)), "all of them numbers");
  CHECK_THROWS(rate(bump(100.0), bump(100.0, 299)), "one length");
  CHECK_THROWS(rate(bump(3.0, 9), bump(3.0, 9)), "at least 10");
}

TEST("grades begin above their limits") {
  CHECK(grade_of(0.95) == "excellent" && grade_of(0.94) == "good" && grade_of(0.80) == "fair");
  CHECK(grade_of(0.58) == "poor" && grade_of(std::nan("")) == "poor");
}

}  // namespace
