// SPDX-License-Identifier: MIT
/// Extrapolated response times of samples whose law is known: told where they may be, and right then.
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "device/seeded.hpp"
#include "validation/cases/certificate_parts.hpp"
#include "validation/certificate/tail.hpp"
#include "validation/comparison/statistics.hpp"

namespace palpate::certificate {

namespace {

using device::Seeded;
using Sample = std::vector<double>;
using Draw = std::function<Sample(Seeded&)>;

constexpr long ticks = least_ticks_of_tail;
constexpr double scale = 20e-6;  // [s]
constexpr double base = 300e-6;  // [s]

double exponential(Seeded& random) { return -std::log(1.0 - random.uniform(0.0, 1.0)); }

template <class Each>
Sample sample(Each&& each) {
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

/// Every late tick makes the next one late: extremal index 1/2.
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
  return sample([&](long n) { return exponential(random) * (1.0 + static_cast<double>(n) / double{ticks}); });
}

Sample disturbed_later(Seeded& random) {
  return sample([&](long n) { return exponential(random) * (2 * n < ticks ? 1.0 : 2.0); });
}

/// Shape 1: a mean that does not exist.
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
  std::size_t told = 0;
  std::size_t covered = 0;
};

/// `truth` [s] is the response that one tick in a hundred times as many as were seen exceeds.
Tried try_tails(const Draw& draw, int seeds, double truth) {
  Tried tried;
  for (int seed = 1; seed <= seeds; ++seed) {
    Seeded random(static_cast<std::uint64_t>(seed));
    const Tail tail = tail_of(draw(random));
    if (!tail.refusal.empty()) {
      ++tried.refused;
      continue;
    }
    ++tried.told;
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
  for (const auto& [name, draw, stretched] : {std::tuple{"exponential", Draw(independent), far},
                                              {"pareto", Draw(heavy), std::expm1(0.15 * far) / 0.15}}) {
    const Tried tried = try_tails(draw, seeds, base + scale * stretched);
    outcome.judge(
        {.name = std::string("refused_share_") + name,
         .value = share(tried.refused, static_cast<std::size_t>(seeds)),
         .upper = comparison::expected_share(checks * false_alarm, static_cast<std::size_t>(seeds)).upper,
         .bound_from = "ten checks with a false alarm in a thousand each; binomial limit, 99.9 %"});
    outcome.judge({.name = std::string("coverage_") + name,
                   .value = share(tried.covered, tried.told),
                   .lower = comparison::expected_share(0.95, std::max<std::size_t>(1, tried.told)).lower,
                   .bound_from = "intervals at 95 %; binomial limit, 99.9 %"});
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
    outcome.judge({.name = std::string("refused_share_") + name,
                   .value = share(tried.refused, static_cast<std::size_t>(seeds)),
                   .lower = 1.0,
                   .upper = 1.0,
                   .bound_from = "an assumption is broken: every sample must be refused"});
  }
}

}  // namespace

Tail tail_of_pairs(std::uint64_t seed) {
  Seeded random(seed);
  return tail_of(in_pairs(random));
}

std::vector<Case> tail_cases() {
  return {{.name = "certificate/tail/told",
           .suite = "model",
           .claim =
               "Of independent response times the tail is told, and its interval two decades beyond the data "
               "holds the truth as often as it says.",
           .measure = measure_told,
           .weight = 3.0},
          {.name = "certificate/tail/refused",
           .suite = "model",
           .claim = "Of response times that follow each other, change with time or have no mean, nothing is "
                    "extrapolated.",
           .measure = measure_refused,
           .weight = 1.0}};
}

}  // namespace palpate::certificate
