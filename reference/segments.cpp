// SPDX-License-Identifier: MIT
#include "reference/segments.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "reference/solution.hpp"

namespace palpate::reference {

namespace {

void check_times(const std::vector<double>& times) {
  if (times.empty() || times.front() != 0.0) {
    throw SolverError("segments: the requested times must begin at 0 s");
  }
  for (std::size_t n = 1; n < times.size(); ++n) {
    if (!(times[n] > times[n - 1]) || !std::isfinite(times[n])) {
      throw SolverError("segments: requested time " + std::to_string(n) +
                        " is not later than the one before it");
    }
  }
}

/// Breaks strictly inside (0, end), each at least `apart` from the ends.
std::vector<double> inner_breaks(const Problem& problem, double end, double apart) {
  std::vector<double> inner;
  for (const double t : problem.breaks()) {
    if (t > apart && t < end - apart) { inner.push_back(t); }
  }
  return inner;
}

}  // namespace

std::vector<Segment> segments_of(const Problem& problem, const std::vector<double>& times) {
  check_times(times);
  std::vector<Segment> segments;
  if (times.size() == 1) { return segments; }
  // Two stops closer than this cannot be told apart by a solver that adds steps up.
  const double apart = 1e-13 * times.back();
  std::vector<double> ends = inner_breaks(problem, times.back(), apart);
  ends.push_back(times.back());
  const double longest = problem.shortest_feature() / 4.0;
  double start = 0.0;
  std::size_t next = 1;
  for (const double end : ends) {
    Segment segment{.start = start, .end = end, .gate = 0.5 * (start + end)};
    segment.max_step = std::min(longest, (end - start) / steps_per_segment);
    while (next < times.size() && times[next] < end - apart) {
      segment.stops.push_back({times[next], next});
      ++next;
    }
    Stop last{end, {}};
    if (next < times.size() && times[next] <= end + apart) { last.output = next++; }
    segment.stops.push_back(last);
    segments.push_back(std::move(segment));
    start = end;
  }
  return segments;
}

}  // namespace palpate::reference
