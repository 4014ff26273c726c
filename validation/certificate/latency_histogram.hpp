// SPDX-License-Identifier: MIT
#pragma once
/// Times in bins of 1 us: the memory of a day is that of a second. After construction nothing is allocated.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace palpate::certificate {

class LatencyHistogram {
 public:
  static constexpr double bin_width = 1e-6;         ///< [s]
  static constexpr std::size_t bin_count = 100000;  ///< the last one holds all from 0.1 s on

  LatencyHistogram() : counts_(bin_count, 0) {}

  void add(double seconds) noexcept;

  [[nodiscard]] long count() const { return count_; }
  [[nodiscard]] double minimum() const { return minimum_; }  ///< [s]; 0 without any
  [[nodiscard]] double maximum() const { return maximum_; }  ///< [s]; 0 without any
  [[nodiscard]] std::span<const std::uint32_t> counts() const { return counts_; }
  /// Bins up to the last one that holds any.
  [[nodiscard]] std::size_t used_bins() const;
  /// The time [s] that this share of all does not exceed: the end of the bin of the ordered sample at
  /// ceil(share n), so up to 1 us too long and never too short; beyond the bins the maximum. Nothing where no
  /// sample lies above it, that is, where fewer than 1 / (1 - share) are there.
  [[nodiscard]] std::optional<double> percentile(double share) const;

 private:
  std::vector<std::uint32_t> counts_;
  long count_ = 0;
  double minimum_ = 0.0;
  double maximum_ = 0.0;
};

}  // namespace palpate::certificate
