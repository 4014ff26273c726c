// SPDX-License-Identifier: MIT
#pragma once
/// Run times that can be compared on a noisy machine: all contenders in turn, round after round, in an order
/// of chance, by the processor time of the thread.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace palpate::bench {

/// One thing that is timed; `repeat(n)` does it n times.
struct Contender {
  std::string name{};
  std::function<void(long)> repeat{};
};

/// [s] for one time.
struct Timed {
  std::string name{};
  double least = 0.0;
  double median = 0.0;
};

struct TimingPlan {
  int rounds = 11;
  double batch = 0.02;      ///< [s] that one batch takes at least
  std::uint64_t seed = 1;   ///< of the order
};

/// Of this thread, since some instant [s].
double processor_seconds();

/// In the order of the contenders.
std::vector<Timed> time_interleaved(const std::vector<Contender>& contenders, const TimingPlan& plan = {});

}  // namespace palpate::bench
