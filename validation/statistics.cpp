// SPDX-License-Identifier: MIT

#include "validation/statistics.hpp"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "device/seeded.hpp"

namespace palpate::comparison {

Interval share_interval(std::size_t hits, std::size_t trials, double level) {
  const double tail = 0.5 * (1.0 - level);
  const auto k = static_cast<double>(hits);
  const auto n = static_cast<double>(trials);
  return {hits == 0 ? 0.0 : boost::math::ibeta_inv(k, n - k + 1.0, tail),
          hits == trials ? 1.0 : boost::math::ibetac_inv(k + 1.0, n - k, tail)};
}

Interval expected_share(double share, std::size_t trials, double level) {
  const double tail = 0.5 * (1.0 - level);
  const auto n = static_cast<double>(trials);
  const boost::math::binomial counts(n, share);
  double low = 0.0;
  while (low < n && cdf(counts, low) < tail) { ++low; }
  double high = n;
  while (high > 0.0 && cdf(complement(counts, high - 1.0)) < tail) { --high; }
  return {low / n, high / n};
}

double mean_of(std::span<const double> value) {
  return std::accumulate(value.begin(), value.end(), 0.0) / static_cast<double>(value.size());
}

double deviation_of(std::span<const double> value) {
  const double mean = mean_of(value);
  double square = 0.0;
  for (const double v : value) { square += (v - mean) * (v - mean); }
  return std::sqrt(square / (static_cast<double>(value.size()) - 1.0));
}

std::optional<Interval> bootstrap_mean(std::span<const double> value,
                                       const BootstrapOptions& options) {
  if (value.size() < 3 || options.draws == 0) { return std::nullopt; }
  device::Seeded seeded(options.seed);
  const auto count = static_cast<double>(value.size());
  std::vector<double> means(options.draws, 0.0);
  for (double& mean : means) {
    for (std::size_t n = 0; n < value.size(); ++n) {
      mean += value[static_cast<std::size_t>(seeded.uniform(0.0, count))] / count;
    }
  }
  const double tail = 0.5 * (1.0 - options.level);
  return Interval{quantile(means, tail), quantile(means, 1.0 - tail)};
}

double student_factor(double level, std::size_t degrees_of_freedom) {
  const boost::math::students_t t(static_cast<double>(degrees_of_freedom));
  return quantile(complement(t, 0.5 * (1.0 - level)));
}

double student_share(double factor, std::size_t degrees_of_freedom) {
  const boost::math::students_t t(static_cast<double>(degrees_of_freedom));
  return 1.0 - 2.0 * cdf(complement(t, factor));
}

double normal_above(double deviations) { return 0.5 * std::erfc(deviations / std::numbers::sqrt2); }

std::vector<std::size_t> subject_indices(std::span<const std::string> codes) {
  std::vector<std::size_t> subject;
  std::map<std::string, std::size_t> known;
  std::size_t count = 0;
  for (const std::string& code : codes) {
    const bool is_new = code.empty() || known.try_emplace(code, count).second;
    subject.push_back(is_new ? count++ : known.at(code));
  }
  return subject;
}

std::size_t subject_count(std::span<const std::size_t> subject) {
  return subject.empty() ? 0 : std::ranges::max(subject) + 1;
}

OverSubjects over_subjects(std::span<const double> value, std::span<const std::size_t> subject) {
  std::map<std::size_t, std::vector<double>> by_subject;
  for (std::size_t n = 0; n < value.size(); ++n) {
    if (std::isfinite(value[n])) {
      by_subject[subject.empty() ? n : subject[n]].push_back(value[n]);
    }
  }
  OverSubjects over;
  double square = 0.0;
  double repeats = 0.0;        // sum of n_i - 1
  double inverse_count = 0.0;  // <1/n_i>
  for (const auto& [index, own] : by_subject) {
    const double mean = over.means.emplace_back(mean_of(own));
    for (const double v : own) { square += (v - mean) * (v - mean); }
    over.recordings += own.size();
    repeats += static_cast<double>(own.size() - 1);
    inverse_count += 1.0 / static_cast<double>(own.size() * by_subject.size());
  }
  if (over.means.empty()) { return over; }
  over.mean = mean_of(over.means);
  over.deviation = deviation_of(over.means);
  const double within = repeats > 0.0 ? square / repeats : 0.0;
  over.of_recording = std::sqrt(over.deviation * over.deviation + within * (1.0 - inverse_count));
  return over;
}

namespace {

/// Returns k for every number of subjects up to `most`; NaN for fewer than two.
std::vector<double> factors(std::size_t most, const CorridorRule& rule) {
  std::vector<double> all(most + 1, not_measured);
  for (std::size_t n = 2; n <= most; ++n) {
    all[n] = rule.half_width.value_or(student_factor(0.95, n - 1) *
                                      std::sqrt(1.0 + 1.0 / static_cast<double>(n)));
  }
  return all;
}

}  // namespace

CorridorBuilt build_corridor(std::span<const Samples> aligned, const CorridorRule& rule,
                             std::span<const std::size_t> subject) {
  const std::size_t count = subject.empty() ? aligned.size() : subject_count(subject);
  const std::size_t least = std::max<std::size_t>(2, rule.least_subjects);
  if (count < least) {
    return {.refusal = "a corridor needs at least " + std::to_string(least) + " subjects; there " +
                       (count == 1 ? "is 1" : "are " + std::to_string(count))};
  }
  const Samples& grid = aligned.front();
  const std::vector<double> factor = factors(count, rule);
  SubjectCorridor corridor{.mean = grid,
                           .deviation = grid,
                           .half_width = grid,
                           .subjects = count,
                           .recordings = aligned.size(),
                           .factor = factor.back()};
  bool any = false;
  std::vector<double> here(aligned.size());
  for (std::size_t n = 0; n < grid.size(); ++n) {
    for (std::size_t m = 0; m < aligned.size(); ++m) {
      here[m] = n < aligned[m].size() ? aligned[m].value[n] : not_measured;
    }
    const OverSubjects over = over_subjects(here, subject);
    const bool enough = over.means.size() >= least;
    any = any || enough;
    corridor.mean.value[n] = enough ? over.mean : not_measured;
    corridor.deviation.value[n] = enough ? over.of_recording : not_measured;
    corridor.half_width.value[n] = factor[over.means.size()] * corridor.deviation.value[n];
  }
  if (!any) { return {.refusal = "no instant is covered by enough subjects"}; }
  return {.corridor = std::move(corridor)};
}

CorridorCoverage coverage(const SubjectCorridor& corridor, const Samples& simulated,
                          const CorridorRule& rule) {
  CorridorCoverage result;
  std::size_t inside = 0;
  for (std::size_t n = 0; n < std::min(simulated.size(), corridor.mean.size()); ++n) {
    const double beyond =
        std::abs(simulated.value[n] - corridor.mean.value[n]) - corridor.half_width.value[n];
    if (!std::isfinite(beyond)) { continue; }
    ++result.samples;
    if (beyond <= 0.0) { ++inside; }
    if (beyond > result.largest_excursion) {
      result.largest_excursion = beyond;
      result.excursion_time = simulated.time(n);
    }
  }
  result.inside = static_cast<double>(inside) / static_cast<double>(result.samples);  // NaN of none
  result.holds = result.inside >= rule.least_inside;
  return result;
}

}  // namespace palpate::comparison
