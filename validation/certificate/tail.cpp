// SPDX-License-Identifier: MIT
#include "validation/certificate/tail.hpp"

#include <algorithm>
#include <cmath>
#include <gsl/gsl_cdf.h>

#include "validation/certificate/tail_checks.hpp"
#include "validation/number_words.hpp"

namespace palpate::certificate {

namespace {

/// Excesses over the lowest threshold: a twentieth of all ticks, and those that are kept.
std::size_t most_excesses(std::span<const LargeTick> largest, long ticks) {
  return std::min(largest.size() - 1, static_cast<std::size_t>(ticks / 20));
}

struct Level {
  Exceedances above{};
  std::vector<double> excess{};
  ParetoFit fit{};
};

/// Threshold by threshold, each with half the excesses of the one below.
std::vector<Level> levels_of(std::span<const LargeTick> largest, long ticks) {
  std::vector<Level> levels;
  for (const std::size_t part : {1U, 2U, 4U}) {
    Level level{.above = exceedances(largest, most_excesses(largest, ticks) / part, ticks)};
    level.excess = level.above.excess();
    if (!(*std::ranges::min_element(level.excess) < *std::ranges::max_element(level.excess))) { return {}; }
    level.fit = fit_pareto(level.excess);
    levels.push_back(std::move(level));
  }
  return levels;
}

/// The chance of a tick, among those above the threshold.
double conditional(const Exceedances& above, double probability) {
  return probability * static_cast<double>(above.of) / static_cast<double>(above.count());
}

ReturnLevel return_level(const Level& level, double probability, double confidence) {
  const double q = conditional(level.above, probability);
  const ExcessInterval interval = excess_interval(level.fit, level.excess, q, confidence);
  const double threshold = level.above.threshold;
  return {.probability = probability,
          .value = threshold + level.fit.excess_at(q),
          .lower = threshold + interval.lower,
          .upper = threshold + interval.upper};
}

TailCheck shape_limit(const Level& lowest) {
  constexpr double one_sided = 1.6449;  // normal, 95 %
  return {.name = "shape-below-half",
          .claim = "the tail has a variance: upper 95 % limit of the shape below 0.5",
          .value = lowest.fit.shape + one_sided * lowest.fit.shape_error(),
          .lower = -1.0,
          .upper = 0.5};
}

/// Excesses over a higher threshold are some of those over the lowest, so that variances subtract.
TailCheck shape_stability(const std::vector<Level>& levels) {
  const Level& lowest = levels.front();
  double largest = 0.0;
  for (std::size_t n = 1; n < levels.size(); ++n) {
    const double spread =
        (1.0 + lowest.fit.shape) * std::sqrt(1.0 / static_cast<double>(levels[n].fit.count) -
                                             1.0 / static_cast<double>(lowest.fit.count));
    const double apart = std::abs(levels[n].fit.shape - lowest.fit.shape) / spread;
    largest = std::isnan(apart) ? apart : std::max(largest, apart);
  }
  return {.name = "shape-at-every-threshold",
          .claim = "the shape is the same over three thresholds (difference over its standard error)",
          .value = largest,
          .lower = 0.0,
          .upper = gsl_cdf_ugaussian_Qinv(0.25 * false_alarm)};
}

/// 0 in the middle of what the worst other threshold allows, 1 at its edge.
TailCheck level_stability(const std::vector<Level>& levels, double probability) {
  const double value = return_level(levels.front(), probability, 1.0 - false_alarm).value;
  double worst = 0.0;
  for (std::size_t n = 1; n < levels.size(); ++n) {
    const ReturnLevel other = return_level(levels[n], probability, 1.0 - false_alarm);
    const double room = value < other.value ? other.value - other.lower : other.upper - other.value;
    worst = std::max(worst, std::abs(value - other.value) / room);
  }
  return {.name = "level-at-every-threshold",
          .claim = "what is extrapolated lies within what higher thresholds allow (share of their interval)",
          .value = worst,
          .lower = 0.0,
          .upper = 1.0};
}

/// The first half alone bounds the largest of the second.
TailCheck foretelling(const Level& lowest) {
  Level first{.above = lowest.above.half(false)};
  const Exceedances second = lowest.above.half(true);
  TailCheck check{.name = "first-half-foretells-second",
                  .claim = "the largest of the second half is one that the first half allows (us)",
                  .value = second.count() > 0
                               ? 1e6 * std::ranges::max(second.ticks, {}, &LargeTick::seconds).seconds
                               : std::nan(""),
                  .lower = std::nan("")};
  if (first.above.count() < 25) { return check; }
  first.excess = first.above.excess();
  first.fit = fit_pareto(first.excess);
  const auto ticks = static_cast<double>(second.of);
  check.lower = 1e6 * return_level(first, -std::log(0.5 * false_alarm) / ticks, 1.0 - false_alarm).lower;
  check.upper = 1e6 * return_level(first, 0.5 * false_alarm / ticks, 1.0 - false_alarm).upper;
  return check;
}

std::string contradiction(const TailCheck& check) {
  return "\"" + check.claim + "\": found " + plain_number(check.value, 3) + ", allowed " +
         plain_number(check.lower, 3) + " to " + plain_number(check.upper, 3);
}

std::optional<double> beyond(const Level& lowest, double deadline, double least) {
  const double above = static_cast<double>(lowest.above.count()) / static_cast<double>(lowest.above.of);
  if (!(deadline > lowest.above.threshold)) { return {}; }
  const double chance = above * lowest.fit.exceeded(deadline - lowest.above.threshold);
  return chance >= least ? std::optional(chance) : std::nullopt;
}

}  // namespace

Tail judge_tail(std::span<const LargeTick> largest, long ticks, double deadline) {
  Tail tail;
  if (ticks < least_ticks_of_tail) {
    tail.refusal = "too few ticks for a tail: " + std::to_string(ticks) + ", at least " +
                   std::to_string(least_ticks_of_tail);
    return tail;
  }
  const std::vector<Level> levels = levels_of(largest, ticks);
  if (levels.empty()) {
    tail.refusal = "the largest response times are all alike: no tail to fit";
    return tail;
  }
  const Level& lowest = levels.front();
  const double decades[] = {0.1 / static_cast<double>(ticks), 0.01 / static_cast<double>(ticks)};
  tail.checks = independence_checks(lowest.above);
  for (TailCheck& check : stationarity_checks(lowest.above)) { tail.checks.push_back(std::move(check)); }
  tail.checks.push_back(shape_stability(levels));
  tail.checks.push_back(level_stability(levels, decades[1]));
  tail.checks.push_back(shape_limit(lowest));
  tail.checks.push_back(foretelling(lowest));
  for (const Level& level : levels) { tail.fits.push_back({level.above.threshold, level.fit}); }
  for (const TailCheck& check : tail.checks) {
    if (check.holds()) { continue; }
    tail.refusal += (tail.refusal.empty() ? "contradicted by the data: " : "; ") + contradiction(check);
  }
  if (!tail.refusal.empty()) { return tail; }
  for (const double probability : decades) { tail.levels.push_back(return_level(lowest, probability, 0.95)); }
  tail.beyond_deadline = beyond(lowest, deadline, decades[1]);
  return tail;
}

}  // namespace palpate::certificate
