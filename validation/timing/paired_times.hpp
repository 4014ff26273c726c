// SPDX-License-Identifier: MIT
#pragma once
/// Two builds timed in turn in one process: what the pairs say of their ratio, whatever else the machine does.

#include <functional>
#include <span>
#include <vector>

namespace palpate::timing {

/// Of the median of a distribution of any shape, from order statistics (Conover, Practical Nonparametric
/// Statistics, 3.2): the k-th smallest of n is a lower limit with confidence 1 - P(Bin(n, 1/2) < k).
struct MedianLimits {
  double median = 0.0;
  double lower = 0.0;  ///< one-sided; minus infinity where so few values support none
  double upper = 0.0;  ///< likewise
};
MedianLimits median_limits(std::vector<double> values, double confidence);

/// One batch of ticks by each build, one right after the other, in an order of chance [s].
struct Pair {
  double base = 0.0;       ///< processor time of the thread: whoever else runs meanwhile is not charged to a build
  double head = 0.0;       ///< likewise
  double base_wall = 0.0;  ///< by the wall clock, which deadlines go by
  double head_wall = 0.0;
};

/// The pairs of one process; the next one loads the libraries in the other order.
struct PairedStart {
  std::vector<Pair> pairs{};
  double batch_deadline = 0.0;  ///< what a batch may take in real time [s]
};

/// A share of this much is what the clock is asked to see.
inline constexpr double allowed_slowdown = 1.03;
inline constexpr double paired_confidence = 0.99;
/// What a busy machine leaves open is measured on: the limits are looked at so many times at most, each time with a
/// confidence that leaves as much to all looks together (Bonferroni).
inline constexpr int most_looks = 4;
inline constexpr double look_confidence = 1.0 - (1.0 - paired_confidence) / most_looks;

struct PairedVerdict {
  double ratio = 0.0;  ///< head over base, median
  double lower = 0.0;  ///< one-sided, look_confidence
  double upper = 0.0;
  long pairs = 0;
  long base_misses = 0;  ///< batches that took longer than in real time
  long head_misses = 0;

  [[nodiscard]] bool slower() const { return !(lower <= allowed_slowdown); }
  [[nodiscard]] bool decided() const { return slower() || upper <= allowed_slowdown; }
  /// More by more than chance: with as many of each, so uneven a split comes once in a hundred times at most.
  [[nodiscard]] bool misses_rose() const;
};

PairedVerdict judge_pairs(std::span<const PairedStart> starts);

/// measure(0), measure(1), ...: `starts` of them, and as many again while they decide nothing, most_looks times at most.
std::vector<PairedStart> starts_until_decided(int starts, const std::function<PairedStart(int)>& measure);

}  // namespace palpate::timing
