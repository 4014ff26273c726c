// SPDX-License-Identifier: MIT
#include "model/stepping/team.hpp"

#include "model/stepping/flushed_denormals.hpp"

namespace palpate {

namespace {
/// Looks without a task before a member lets others have the processor in between: about a millisecond.
constexpr long patience = 20000;
}  // namespace

Team::Team(int members) {
  for (int number = 1; number < members; ++number) {
    threads_.emplace_back([this, number] { serve(number); });
  }
}

Team::~Team() {
  round_.store(-1, std::memory_order_release);
  for (std::thread& thread : threads_) { thread.join(); }
}

void Team::run_call() noexcept {
  const long round = round_.load(std::memory_order_relaxed) + 1;
  round_.store(round, std::memory_order_release);
  call_(work_, 0);
  const long all = round * static_cast<long>(threads_.size());
  while (finished_.load(std::memory_order_acquire) < all) { relax(); }
}

void Team::serve(int number) noexcept {
  const FlushedDenormals flushed;  // as on the thread that calls
  for (long seen = 0;;) {
    long idle = 0;
    long round = seen;
    while ((round = round_.load(std::memory_order_acquire)) == seen) {
      relax();
      if (++idle > patience) { std::this_thread::yield(); }
    }
    if (round < 0) { return; }
    seen = round;
    call_(work_, number);
    finished_.fetch_add(1, std::memory_order_release);
  }
}

}  // namespace palpate
