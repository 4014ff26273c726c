// SPDX-License-Identifier: MIT
#include "validation/gate/tube.hpp"

#include <algorithm>
#include <iterator>
#include <limits>

namespace palpate::gate {

namespace {

struct Range {
  double least = std::numeric_limits<double>::infinity();
  double greatest = -std::numeric_limits<double>::infinity();

  void add(double y) {
    least = std::min(least, y);
    greatest = std::max(greatest, y);
  }
};

/// On the chord between its neighbours; at the ends the end's own value.
double value_at(const Path& path, double x) {
  const auto right = std::ranges::lower_bound(path.x, x);
  if (right == path.x.begin()) { return path.y.front(); }
  if (right == path.x.end()) { return path.y.back(); }
  const auto n = static_cast<std::size_t>(std::distance(path.x.begin(), right));
  const double width = path.x[n] - path.x[n - 1];
  const double share = width > 0.0 ? (x - path.x[n - 1]) / width : 1.0;
  return path.y[n - 1] + share * (path.y[n] - path.y[n - 1]);
}

/// Everything that a curve does within [begin, end].
Range range_within(const Path& path, double begin, double end) {
  Range range;
  range.add(value_at(path, begin));
  range.add(value_at(path, end));
  const auto first = std::ranges::lower_bound(path.x, begin);
  for (auto at = first; at != path.x.end() && *at <= end; ++at) {
    range.add(path.y[static_cast<std::size_t>(std::distance(path.x.begin(), at))]);
  }
  return range;
}

Excess excess_over(const Path& path, const Path& other, double half_width) {
  Excess largest;
  for (std::size_t n = 0; n < path.x.size(); ++n) {
    const double x = path.x[n];
    const bool beyond = x < other.x.front() - half_width || x > other.x.back() + half_width;
    const Range range = range_within(other, x - half_width, x + half_width);
    const double y = beyond ? std::numeric_limits<double>::infinity()
                            : std::max({range.least - path.y[n], path.y[n] - range.greatest, 0.0});
    if (y > largest.y) { largest = {.y = y, .x = x}; }
  }
  return largest;
}

}  // namespace

Excess largest_excess(const Path& before, const Path& now, double half_width_x) {
  const Excess out = excess_over(now, before, half_width_x);
  const Excess missing = excess_over(before, now, half_width_x);
  return out.y >= missing.y ? out : missing;
}

}  // namespace palpate::gate
