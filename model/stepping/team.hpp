// SPDX-License-Identifier: MIT
#pragma once
/// Threads that do one task together again and again, a few microseconds at a time: they wait without sleeping,
/// so nothing in a tick locks or calls the system.

#include <atomic>
#include <thread>
#include <vector>

namespace palpate {

/// Tells the processor that a thread only waits.
inline void relax() noexcept {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

class Team {
 public:
  /// `members` with the caller, who is number 0.
  explicit Team(int members);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  [[nodiscard]] int members() const { return static_cast<int>(threads_.size()) + 1; }

  /// work(number) by every member at a time; returns when all have done theirs.
  template <class Work>
  void run(Work& work) noexcept {
    work_ = &work;
    call_ = [](void* what, int number) noexcept { (*static_cast<Work*>(what))(number); };
    run_call();
  }

 private:
  void run_call() noexcept;
  void serve(int number) noexcept;

  void* work_ = nullptr;
  void (*call_)(void* work, int number) noexcept = nullptr;
  std::atomic<long> round_{0};     ///< how many tasks were given; negative: go home
  std::atomic<long> finished_{0};  ///< by members other than the caller, of all rounds
  std::vector<std::thread> threads_;
};

}  // namespace palpate
