// SPDX-License-Identifier: MIT

#include "validation/certificate/tail.hpp"

#include <algorithm>
#include <array>
#include <boost/math/tools/minima.hpp>
#include <gsl/gsl_cdf.h>
#include <gsl/gsl_statistics_double.h>
#include <iterator>
#include <numeric>

#include "validation/number_text.hpp"

namespace palpate::certificate {

namespace {

constexpr double least_shape = -0.5;
constexpr double largest_shape = 3.0;
constexpr double exponential = 1e-7;  // shapes below it are that of the exponential distribution
constexpr double impossible = 1e300;
constexpr int digits = 26;  // bits of the position of a minimum: half of those of a double

double sum_of(std::span<const double> excess) {
  return std::accumulate(excess.begin(), excess.end(), 0.0);
}

/// Returns the negative log likelihood of shape and scale.
double unlikeliness(std::span<const double> excess, double shape, double scale) {
  if (!(scale > 0.0)) { return impossible; }
  const auto n = static_cast<double>(excess.size());
  if (std::abs(shape) < exponential) { return n * std::log(scale) + sum_of(excess) / scale; }
  double sum = 0.0;
  for (const double y : excess) {
    const double share = shape * y / scale;
    if (!(share > -1.0)) { return impossible; }
    sum += std::log1p(share);
  }
  return n * std::log(scale) + (1.0 + 1.0 / shape) * sum;
}

/// With theta = xi / sigma the optimal shape is the mean of log(1 + theta y) (Grimshaw,
/// Technometrics 35, 1993), which leaves one unknown.
struct AlongTheta {
  std::span<const double> excess;
  double largest;

