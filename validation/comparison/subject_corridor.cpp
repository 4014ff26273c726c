// SPDX-License-Identifier: MIT
#include "validation/comparison/subject_corridor.hpp"

#include <cmath>

#include "validation/comparison/statistics.hpp"

namespace palpate::comparison {

CorridorBuilt build_corridor(std::span<const Samples> aligned, const CorridorRule& rule) {
  const std::size_t count = aligned.size();
  if (count < std::max<std::size_t>(2, rule.least_recordings)) {
    return {.refusal = "a corridor needs at least " + std::to_string(rule.least_recordings) +
                       " recordings; there " + (count == 1 ? "is 1" : "are " + std::to_string(count))};
  }
  const Samples& grid = aligned.front();
  SubjectCorridor corridor{.mean = grid, .deviation = grid, .recordings = count};
  corridor.half_width = rule.half_width.value_or(student_factor(0.95, count - 1) *
                                                 std::sqrt(1.0 + 1.0 / static_cast<double>(count)));
  bool any = false;
  for (std::size_t n = 0; n < grid.size(); ++n) {
    std::vector<double> here;
    for (const Samples& one : aligned) {
      if (n < one.size() && std::isfinite(one.value[n])) { here.push_back(one.value[n]); }
    }
    const bool enough = here.size() >= std::max<std::size_t>(2, rule.least_recordings);
    any = any || enough;
    corridor.mean.value[n] = enough ? mean_of(here) : not_measured;
    corridor.deviation.value[n] = enough ? deviation_of(here) : not_measured;
  }
  if (!any) { return {.refusal = "no instant is covered by enough recordings"}; }
  return {.corridor = std::move(corridor)};
}

CorridorCoverage coverage(const SubjectCorridor& corridor, const Samples& simulated,
                          const CorridorRule& rule) {
  CorridorCoverage result;
  std::size_t inside = 0;
  for (std::size_t n = 0; n < std::min(simulated.size(), corridor.mean.size()); ++n) {
    const double beyond = std::abs(simulated.value[n] - corridor.mean.value[n]) -
                          corridor.half_width * corridor.deviation.value[n];
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
