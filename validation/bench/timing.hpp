// SPDX-License-Identifier: MIT
#pragma once
/// Run times that can be compared on a noisy machine: all contenders alternate, round by round, in
/// random order.

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace palpate::bench {

/// Clock of a measurement. Processor time is that of the calling thread only, so multi-threaded
/// work needs the wall clock.
enum class Clock { processor, wall };

double seconds_on(Clock clock);  ///< since an arbitrary instant [s]

/// Work that is timed; `repeat(n)` does it n times.
struct Contender {
  std::string name{};
  std::function<void(long)> repeat{};
  Clock clock = Clock::processor;
  /// Called before and after each batch, outside the measured time. Spinning threads must stop
  /// while others are timed. Empty: nothing.
  std::function<void()> begin{};
  std::function<void()> end{};
};

/// Time of one repetition [s].
struct Timed {
  std::string name{};
  double least = 0.0;
  double median = 0.0;
};

struct TimingPlan {
  int rounds = 11;
  double batch = 0.02;     ///< shortest duration of a batch [s]; 0: one repetition, without warm-up
  std::uint64_t seed = 1;  ///< seed of the order
};

/// Times all contenders and returns the results in their order.
std::vector<Timed> time_interleaved(const std::vector<Contender>& contenders,
                                    const TimingPlan& plan = {});

}  // namespace palpate::bench

namespace palpate::timing {

// Statistics of two builds timed alternately in one process.

/// Distribution-free confidence limits of the median from order statistics (Conover, Practical
/// Nonparametric Statistics, 3.2): the k-th smallest of n is a lower limit with confidence 1 -
/// P(Bin(n, 1/2) < k).
struct MedianLimits {
  double median = 0.0;
  double lower = 0.0;  ///< one-sided; minus infinity if there are too few values
  double upper = 0.0;  ///< likewise
};
MedianLimits median_limits(std::vector<double> values, double confidence);

/// One batch of ticks by each build, consecutively and in random order [s].
struct Pair {
  double base = 0.0;       ///< processor time of the thread, without other work of the machine
  double head = 0.0;       ///< likewise
  double base_wall = 0.0;  ///< wall time, used for deadlines
  double head_wall = 0.0;
};

/// Pairs of one process; the next process loads the libraries in the other order.
struct PairedStart {
  std::vector<Pair> pairs{};
  double batch_deadline = 0.0;  ///< real-time duration of a batch [s]
};

/// Largest ratio of times that is allowed; the comparison must detect larger ones.
inline constexpr double allowed_slowdown = 1.03;
inline constexpr double paired_confidence = 0.99;
/// Largest number of interim analyses if the result is undecided. Each uses a confidence adjusted
/// for all of them (Bonferroni).
inline constexpr int most_looks = 4;
inline constexpr double look_confidence = 1.0 - (1.0 - paired_confidence) / most_looks;

struct PairedVerdict {
  double ratio = 0.0;  ///< median ratio of head to base
  double lower = 0.0;  ///< one-sided, look_confidence
  double upper = 0.0;
  long pairs = 0;
  long base_misses = 0;  ///< batches slower than real time
  long head_misses = 0;

  [[nodiscard]] bool slower() const { return !(lower <= allowed_slowdown); }
  [[nodiscard]] bool decided() const { return slower() || upper <= allowed_slowdown; }
  /// Returns true if the head misses significantly more deadlines: with equal rates, a split as
  /// uneven occurs in at most one of a hundred comparisons.
  [[nodiscard]] bool misses_rose() const;
};

PairedVerdict judge_pairs(std::span<const PairedStart> starts);

/// Calls measure(0), measure(1), ...: `starts` times, and again as many while undecided, at most
/// most_looks times.
std::vector<PairedStart> starts_until_decided(int starts,
                                              const std::function<PairedStart(int)>& measure);

// Detection of slow changes that no single comparison shows: a series of runs with a change of
// level.

/// Change point of a series and its p-value: Pettitt, Applied Statistics 28 (1979), K = max |sum of
/// sign(x_j - x_i), i <= t < j|, p = 2 exp(-6 K^2 / (n^3 + n^2)), which is conservative for few
/// values. Only ranks are used, so no noise model is needed.
struct ChangePoint {
  std::size_t at = 0;   ///< first value of the new level
  double chance = 1.0;  ///< p, at most 1
  double before = 0.0;  ///< median
  double after = 0.0;   ///< median
};
/// Finds the most likely change point; absent for fewer than two values.
std::optional<ChangePoint> find_change(std::span<const double> values);

/// Series of runs, oldest first.
struct Trend {
  std::string name{};
  std::string unit{};
  std::vector<double> values{};
  std::optional<ChangePoint> change{};
  bool crept = false;
};

/// Probability of at least one false alarm in all series together without a change (Holm,
/// Scandinavian Journal of Statistics 6, 1979).
inline constexpr double false_alarm_rate = 0.01;
/// Smallest relevant changes; they are larger than a single comparison accepts. Digits are compared
/// by difference.
inline constexpr double least_growth = 1.01;
inline constexpr double least_loss_of_digits = 0.1;

/// Computes the changes and marks those that are significant, relevant and for the worse: larger
/// counts or fewer digits.
void find_creep(std::vector<Trend>& trends);

}  // namespace palpate::timing
