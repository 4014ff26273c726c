// SPDX-License-Identifier: MIT
#pragma once
/// Run times that can be compared on a noisy machine: all contenders in turn, round after round, in an order
/// of chance.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace palpate::bench {

/// Processor time is that of the calling thread alone: work that is shared out needs the wall clock.
enum class Clock { processor, wall };

double seconds_on(Clock clock);  ///< since some instant [s]

/// One thing that is timed; `repeat(n)` does it n times.
struct Contender {
  std::string name{};
  std::function<void(long)> repeat{};
  Clock clock = Clock::processor;
  /// Before and after each batch, outside the time: threads that wait by looking must not while others are
  /// timed. Empty: nothing.
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
  double batch = 0.02;     ///< [s] that one batch takes at least; 0: once, and never before the rounds
  std::uint64_t seed = 1;  ///< of the order
};

/// In the order of the contenders.
std::vector<Timed> time_interleaved(const std::vector<Contender>& contenders, const TimingPlan& plan = {});

}  // namespace palpate::bench
