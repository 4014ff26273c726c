// SPDX-License-Identifier: MIT

#include "validation/certificate/background_load.hpp"

#include <cmath>
#include <cstdint>

#include "device/real_time.hpp"

namespace palpate::certificate {

namespace {

constexpr std::size_t line = 8;  // doubles per cache line

void compute() noexcept {
  volatile double result = 2.0;
  for (int n = 0; n < 100000; ++n) { result = std::sqrt(result + 1.0); }
}

/// Accesses one number per cache line in an order that hardware prefetchers cannot predict.
void walk(std::vector<double>& buffer) noexcept {
  std::uint64_t place = 1;
  for (int n = 0; n < 100000; ++n) {
    place = place * 6364136223846793005U + 1442695040888963407U;
    buffer[((place >> 33U) * line) % buffer.size()] += 1.0;
  }
}

void stream(std::vector<double>& buffer, const std::atomic<bool>& stop) noexcept {
  const std::size_t half = buffer.size() / 2;
  for (std::size_t n = 0; n < half && !stop.load(std::memory_order_relaxed); ++n) {
    buffer[n] = 0.5 * buffer[n] + buffer[half + n];
  }
}

}  // namespace

bool is_own_load(std::string_view name) {
  return name == "idle" || name == "cpu" || name == "cache" || name == "memory";
}

BackgroundLoad::BackgroundLoad(std::string_view name, const std::vector<int>& processors,
                               std::size_t cache_bytes) {
  if (name == "idle") { return; }
  const std::size_t bytes = name == "memory" ? 4 * cache_bytes : cache_bytes;
  for (std::size_t n = 0; n < processors.size(); ++n) {
    threads_.emplace_back([this, name = std::string(name), processors, bytes] {
      device::pin_to(processors);
      std::vector<double> buffer(name == "cpu" ? 0 : bytes / sizeof(double), 1.0);
      while (!stop_.load(std::memory_order_relaxed)) {
        name == "cpu" ? compute() : name == "cache" ? walk(buffer) : stream(buffer, stop_);
        rounds_.fetch_add(1, std::memory_order_relaxed);
      }
    });
  }
}

BackgroundLoad::~BackgroundLoad() {
  stop_ = true;
  for (std::thread& thread : threads_) { thread.join(); }
}

}  // namespace palpate::certificate
