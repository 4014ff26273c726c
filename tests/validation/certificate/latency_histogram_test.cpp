// SPDX-License-Identifier: MIT
#include "validation/certificate/latency_histogram.hpp"

#include <cmath>
#include <limits>

#include "tests/check.hpp"

namespace {

using palpate::certificate::LatencyHistogram;

TEST("a percentile is the end of the bin of its ordered sample") {
  LatencyHistogram histogram;
  for (int n = 1; n <= 1000; ++n) { histogram.add(1e-6 * (n - 0.5)); }  // one in every bin from 0 to 999
  CHECK_NEAR(*histogram.percentile(0.5), 500e-6, 1e-15);  // of 1000 ordered ones number 500, in [499, 500) us
  CHECK_NEAR(*histogram.percentile(0.99), 990e-6, 1e-15);
  CHECK_NEAR(*histogram.percentile(0.999), 999e-6, 1e-15);
  CHECK_NEAR(histogram.minimum(), 0.5e-6, 1e-20);
  CHECK_NEAR(histogram.maximum(), 999.5e-6, 1e-18);
  CHECK(histogram.used_bins() == 1000);
}

TEST("a percentile that no sample lies above is not invented") {
  LatencyHistogram histogram;
  for (int n = 0; n < 1000; ++n) { histogram.add(1e-4); }
  CHECK(histogram.percentile(0.999).has_value());
  CHECK(!histogram.percentile(0.9999).has_value());
  CHECK(!LatencyHistogram().percentile(0.5).has_value());
}

TEST("a percentile is never beyond the maximum") {
  LatencyHistogram histogram;
  for (int n = 0; n < 10; ++n) { histogram.add(100.2e-6); }
  CHECK_NEAR(*histogram.percentile(0.5), 100.2e-6, 1e-15);
}

TEST("what is beyond all bins is counted in the last one, and its percentile is the maximum") {
  LatencyHistogram histogram;
  for (int n = 0; n < 10; ++n) { histogram.add(0.2 + 0.1 * n); }
  CHECK(histogram.counts().back() == 10);
  CHECK_NEAR(*histogram.percentile(0.5), 1.1, 1e-12);
}

TEST("no number is lost among the short ones") {
  LatencyHistogram histogram;
  histogram.add(std::numeric_limits<double>::quiet_NaN());
  histogram.add(-1e-9);  // a clock that is read twice
  CHECK(histogram.counts().back() == 1 && histogram.counts().front() == 1 && histogram.count() == 2);
}

}  // namespace
