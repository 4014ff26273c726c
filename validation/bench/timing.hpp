// SPDX-License-Identifier: MIT
#pragma once
/// Run times that can be compared on a noisy machine: all contenders in turn, round after round, in
/// an order of chance.

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace palpate::bench {

/// Processor time is that of the calling thread alone: work that is shared out needs the wall
/// clock.
enum class Clock { processor, wall };

double seconds_on(Clock clock);  ///< since some instant [s]

/// One thing that is timed; `repeat(n)` does it n times.
struct Contender {
  std::string name{};
  std::function<void(long)> repeat{};
  Clock clock = Clock::processor;
  /// Before and after each batch, outside the time: threads that wait by looking must not while
  /// others are timed. Empty: nothing.
  std::function<void()> begin{};
  std::function<void()> end{};
};

/// [s] for one time.
struct Timed {
  std::string name{};
  double least = 0.0;
  double median = 0.0;
};

struct TimingPlan {
  int rounds = 11;
  double batch = 0.02;  ///< [s] that one batch takes at least; 0: once, and never before the rounds
  std::uint64_t seed = 1;  ///< of the order
};

/// In the order of the contenders.
std::vector<Timed> time_interleaved(const std::vector<Contender>& contenders,
                                    const TimingPlan& plan = {});

}  // namespace palpate::bench

namespace palpate::timing {

// Two builds timed in turn in one process: what the pairs say of their ratio, whatever else the
// machine does.

/// Of the median of a distribution of any shape, from order statistics (Conover, Practical
/// Nonparametric Statistics, 3.2): the k-th smallest of n is a lower limit with confidence 1 -
/// P(Bin(n, 1/2) < k).
struct MedianLimits {
  double median = 0.0;
  double lower = 0.0;  ///< one-sided; minus infinity where so few values support none
  double upper = 0.0;  ///< likewise
};
MedianLimits median_limits(std::vector<double> values, double confidence);

/// One batch of ticks by each build, one right after the other, in an order of chance [s].
struct Pair {
  double base =
      0.0;  ///< processor time of the thread: whoever else runs meanwhile is not charged to a build
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
/// What a busy machine leaves open is measured on: the limits are looked at so many times at most,
/// each time with a confidence that leaves as much to all looks together (Bonferroni).
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
  /// More by more than chance: with as many of each, so uneven a split comes once in a hundred
  /// times at most.
  [[nodiscard]] bool misses_rose() const;
};

PairedVerdict judge_pairs(std::span<const PairedStart> starts);

/// measure(0), measure(1), ...: `starts` of them, and as many again while they decide nothing,
/// most_looks times at most.
std::vector<PairedStart> starts_until_decided(int starts,
                                              const std::function<PairedStart(int)>& measure);

// Slow creep that no single comparison sees: a series of runs whose level has changed somewhere.

/// Where a series changes its level, and how seldom chance alone does as much: Pettitt, Applied
/// Statistics 28 (1979), K = max |sum of sign(x_j - x_i), i <= t < j|, p = 2 exp(-6 K^2 / (n^3 +
/// n^2)), which for few values says more than the true chance. Ranks alone count: no scale, no law
/// of the noise.
struct ChangePoint {
  std::size_t at = 0;   ///< first value of the new level
  double chance = 1.0;  ///< p, at most 1
  double before = 0.0;  ///< median
  double after = 0.0;   ///< median
};
/// Nothing for fewer than two values.
std::optional<ChangePoint> find_change(std::span<const double> values);

/// A series of runs, oldest first.
struct Trend {
  std::string name{};
  std::string unit{};
  std::vector<double> values{};
  std::optional<ChangePoint> change{};
  bool crept = false;
};

/// Chance of one false alarm or more in all series together, where nothing changes (Holm,
/// Scandinavian Journal of Statistics 6, 1979).
inline constexpr double false_alarm_rate = 0.01;
/// A change that matters: more than one comparison lets pass. Digits are told as they are.
inline constexpr double least_growth = 1.01;
inline constexpr double least_loss_of_digits = 0.1;

/// Fills in changes, and marks those that are no chance, no trifle, and for the worse: more of what
/// is counted, fewer digits.
void find_creep(std::vector<Trend>& trends);

}  // namespace palpate::timing
