// SPDX-License-Identifier: MIT
/// Cases of the statistics of a real-time certificate, with data of a known distribution.

#include "validation/certificate/certificate.hpp"

#include <algorithm>
#include <gsl/gsl_cdf.h>
#include <gsl/gsl_randist.h>

#include "device/seeded.hpp"
#include "validation/certificate/paced_loop.hpp"
#include "validation/claims/groups.hpp"
#include "validation/statistics.hpp"

namespace palpate::certificate {

namespace {

/// Returns the error of the chance of so few misses at the limit, 0.05, by a second library.
double worst_error_at_limit() {
  Largest worst;
  for (const long ticks : {10L, 1000L, 60000L, 86400000L}) {
    for (const long misses : {0L, 1L, 3L, 9L}) {
      if (misses >= ticks) { continue; }
      const double limit = miss_probability_upper(misses, ticks);
      const double chance =
          gsl_cdf_binomial_P(static_cast<unsigned>(misses), limit, static_cast<unsigned>(ticks));
      worst.add(std::abs(chance - 0.05) / 0.05);
    }
  }
  return worst.value();
}

/// Returns the coverage of the limit from the binomial distribution.
double least_coverage(long ticks) {
  std::vector<double> limit;
  for (long misses = 0; misses <= ticks; ++misses) {
    limit.push_back(miss_probability_upper(misses, ticks));
  }
  Smallest least(1.0);
  for (int n = 1; n < 1000; ++n) {
    const double truth = 1e-3 * n;
    double covered = 0.0;
    for (long misses = 0; misses <= ticks; ++misses) {
      if (truth > limit[static_cast<std::size_t>(misses)]) { continue; }
      covered +=
          gsl_ran_binomial_pdf(static_cast<unsigned>(misses), truth, static_cast<unsigned>(ticks));
    }
    least.add(covered);
  }
  return least.value();
}

void measure_miss_bound(const CaseContext&, Outcome& outcome) {
  outcome.judge_at_most(
      "error_of_the_chance_at_the_limit", worst_error_at_limit(), 1e-6,
      "theory: the chance is 0.05; two libraries with different series agree to this");
  outcome.judge_between("least_coverage_of_50_ticks", least_coverage(50), 0.95, 1.0,
                        "theory: Clopper and Pearson's limit covers every truth at least so often");
  outcome.judge_equal("limit_where_all_missed", miss_probability_upper(7, 7), 1.0,
                      "theory: nothing contradicts 1");
  const double day = 86400e3;
  outcome.judge_between("limit_of_a_clean_day_at_1_khz_times_ticks",
                        day * miss_probability_upper(0, static_cast<long>(day)), 2.9957322,
                        2.9957324,
                        "theory: n (1 - 0.05^(1/n)) = -log 0.05 = 2.99573227 within log^2/2n");
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
  Smallest least(1.0);
  Largest most(-1.0);
  for (const double share : {0.5, 0.9, 0.99, 0.999, 0.9999}) {
    const double exact =
        times[static_cast<std::size_t>(std::ceil(share * double{count} - 1e-9)) - 1];
    const double off = histogram.percentile(share).value_or(std::nan("")) - exact;
    least.add(off);
    most.add(off);
  }
  const char* why =
      "a bin of 1 us: never too short, at most a bin too long; rounding of a difference";
  outcome.judge_between("least_of_percentile_minus_exact", 1e6 * least.value(), -1e-9, 1.0, why,
                        "us");
  outcome.judge_between("most_of_percentile_minus_exact", 1e6 * most.value(), -1e-9, 1.0 + 1e-9,
                        why, "us");
  outcome.judge_at_most("percentile_that_no_tick_lies_above",
                        histogram.percentile(0.99999) ? 1.0 : 0.0, 0.0,
                        "20 000 ticks say nothing of one in 100 000");
}

// Extrapolated response times of known distributions: correct, or refused if assumptions fail.

using device::Seeded;
using Sample = std::vector<double>;
using Draw = std::function<Sample(Seeded&)>;

constexpr long ticks = least_ticks_of_tail;
constexpr double scale = 20e-6;  // [s]
constexpr double base = 300e-6;  // [s]

double exponential(Seeded& random) { return -std::log(1.0 - random.uniform(0.0, 1.0)); }

template <class Each> Sample sample(Each&& each) {
  Sample times;
  for (long n = 0; n < ticks; ++n) { times.push_back(base + scale * each(n)); }
  return times;
}

Sample independent(Seeded& random) {
  return sample([&](long) { return exponential(random); });
}

/// Generalised Pareto with shape 0.15: the tail is heavier than exponential.
Sample heavy(Seeded& random) {
  return sample([&](long) { return std::expm1(0.15 * exponential(random)) / 0.15; });
}

/// Samples in which every late tick makes the next one late: extremal index 1/2.
Sample in_pairs(Seeded& random) {
  double before = exponential(random);
  return sample([&](long) {
    const double now = exponential(random);
    return std::max(std::exchange(before, now), now);
  });
}

/// The exponential of a normal AR(1) process with correlation 0.7.
Sample autoregressive(Seeded& random) {
  double state = random.normal();
  return sample([&](long) {
    state = 0.7 * state + std::sqrt(1.0 - 0.49) * random.normal();
    return std::exp(0.5 * state);
  });
}

Sample growing(Seeded& random) {
  return sample(
      [&](long n) { return exponential(random) * (1.0 + static_cast<double>(n) / double{ticks}); });
}

Sample disturbed_later(Seeded& random) {
  return sample([&](long n) { return exponential(random) * (2 * n < ticks ? 1.0 : 2.0); });
}

/// Distribution of shape 1, without a finite mean.
Sample without_mean(Seeded& random) {
  return sample([&](long) { return std::expm1(exponential(random)); });
}

Tail tail_of(const Sample& times) {
  LargestTicks largest(kept_responses);
  for (std::size_t n = 0; n < times.size(); ++n) { largest.add({times[n], static_cast<long>(n)}); }
  return judge_tail(largest.sorted(), static_cast<long>(times.size()), 1e-3);
}

struct Tried {
  std::size_t refused = 0;
  std::size_t extrapolated = 0;
  std::size_t covered = 0;
};

/// `truth` [s]: the response that one tick in a hundred times the observed number exceeds.
Tried try_tails(const Draw& draw, int seeds, double truth) {
  Tried tried;
  for (int seed = 1; seed <= seeds; ++seed) {
    Seeded random(static_cast<std::uint64_t>(seed));
    const Tail tail = tail_of(draw(random));
    if (!tail.refusal.empty()) {
      ++tried.refused;
      continue;
    }
    ++tried.extrapolated;
    const ReturnLevel& level = tail.levels.back();
    tried.covered += level.lower <= truth && truth <= level.upper ? 1 : 0;
  }
  return tried;
}

double share(std::size_t part, std::size_t all) {
  return all == 0 ? std::nan("") : static_cast<double>(part) / static_cast<double>(all);
}

void measure_told(const CaseContext& context, Outcome& outcome) {
  const int seeds = context.quick ? 40 : 200;
  constexpr double checks = 10.0;
  const double far = std::log(100.0 * double{ticks});  // scales beyond the base
  for (const auto& [name, draw, stretched] :
       {std::tuple{"exponential", Draw(independent), far},
        {"pareto", Draw(heavy), std::expm1(0.15 * far) / 0.15}}) {
    const Tried tried = try_tails(draw, seeds, base + scale * stretched);
    outcome.judge_at_most(
        std::string("refused_share_") + name, share(tried.refused, static_cast<std::size_t>(seeds)),
        comparison::expected_share(checks * false_alarm, static_cast<std::size_t>(seeds)).upper,
        "ten checks with a false alarm in a thousand each; binomial limit, 99.9 %");
    outcome.judge_at_least(
        std::string("coverage_") + name, share(tried.covered, tried.extrapolated),
        comparison::expected_share(0.95, std::max<std::size_t>(1, tried.extrapolated)).lower,
        "intervals at 95 %; binomial limit, 99.9 %");
  }
}

void measure_refused(const CaseContext& context, Outcome& outcome) {
  const int seeds = context.quick ? 8 : 50;
  for (const auto& [name, draw] : {std::pair{"in_pairs", Draw(in_pairs)},
                                   {"autoregressive", Draw(autoregressive)},
                                   {"growing", Draw(growing)},
                                   {"disturbed_later", Draw(disturbed_later)},
                                   {"without_mean", Draw(without_mean)}}) {
    const Tried tried = try_tails(draw, seeds, 0.0);
    outcome.judge_equal(std::string("refused_share_") + name,
                        share(tried.refused, static_cast<std::size_t>(seeds)), 1.0,
                        "an assumption is broken: every sample must be refused");
  }
}

}  // namespace

Tail tail_of_pairs(std::uint64_t seed) {
  Seeded random(seed);
  return tail_of(in_pairs(random));
}

std::vector<Case> cases() {
  return {{"certificate/miss-bound", "model",
           "The limit of the miss probability is what the binomial law says, for no miss, some, "
           "and all.",
           measure_miss_bound, 0.1},
          {"certificate/percentiles", "model",
           "Percentiles from bins of 1 us are those of the sorted times, rounded up to a bin.",
           measure_percentiles, 0.1},
          {"certificate/tail/told", "model",
           "The tail of independent response times is extrapolated, and its interval two decades "
           "beyond the data contains the true value at the stated rate.",
           measure_told, 3.0},
          {"certificate/tail/refused", "model",
           "Of response times that follow each other, change with time or have no mean, nothing is "
           "extrapolated.",
           measure_refused, 1.0}};
}

}  // namespace palpate::certificate
