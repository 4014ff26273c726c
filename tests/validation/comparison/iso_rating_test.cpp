// SPDX-License-Identifier: MIT

#include "validation/comparison/iso_rating.hpp"

#include <limits>
#include <numeric>

#include "device/seeded.hpp"
#include "tests/check.hpp"
#include "validation/signal.hpp"

namespace PALPATE_FILE {

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
  for (const double part : {rating.corridor, rating.phase, rating.magnitude, rating.slope}) {
    CHECK(part == 1.0);
  }
  CHECK(rating.shift == 0);
}

TEST("a late shift is positive, an early one negative, and both score the same up to a fifth") {
  const IsoRating late = rate(bump(150.0), bump(135.0));
  const IsoRating early = rate(bump(120.0), bump(135.0));
  CHECK(late.shift == 15);
  CHECK(early.shift == -15);
  CHECK_NEAR(late.phase, 1.0 - 15.0 / 60.0, 1e-12);
  CHECK_NEAR(early.phase, late.phase, 1e-12);
  CHECK_NEAR(late.magnitude, 1.0, 1e-6);
  CHECK(rate(bump(200.0), bump(140.0)).phase == 0.0);
}

TEST("slopes are means over nine differences") {
  std::vector<double> ramp(200);
  std::iota(ramp.begin(), ramp.end(), 0.0);
  std::vector<double> spiked = ramp;
  spiked[100] += 18.0;
  // Differences of +9 and -9 at 99 and 101 meet in every window of nine but the two at either edge:
  // 4 x 1.
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

TEST("a constant, also with rounding on it, has no phase, and a note says so") {
  const std::vector<double> constant(300, 2.5);
  std::vector<double> rounded = constant;
  for (std::size_t n = 0; n < 300; n += 2) { rounded[n] = std::nextafter(2.5, 3.0); }
  for (const IsoRating& rating : {rate(constant, bump(100.0)), rate(bump(100.0), constant),
                                  rate(constant, constant), rate(rounded, bump(100.0))}) {
    CHECK(rating.phase == 0.0);
    CHECK(!rating.note.empty());
  }
}

TEST("zeros compared with zeros are equal and leave no scale to divide by") {
  const std::vector<double> zero(50, 0.0);
  const IsoRating same = rate(zero, zero);
  for (const double part : {same.corridor, same.magnitude, same.slope}) { CHECK(part == 1.0); }
  const IsoRating off = rate(std::vector<double>(50, 1.0), zero);
  CHECK(off.corridor == 0.0);
  CHECK(off.magnitude == 0.0);
}

TEST("traces that are not finite, of different lengths or too short are not rated") {
  std::vector<double> broken = bump(100.0);
  broken[7] = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS(rate(broken, bump(100.0)), "all of them numbers");
  CHECK_THROWS(rate(bump(100.0), bump(100.0, 299)), "one length");
  CHECK_THROWS(rate(bump(3.0, 9), bump(3.0, 9)), "at least 10");
}

TEST("grades begin above their limits") {
  for (const auto& [score, grade] : {std::pair{0.95, "excellent"},
                                     {0.94, "good"},
                                     {0.80, "fair"},
                                     {0.58, "poor"},
                                     {NAN, "poor"}}) {
    CHECK(grade_of(score) == grade);
  }
}

/// Minimum sum of squares over all paths within the band, by exhaustive search.
double least_square(const std::vector<double>& a, const std::vector<double>& b, long i, long j,
                    long radius) {
  if (i < 0 || j < 0 || std::abs(i - j) >= radius) {
    return std::numeric_limits<double>::infinity();
  }
  const double d = a[static_cast<std::size_t>(i)] - b[static_cast<std::size_t>(j)];
  if (i == 0 && j == 0) { return d * d; }
  return d * d +
         std::min({least_square(a, b, i - 1, j, radius), least_square(a, b, i, j - 1, radius),
                   least_square(a, b, i - 1, j - 1, radius)});
}

TEST("the path is the best one of all within its band") {
  palpate::device::Seeded seeded(3);
  for (int trial = 0; trial < 40; ++trial) {
    std::vector<double> a, b;
    // Squared and absolute differences of the values 0 and 1 are equal, so the sums are comparable.
    for (int n = 0; n < 7; ++n) {
      a.push_back(seeded.uniform(0.0, 1.0) < 0.5 ? 0.0 : 1.0);
      b.push_back(seeded.uniform(0.0, 1.0) < 0.5 ? 0.0 : 1.0);
    }
    for (const std::size_t radius : {1UL, 2UL, 4UL, 7UL}) {
      CHECK_NEAR(warp(a, b, radius).difference, least_square(a, b, 6, 6, static_cast<long>(radius)),
                 0.0);
    }
  }
}

TEST("a delay within the band costs nothing, one beyond it does") {
  std::vector<double> early(60, 0.0), late(60, 0.0);
  early[20] = 1.0;
  late[25] = 1.0;
  CHECK(warp(late, early, 6).difference == 0.0);  // |i - j| = 5 < 6
  CHECK(warp(late, early, 5).difference == 2.0);  // both pulses are compared with zero
  // A band of one sample compares instant by instant, and equal traces do not differ.
  const std::vector<double> a{1.0, 5.0, 2.0};
  const WarpSums sums = warp(a, std::vector<double>{1.0, 2.0, 4.0}, 1);
  CHECK_NEAR(sums.difference, 5.0, 0.0);
  CHECK_NEAR(sums.second, 7.0, 0.0);
  CHECK(sums.length == 3);
  const std::vector<double> trace{0.0, 2.0, -1.0, 4.0, 4.0};
  CHECK(warp(trace, trace, 3).difference == 0.0);
  CHECK(warp(trace, trace, 3).length >= trace.size());
}

const double gap = std::numeric_limits<double>::quiet_NaN();

TEST("gaps in either trace are left out, and undefined measures are NaN") {
  const TraceErrors errors = trace_errors(std::vector<double>{gap, 2.0, 3.0, 9.0},
                                          std::vector<double>{1.0, 1.0, 2.0, gap});
  CHECK(errors.samples == 2);
  CHECK_NEAR(errors.rmse, 1.0, 1e-15);
  CHECK_NEAR(errors.mean, 1.0, 1e-15);
  CHECK_NEAR(errors.nrmse, 1.0, 1e-15);
  const std::vector<double> none{gap, gap};
  CHECK(std::isnan(trace_errors(none, none).rmse));
  const TraceErrors of_zero =
      trace_errors(std::vector<double>{1.0, 2.0}, std::vector<double>{0.0, 0.0});
  CHECK(std::isnan(of_zero.nrmse));
  CHECK(std::isnan(of_zero.magnitude));
  CHECK(std::isnan(of_zero.phase));
}

}  // namespace PALPATE_FILE