  /// s is log(1 + theta y_max): 0 for the exponential distribution.
  [[nodiscard]] ParetoFit at(double s) const {
    const auto n = static_cast<double>(excess.size());
    const double theta = std::expm1(s) / largest;
    ParetoFit fit{.count = excess.size()};
    if (std::abs(s) < exponential) {
      fit.scale = sum_of(excess) / n;
    } else {
      double sum = 0.0;
      for (const double y : excess) { sum += std::log1p(theta * y); }
      fit.shape = sum / n;
      fit.scale = fit.shape / theta;
    }
    const bool allowed = fit.shape >= least_shape && fit.shape <= largest_shape;
    fit.log_likelihood = allowed ? -unlikeliness(excess, fit.shape, fit.scale) : -impossible;
    return fit;
  }
};

/// Returns y_q / sigma for a shape.
double stretch(double shape, double q) {
  const double decades = -std::log(q);
  return std::abs(shape) < exponential ? decades : std::expm1(shape * decades) / shape;
}

/// Returns the profile log likelihood: the maximum over all shapes whose excess at q is y.
double profile(std::span<const double> excess, double q, double y) {
  const auto cost = [&](double shape) {
    return unlikeliness(excess, shape, y / stretch(shape, q));
  };
  return -boost::math::tools::brent_find_minima(cost, least_shape, largest_shape, digits).second;
}

}  // namespace

double ParetoFit::shape_error() const {
  return (1.0 + shape) / std::sqrt(static_cast<double>(count));
}

double ParetoFit::exceeded(double y) const {
  if (std::abs(shape) < exponential) { return std::exp(-y / scale); }
  const double base = 1.0 + shape * y / scale;
  return base > 0.0 ? std::pow(base, -1.0 / shape) : 0.0;
}

double ParetoFit::excess_at(double q) const { return scale * stretch(shape, q); }

ParetoFit fit_pareto(std::span<const double> excess) {
  const AlongTheta line{excess, *std::ranges::max_element(excess)};
  constexpr double least = -4.0;  // of log(1 + theta y_max)
  constexpr double most = 16.0;
  constexpr int places = 80;
  constexpr double step = (most - least) / places;
  double best = 0.0;
  double likelihood = line.at(0.0).log_likelihood;
  for (int n = 0; n <= places; ++n) {
    const double s = least + n * step;
    const double here = line.at(s).log_likelihood;
    if (here > likelihood) {
      best = s;
      likelihood = here;
    }
  }
  const auto cost = [&](double s) { return -line.at(s).log_likelihood; };
  const double place =
      boost::math::tools::brent_find_minima(cost, best - step, best + step, digits).first;
  const ParetoFit found = line.at(place);
  return found.log_likelihood >= likelihood ? found : line.at(best);
}

ExcessInterval excess_interval(const ParetoFit& fit, std::span<const double> excess, double q,
                               double confidence) {
  const double least = fit.log_likelihood - 0.5 * gsl_cdf_chisq_Pinv(confidence, 1.0);
  const auto allowed = [&](double y) { return profile(excess, q, y) >= least; };
  const auto edge = [&](double inside, double outside) {
    constexpr double precision = 1e-4;
    while (std::abs(outside - inside) > precision * inside) {
      const double middle = std::sqrt(inside * outside);
      (allowed(middle) ? inside : outside) = middle;
    }
    return inside;
  };
  const double best = fit.excess_at(q);
  ExcessInterval interval{.lower = 0.0, .upper = unbounded};
  constexpr double far = 1e4;
  double low = best;
  while (low > best / far && allowed(low)) { low /= 2.0; }
  if (low > best / far) { interval.lower = edge(2.0 * low, low); }
  double high = best;
  while (high < best * far && allowed(high)) { high *= 2.0; }
  if (high < best * far) { interval.upper = edge(0.5 * high, high); }
  return interval;
}

namespace {

constexpr long lags = 10;

Quantity between(double lower, double upper, std::string name, double value, std::string claim) {
  return {.name = std::move(name),
          .value = value,
          .lower = lower,
          .upper = upper,
          .bound_from = std::move(claim)};
}

/// Returns the two-sided standard normal quantile for this probability.
double two_sided(double chance) { return gsl_cdf_ugaussian_Qinv(0.5 * chance); }

std::vector<double> sizes(const Exceedances& all) {
  std::vector<double> size;
  std::ranges::transform(all.ticks, std::back_inserter(size), &LargeTick::seconds);
  return size;
}

/// Returns the rank correlation of two lists of the same length; 0 if one is constant.
double rank_correlation(std::span<const double> a, std::span<const double> b) {
  std::vector<double> work(2 * a.size());
  const double r = gsl_stats_spearman(a.data(), 1, b.data(), 1, a.size(), work.data());
  return std::isfinite(r) ? r : 0.0;
}

Quantity correlation_check(const char* name, const char* claim, double r, std::size_t pairs) {
  const double limit = two_sided(false_alarm) / std::sqrt(static_cast<double>(pairs) - 1.0);
  return between(-limit, limit, name, r, claim);
}

/// Tests pairs of excesses at a lag: returns the probability of the most unusual number of such
/// pairs among independent ticks, times the number of lags. The number is approximately Poisson
/// distributed.
double chance_of_pairs(const Exceedances& all) {
  std::array<unsigned, lags + 1> pairs{};
  for (std::size_t n = 0; n < all.count(); ++n) {
    for (std::size_t m = n + 1; m < all.count() && all.ticks[m].tick - all.ticks[n].tick <= lags;
         ++m) {
      ++pairs[static_cast<std::size_t>(all.ticks[m].tick - all.ticks[n].tick)];
    }
  }
  const auto count = static_cast<double>(all.count());
  const double expected = count * count / static_cast<double>(all.of);
  double least = 1.0;
  for (std::size_t lag = 1; lag <= lags; ++lag) {
    if (pairs[lag] > 0) { least = std::min(least, gsl_cdf_poisson_Q(pairs[lag] - 1, expected)); }
  }
  return std::min(1.0, static_cast<double>(lags) * least);
}

/// Returns the largest distance of the distributions of two sorted samples (Kolmogorov & Smirnov).
double distribution_distance(std::span<const double> a, std::span<const double> b) {
  double distance = 0.0;
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    const double x = std::min(a[i], b[j]);
    while (i < a.size() && a[i] <= x) { ++i; }
    while (j < b.size() && b[j] <= x) { ++j; }
    distance = std::max(distance, std::abs(static_cast<double>(i) / static_cast<double>(a.size()) -
                                           static_cast<double>(j) / static_cast<double>(b.size())));
  }
  return distance;
}

Quantity halves_check(const Exceedances& all) {
  std::vector<double> first = sizes(all.half(false));
  std::vector<double> second = sizes(all.half(true));
  std::ranges::sort(first);
  std::ranges::sort(second);
  const auto n = static_cast<double>(first.size());
  const auto m = static_cast<double>(second.size());
  const bool both = n > 0.0 && m > 0.0;
  return between(
      0.0, both ? std::sqrt(-0.5 * std::log(0.5 * false_alarm) * (n + m) / (n * m)) : 0.0,
      "same-distribution-in-both-halves", both ? distribution_distance(first, second) : 1.0,
      "excesses of both halves have one distribution (Kolmogorov-Smirnov distance)");
}

}  // namespace

