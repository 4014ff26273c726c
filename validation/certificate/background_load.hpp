// SPDX-License-Identifier: MIT
#pragma once
/// Background load during a measurement: threads of ordinary priority that run one kind of work
/// continuously in memory of fixed size.

#include <atomic>
#include <cstddef>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace palpate::certificate {

/// "idle", "cpu", "cache", "memory".
bool is_own_load(std::string_view name);
inline constexpr std::string_view own_loads = "idle, cpu, cache, memory";

class BackgroundLoad {
 public:
  /// Starts one thread pinned to each of these processors. `cache_bytes` is the size of the largest
  /// cache.
  BackgroundLoad(std::string_view name, const std::vector<int>& processors,
                 std::size_t cache_bytes);
  ~BackgroundLoad();
  BackgroundLoad(const BackgroundLoad&) = delete;
  BackgroundLoad& operator=(const BackgroundLoad&) = delete;

  [[nodiscard]] std::size_t threads() const { return threads_.size(); }
  /// Returns the number of rounds that all threads have completed.
  [[nodiscard]] long rounds() const { return rounds_.load(std::memory_order_relaxed); }

 private:
  std::atomic<bool> stop_{false};
  std::atomic<long> rounds_{0};
  std::vector<std::thread> threads_{};
};

}  // namespace palpate::certificate
