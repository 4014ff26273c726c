// SPDX-License-Identifier: MIT
/// The statistics of a real-time certificate: what they say of data whose law is known.
#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>
#include <gsl/gsl_randist.h>
#include <iterator>

#include "device/seeded.hpp"
#include "validation/cases/certificate_parts.hpp"
#include "validation/cases/groups.hpp"
#include "validation/certificate/latency_histogram.hpp"
#include "validation/certificate/miss_bound.hpp"

namespace palpate {

namespace certificate {

namespace {

/// At its own limit so few misses have the chance 1 - confidence, by another library than that of the limit.
double worst_error_at_limit() {
  double worst = 0.0;
  for (const long ticks : {10L, 1000L, 60000L, 86400000L}) {
    for (const long misses : {0L, 1L, 3L, 9L}) {
      if (misses >= ticks) { continue; }
      const double limit = miss_probability_upper(misses, ticks);
      const double chance =
          gsl_cdf_binomial_P(static_cast<unsigned>(misses), limit, static_cast<unsigned>(ticks));
      worst = std::max(worst, std::abs(chance - 0.05) / 0.05);
    }
  }
  return worst;
}

/// How often the limit lies above the truth, by the binomial law itself.
double least_coverage(long ticks) {
  std::vector<double> limit;
  for (long misses = 0; misses <= ticks; ++misses) { limit.push_back(miss_probability_upper(misses, ticks)); }
  double least = 1.0;
  for (int n = 1; n < 1000; ++n) {
    const double truth = 1e-3 * n;
    double covered = 0.0;
    for (long misses = 0; misses <= ticks; ++misses) {
      if (truth > limit[static_cast<std::size_t>(misses)]) { continue; }
      covered += gsl_ran_binomial_pdf(static_cast<unsigned>(misses), truth, static_cast<unsigned>(ticks));
    }
    least = std::min(least, covered);
  }
  return least;
}

void measure_miss_bound(const CaseContext&, Outcome& outcome) {
  outcome.judge(
      {.name = "error_of_the_chance_at_the_limit",
       .value = worst_error_at_limit(),
       .upper = 1e-6,
       .bound_from = "theory: the chance is 0.05; two libraries with different series agree to this"});
  outcome.judge({.name = "least_coverage_of_50_ticks",
                 .value = least_coverage(50),
                 .lower = 0.95,
                 .upper = 1.0,
                 .bound_from = "theory: Clopper and Pearson's limit covers every truth at least so often"});
  outcome.judge({.name = "limit_where_all_missed",
                 .value = miss_probability_upper(7, 7),
                 .lower = 1.0,
                 .upper = 1.0,
                 .bound_from = "theory: nothing contradicts 1"});
  const double day = 86400e3;
  outcome.judge({.name = "limit_of_a_clean_day_at_1_khz_times_ticks",
                 .value = day * miss_probability_upper(0, static_cast<long>(day)),
                 .lower = 2.9957322,
                 .upper = 2.9957324,
                 .bound_from = "theory: n (1 - 0.05^(1/n)) = -log 0.05 = 2.99573227 within log^2/2n"});
}

void measure_percentiles(const CaseContext&, Outcome& outcome) {
  constexpr std::size_t count = 20000;
  device::Seeded random(1);
  LatencyHistogram histogram;
  std::vector<double> times;
  for (std::size_t n = 0; n < count; ++n) {
    times.push_back(100e-6 * std::exp(random.normal()));
    histogram.add(times.back());
  }
  std::ranges::sort(times);
  double least = 1.0;
  double most = -1.0;
  for (const double share : {0.5, 0.9, 0.99, 0.999, 0.9999}) {
    const double exact = times[static_cast<std::size_t>(std::ceil(share * double{count} - 1e-9)) - 1];
    const double off = histogram.percentile(share).value_or(std::nan("")) - exact;
    least = std::isnan(off) ? off : std::min(least, off);
    most = std::isnan(off) ? off : std::max(most, off);
  }
  const char* why = "a bin of 1 us: never too short, at most a bin too long; rounding of a difference";
  outcome.judge({.name = "least_of_percentile_minus_exact",
                 .value = 1e6 * least,
                 .unit = "us",
                 .lower = -1e-9,
                 .upper = 1.0,
                 .bound_from = why});
  outcome.judge({.name = "most_of_percentile_minus_exact",
                 .value = 1e6 * most,
                 .unit = "us",
                 .lower = -1e-9,
                 .upper = 1.0 + 1e-9,
                 .bound_from = why});
  outcome.judge({.name = "percentile_that_no_tick_lies_above",
                 .value = histogram.percentile(0.99999) ? 1.0 : 0.0,
                 .upper = 0.0,
                 .bound_from = "20 000 ticks say nothing of one in 100 000"});
}

}  // namespace

}  // namespace certificate

std::vector<Case> certificate_cases() {
  std::vector<Case> cases{
      {.name = "certificate/miss-bound",
       .suite = "model",
       .claim =
           "The limit of the miss probability is what the binomial law says, for no miss, some, and all.",
       .measure = certificate::measure_miss_bound,
       .weight = 0.1},
      {.name = "certificate/percentiles",
       .suite = "model",
       .claim = "Percentiles from bins of 1 us are those of the sorted times, rounded up to a bin.",
       .measure = certificate::measure_percentiles,
       .weight = 0.1}};
  std::ranges::move(certificate::tail_cases(), std::back_inserter(cases));
  return cases;
}

}  // namespace palpate
