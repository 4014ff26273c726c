// SPDX-License-Identifier: MIT

#include "reports/plot/thinning.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

namespace palpate {

namespace {

bool is_gap(const Pixel& at) { return !std::isfinite(at.x) || !std::isfinite(at.y); }

/// First, lowest, highest and last sample of every pixel column, for a curve or a filled series.
std::vector<std::size_t> envelope(const Series& series, std::size_t count,
                                  const Projection& project) {
  std::vector<std::size_t> kept;
  std::array<std::size_t, 4> picks{};
  double column = 0.0, lowest = 0.0, highest = 0.0;
  bool open = false;
  bool gap = false;
  const auto close = [&] {
    if (!open) { return; }
    std::ranges::sort(picks);
    const auto last = std::ranges::unique(picks).begin();
    kept.insert(kept.end(), picks.begin(), last);
    open = false;
  };
  for (std::size_t n = 0; n < count; ++n) {
    const Pixel low = project(series.x[n], series.y[n]);
    const Pixel high = series.filled() ? project(series.x[n], series.y2[n]) : low;
    if (is_gap(low) || is_gap(high)) {
      close();
      if (!gap) { kept.push_back(n); }
      gap = true;
      continue;
    }
    gap = false;
    if (!open || std::floor(low.x) != column) {
      close();
      open = true;
      column = std::floor(low.x);
      picks = {n, n, n, n};
      lowest = low.y;
      highest = high.y;
    }
    if (low.y < lowest) { lowest = low.y, picks[1] = n; }
    if (high.y > highest) { highest = high.y, picks[2] = n; }
    picks[3] = n;
  }
  close();
  return kept;
}

/// Samples of a path that move by half a pixel.
std::vector<std::size_t> moving(const Series& series, std::size_t count,
                                const Projection& project) {
  std::vector<std::size_t> kept;
  Pixel last{std::nan(""), std::nan("")};
  for (std::size_t n = 0; n < count; ++n) {
    const Pixel at = project(series.x[n], series.y[n]);
    const bool again = is_gap(at) ? n > 0 && is_gap(last)
                                  : n + 1 < count && std::hypot(at.x - last.x, at.y - last.y) < 0.5;
    if (again) { continue; }
    kept.push_back(n);
    last = at;
  }
  return kept;
}

}  // namespace

std::vector<std::size_t> thinned(const Series& series, const Projection& project) {
  std::size_t count = std::min(series.x.size(), series.y.size());
  if (series.filled()) { count = std::min(count, series.y2.size()); }
  if (series.style != Series::Style::points) {
    const bool rises = std::ranges::is_sorted(series.x);
    return series.filled() || rises ? envelope(series, count, project)
                                    : moving(series, count, project);
  }
  std::vector<std::size_t> kept;
  std::set<std::pair<long, long>> covered;
  for (std::size_t n = 0; n < count; ++n) {
    const Pixel at = project(series.x[n], series.y[n]);
    if (is_gap(at)) { continue; }
    if (covered.emplace(std::lround(at.x), std::lround(at.y)).second) { kept.push_back(n); }
  }
  return kept;
}

}  // namespace palpate
