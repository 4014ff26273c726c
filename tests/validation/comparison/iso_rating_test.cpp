// SPDX-License-Identifier: MIT

#include "validation/comparison/iso_rating.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "device/seeded.hpp"
#include "tests/check.hpp"
#include "validation/signal.hpp"

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
  CHECK(rating.corridor == 1.0);
  CHECK(rating.phase == 1.0);
  CHECK(rating.magnitude == 1.0);
  CHECK(rating.slope == 1.0);
  CHECK(rating.shift == 0);
}

TEST("late is positive, early is negative, and both cost the same") {
  const IsoRating late = rate(bump(150.0), bump(135.0));
  const IsoRating early = rate(bump(120.0), bump(135.0));
  CHECK(late.shift == 15);
  CHECK(early.shift == -15);
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
  CHECK(rating.corridor == 1.0);
  CHECK(rating.magnitude == 1.0);
  CHECK(rating.slope == 1.0);
  const std::vector<double> one(50, 1.0);
  const IsoRating off = rate(one, zero);
  CHECK(off.corridor == 0.0);
  CHECK(off.magnitude == 0.0);
}

TEST("what cannot be rated is refused") {
  std::vector<double> broken = bump(100.0);
  broken[7] = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS(rate(broken, bump(100.0)), "all of them numbers");
  CHECK_THROWS(rate(bump(100.0), bump(100.0, 299)), "one length");
  CHECK_THROWS(rate(bump(3.0, 9), bump(3.0, 9)), "at least 10");
}

TEST("grades begin above their limits") {
  CHECK(grade_of(0.95) == "excellent");
  CHECK(grade_of(0.94) == "good");
  CHECK(grade_of(0.80) == "fair");
  CHECK(grade_of(0.58) == "poor");
  CHECK(grade_of(std::nan("")) == "poor");
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

TEST("equal traces answer each other sample by sample") {
  const std::vector<double> trace{0.0, 2.0, -1.0, 4.0, 4.0};
  const WarpSums sums = warp(trace, trace, 3);
  CHECK(sums.difference == 0.0);
  CHECK(sums.length >= trace.size());
}

TEST("the path is the best one of all within its band") {
  palpate::device::Seeded seeded(3);
  for (int trial = 0; trial < 40; ++trial) {
    std::vector<double> a;
    std::vector<double> b;
    // Values 0 or 1: squared and absolute differences are the same number, so the sums can be
    // compared.
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
  std::vector<double> early(60, 0.0);
  std::vector<double> late(60, 0.0);
  early[20] = 1.0;
  late[25] = 1.0;
  CHECK(warp(late, early, 6).difference == 0.0);  // |i - j| = 5 < 6
  CHECK(warp(late, early, 5).difference == 2.0);  // the pulses cannot meet: both stand alone
}

TEST("a band of one sample compares instant by instant") {
  const std::vector<double> a{1.0, 5.0, 2.0};
  const std::vector<double> b{1.0, 2.0, 4.0};
  const WarpSums sums = warp(a, b, 1);
  CHECK_NEAR(sums.difference, 5.0, 0.0);
  CHECK_NEAR(sums.second, 7.0, 0.0);
  CHECK(sums.length == 3);
}

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
  CHECK(std::isnan(of_zero.nrmse));
  CHECK(std::isnan(of_zero.magnitude));
  CHECK(std::isnan(of_zero.phase));
}

}  // namespace
