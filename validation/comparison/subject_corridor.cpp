// SPDX-License-Identifier: MIT

#include "validation/comparison/subject_corridor.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "validation/statistics.hpp"

namespace palpate::comparison {

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
