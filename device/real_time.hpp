// SPDX-License-Identifier: MIT
#pragma once
/// What a thread needs to keep deadlines, and what the system grants of it: SCHED_FIFO, memory that stays, a
/// processor of its own. Nothing here fails: what is refused is told.

#include <string>
#include <vector>

namespace palpate::device {

/// Processors that this process may run on, ascending.
std::vector<int> allowed_processors();
/// The calling thread alone; false where the system refuses.
bool pin_to(int processor) noexcept;
bool pin_to(const std::vector<int>& processors) noexcept;
/// Touches the stack of the calling thread, so that a deeper call later finds it there.
void touch_stack() noexcept;

/// All memory of the process, present and future, stays where it is while this lives.
class LockedMemory {
 public:
  LockedMemory() noexcept;
  ~LockedMemory();
  LockedMemory(const LockedMemory&) = delete;
  LockedMemory& operator=(const LockedMemory&) = delete;
  [[nodiscard]] const std::string& refusal() const { return refusal_; }  ///< empty: granted

 private:
  std::string refusal_{};
};

/// The calling thread is scheduled first in, first out, while this lives.
class FifoScheduling {
 public:
  explicit FifoScheduling(int priority) noexcept;
  ~FifoScheduling();
  FifoScheduling(const FifoScheduling&) = delete;
  FifoScheduling& operator=(const FifoScheduling&) = delete;
  [[nodiscard]] int refusal() const { return refusal_; }  ///< errno; 0: granted

 private:
  int refusal_ = 0;
};

/// What the system has counted of the calling thread so far.
struct ThreadCounts {
  long minor_faults = 0;
  long major_faults = 0;          ///< that read a disk
  long voluntary_switches = 0;    ///< sleeps
  long involuntary_switches = 0;  ///< somebody else was let in
};
ThreadCounts thread_counts() noexcept;
ThreadCounts operator-(const ThreadCounts& a, const ThreadCounts& b) noexcept;
ThreadCounts& operator+=(ThreadCounts& a, const ThreadCounts& b) noexcept;

}  // namespace palpate::device