std::vector<double> Exceedances::excess() const {
  std::vector<double> excess;
  for (const LargeTick& each : ticks) { excess.push_back(each.seconds - threshold); }
  return excess;
}

Exceedances Exceedances::half(bool second) const {
  Exceedances part{.threshold = threshold, .of = second ? of - of / 2 : of / 2};
  for (const LargeTick& each : ticks) {
    if ((each.tick >= of / 2) == second) { part.ticks.push_back(each); }
  }
  return part;
}

Exceedances exceedances(std::span<const LargeTick> largest, std::size_t count, long ticks) {
  Exceedances all{.threshold = largest[count].seconds, .of = ticks};
  all.ticks.assign(largest.begin(), largest.begin() + static_cast<std::ptrdiff_t>(count));
  std::ranges::sort(all.ticks, {}, &LargeTick::tick);
  return all;
}

double extremal_index(const Exceedances& all) {
  double sum = 0.0;
  double squares = 0.0;
  double longest = 0.0;
  const auto gaps = static_cast<double>(all.count() - 1);
  for (std::size_t n = 1; n < all.count(); ++n) {
    longest = std::max(longest, static_cast<double>(all.ticks[n].tick - all.ticks[n - 1].tick));
  }
  const double one = longest > 2.0 ? 1.0 : 0.0;
  const double two = longest > 2.0 ? 2.0 : 0.0;
  for (std::size_t n = 1; n < all.count(); ++n) {
    const auto gap = static_cast<double>(all.ticks[n].tick - all.ticks[n - 1].tick);
    sum += gap - one;
    squares += (gap - one) * (gap - two);
  }
  return squares > 0.0 ? std::min(1.0, 2.0 * sum * sum / (gaps * squares)) : 1.0;
}

std::vector<Quantity> independence_checks(const Exceedances& all) {
  const std::vector<double> size = sizes(all);
  const std::span<const double> each(size);
  // For n exponential gaps the standard error of the estimator is 1 / sqrt(n): 4 + 20/4 - 8/2 from
  // the moments of mean and mean square.
  const double spread =
      gsl_cdf_ugaussian_Qinv(false_alarm) / std::sqrt(static_cast<double>(all.count()));
  return {between(false_alarm, 1.0, "alone-in-time", chance_of_pairs(all),
                  "late ticks do not follow each other within ten ticks (chance of so many pairs)"),
          correlation_check(
              "sizes-uncorrelated", "a large excess does not announce the next (rank correlation)",
              rank_correlation(each.first(size.size() - 1), each.subspan(1)), size.size() - 1),
          between(1.0 - spread, 1.0, "extremal-index", extremal_index(all),
                  "excesses do not come in clusters (extremal index, 1 without any)")};
}

std::vector<Quantity> stationarity_checks(const Exceedances& all) {
  const auto count = static_cast<double>(all.count());
  const auto first = static_cast<double>(all.half(false).count());
  const double limit = two_sided(false_alarm);
  std::vector<double> order(all.count());
  std::iota(order.begin(), order.end(), 0.0);
  return {
      between(-limit, limit, "as-many-in-both-halves", (2.0 * first - count) / std::sqrt(count),
              "both halves have as many excesses (difference over its standard error)"),
      halves_check(all),
      correlation_check("no-trend", "excesses do not grow or shrink with time (rank correlation)",
                        rank_correlation(order, sizes(all)), all.count())};
}

