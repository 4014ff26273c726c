// SPDX-License-Identifier: MIT
#pragma once
/// Values just outside and just inside every bound of a range, for tests of scene keys.

#include <cmath>
#include <vector>

#include "model/problem/scene_keys.hpp"

namespace palpate::test {

struct BoundValue {
  double value = 0.0;
  bool allowed = false;
};

inline std::vector<BoundValue> around_bounds(const Range& range, bool whole) {
  std::vector<BoundValue> values;
  for (const int only : range.only) {
    values.push_back({only - 1.0, false});
    values.push_back({double(only), true});
    values.push_back({only + 1.0, false});
  }
  // `outward` is -1 below the range and +1 above it.
  const auto bound = [&](double at, bool excluded, double outward) {
    if (!std::isfinite(at)) { return; }
    const double step = whole ? 1.0 : 1e-9 * std::max(std::abs(at), 1e-3);
    values.push_back({at + outward * step, false});
    values.push_back({at, !excluded});
    if (excluded) { values.push_back({at - outward * step, true}); }
  };
  bound(range.low, range.above_low, -1.0);
  bound(range.high, range.below_high, 1.0);
  return values;
}

}  // namespace palpate::test
