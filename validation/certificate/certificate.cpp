// SPDX-License-Identifier: MIT
#include "validation/certificate/certificate.hpp"

#include <algorithm>
#include <cmath>

#include "validation/certificate/miss_bound.hpp"

namespace palpate::certificate {

long Claim::ticks() const { return std::max(1L, std::lround(duration * rate)); }

double LoadResult::miss_probability_upper() const {
  return certificate::miss_probability_upper(scene.record.misses.count(), scene.record.ticks());
}

const LoadResult* Certificate::worst() const {
  const auto found = std::ranges::max_element(loads, {}, &LoadResult::miss_probability_upper);
  return found == loads.end() ? nullptr : &*found;
}

}  // namespace palpate::certificate