namespace {

/// Returns the number of excesses over the lowest threshold: a twentieth of all ticks, at most
/// those stored.
std::size_t most_excesses(std::span<const LargeTick> largest, long ticks) {
  return std::min(largest.size() - 1, static_cast<std::size_t>(ticks / 20));
}

struct Level {
  Exceedances above{};
  std::vector<double> excess{};
  ParetoFit fit{};
};

/// Fits thresholds in order, each with half the excesses of the previous one.
std::vector<Level> levels_of(std::span<const LargeTick> largest, long ticks) {
  std::vector<Level> levels;
  for (const std::size_t part : {1U, 2U, 4U}) {
    Level level{.above = exceedances(largest, most_excesses(largest, ticks) / part, ticks)};
    level.excess = level.above.excess();
    if (!(*std::ranges::min_element(level.excess) < *std::ranges::max_element(level.excess))) {
      return {};
    }
    level.fit = fit_pareto(level.excess);
    levels.push_back(std::move(level));
  }
  return levels;
}

/// Converts the probability per tick to that among excesses.
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

Quantity shape_limit(const Level& lowest) {
  constexpr double one_sided = 1.6449;  // normal, 95 %
  return between(-1.0, 0.5, "shape-below-half",
                 lowest.fit.shape + one_sided * lowest.fit.shape_error(),
                 "the tail has a variance: upper 95 % limit of the shape below 0.5");
}

/// Excesses over a higher threshold are a subset of those over the lowest, so variances subtract.
Quantity shape_stability(const std::vector<Level>& levels) {
  const Level& lowest = levels.front();
  Largest largest;
  for (std::size_t n = 1; n < levels.size(); ++n) {
    const double spread =
        (1.0 + lowest.fit.shape) * std::sqrt(1.0 / static_cast<double>(levels[n].fit.count) -
                                             1.0 / static_cast<double>(lowest.fit.count));
    largest.add(std::abs(levels[n].fit.shape - lowest.fit.shape) / spread);
  }
  return between(
      0.0, gsl_cdf_ugaussian_Qinv(0.25 * false_alarm), "shape-at-every-threshold", largest.value(),
      "the shape is the same over three thresholds (difference over its standard error)");
}

/// Returns 0 in the middle of the allowed interval of the worst other threshold, 1 at its edge.
Quantity level_stability(const std::vector<Level>& levels, double probability) {
  const double value = return_level(levels.front(), probability, 1.0 - false_alarm).value;
  Largest worst;
  for (std::size_t n = 1; n < levels.size(); ++n) {
    const ReturnLevel other = return_level(levels[n], probability, 1.0 - false_alarm);
    const double room = value < other.value ? other.value - other.lower : other.upper - other.value;
    worst.add(std::abs(value - other.value) / room);
  }
  return between(
      0.0, 1.0, "level-at-every-threshold", worst.value(),
      "what is extrapolated lies within what higher thresholds allow (share of their interval)");
}

/// Checks that the fit to the first half bounds the maximum of the second half.
Quantity prediction_check(const Level& lowest) {
  Level first{.above = lowest.above.half(false)};
  const Exceedances second = lowest.above.half(true);
  Quantity check = between(
      std::nan(""), 0.0, "first-half-foretells-second",
      second.count() > 0 ? 1e6 * std::ranges::max(second.ticks, {}, &LargeTick::seconds).seconds
                         : std::nan(""),
      "the largest of the second half is one that the first half allows (us)");
  if (first.above.count() < 25) { return check; }
  first.excess = first.above.excess();
  first.fit = fit_pareto(first.excess);
  const auto ticks = static_cast<double>(second.of);
  check.lower =
      1e6 * return_level(first, -std::log(0.5 * false_alarm) / ticks, 1.0 - false_alarm).lower;
  check.upper = 1e6 * return_level(first, 0.5 * false_alarm / ticks, 1.0 - false_alarm).upper;
  return check;
}

std::string contradiction(const Quantity& check) {
  return "\"" + check.bound_from + "\": found " + plain_number(check.value, 3) + ", allowed " +
         plain_number(check.lower, 3) + " to " + plain_number(check.upper, 3);
}

std::optional<double> beyond(const Level& lowest, double deadline, double least) {
  const double above =
      static_cast<double>(lowest.above.count()) / static_cast<double>(lowest.above.of);
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
  std::ranges::move(stationarity_checks(lowest.above), std::back_inserter(tail.checks));
  std::ranges::move(std::array{shape_stability(levels), level_stability(levels, decades[1]),
                               shape_limit(lowest), prediction_check(lowest)},
                    std::back_inserter(tail.checks));
  for (const Level& level : levels) { tail.fits.push_back({level.above.threshold, level.fit}); }
  std::vector<std::string> contradictions;
  for (const Quantity& check : tail.checks) {
    if (!check.holds()) { contradictions.push_back(contradiction(check)); }
  }
  if (!contradictions.empty()) {
    tail.refusal = "contradicted by the data: " + join(contradictions, "; ");
    return tail;
  }
  for (const double probability : decades) {
    tail.levels.push_back(return_level(lowest, probability, 0.95));
  }
  tail.beyond_deadline = beyond(lowest, deadline, decades[1]);
  return tail;
}

}  // namespace palpate::certificate
