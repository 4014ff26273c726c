// SPDX-License-Identifier: MIT
#include "validation/certificate/latency_histogram.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::certificate {

void LatencyHistogram::add(double seconds) noexcept {
  constexpr auto last = static_cast<double>(bin_count - 1);
  const double place = seconds / bin_width;
  const double bin = place < last ? std::max(place, 0.0) : last;  // what is no number is last
  ++counts_[static_cast<std::size_t>(bin)];
  minimum_ = count_ == 0 ? seconds : std::min(minimum_, seconds);
  maximum_ = count_ == 0 ? seconds : std::max(maximum_, seconds);
  ++count_;
}

std::size_t LatencyHistogram::used_bins() const {
  const auto last = std::find_if(counts_.rbegin(), counts_.rend(), [](std::uint32_t n) { return n > 0; });
  return static_cast<std::size_t>(counts_.rend() - last);
}

std::optional<double> LatencyHistogram::percentile(double share) const {
  constexpr double rounding = 1e-9;  // of share n, which may be a whole number
  const double rank = std::ceil(share * static_cast<double>(count_) - rounding);
  if (count_ == 0 || !(rank < static_cast<double>(count_))) { return {}; }
  double below = 0.0;
  for (std::size_t bin = 0; bin + 1 < bin_count; ++bin) {
    below += counts_[bin];
    if (below >= rank) { return std::min(static_cast<double>(bin + 1) * bin_width, maximum_); }
  }
  return maximum_;
}

}  // namespace palpate::certificate
