// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace palpate::device::falcon {

/// First in, first out, of at most `capacity` items; never allocates.
template <class Item, std::size_t capacity> class Ring {
 public:
  /// False, and nothing done, when it is full.
  bool push(const Item& item) noexcept {
    if (count_ == capacity) { return false; }
    items_[(first_ + count_++) % capacity] = item;
    return true;
  }
  void pop() noexcept {
    first_ = (first_ + 1) % capacity;
    --count_;
  }
  [[nodiscard]] const Item& front() const noexcept { return items_[first_]; }
  [[nodiscard]] std::size_t size() const noexcept { return count_; }
  [[nodiscard]] bool empty() const noexcept { return count_ == 0; }

 private:
  std::array<Item, capacity> items_{};
  std::size_t first_ = 0;
  std::size_t count_ = 0;
};

}  // namespace palpate::device::falcon

namespace palpate::device {

// From one thread to one other without waiting: neither side locks, allocates, loops or calls the
// operating system, whatever the other side does or leaves half done.

/// First in, first out, of at most `capacity` items, a power of two.
template <class Item, std::size_t capacity> class HandoverQueue {
  static_assert((capacity & (capacity - 1)) == 0 && std::atomic<std::size_t>::is_always_lock_free);

 public:
  /// The producer's. False, and nothing done, when it is full.
  bool push(const Item& item) noexcept {
    const std::size_t end = end_.load(std::memory_order_relaxed);
    if (end - begin_.load(std::memory_order_acquire) == capacity) { return false; }
    items_[end % capacity] = item;
    end_.store(end + 1, std::memory_order_release);
    return true;
  }
  /// The consumer's. Nothing when it is empty.
  std::optional<Item> pop() noexcept {
    const std::size_t begin = begin_.load(std::memory_order_relaxed);
    if (begin == end_.load(std::memory_order_acquire)) { return std::nullopt; }
    const Item item = items_[begin % capacity];
    begin_.store(begin + 1, std::memory_order_release);
    return item;
  }

 private:
  static constexpr std::size_t cache_line = 64;
  std::array<Item, capacity> items_{};
  alignas(cache_line) std::atomic<std::size_t> begin_{0};  ///< counted on without wrapping
  alignas(cache_line) std::atomic<std::size_t> end_{0};
};

/// The newest value alone: three places, of which the producer fills one, the consumer reads one
/// and the third changes hands.
template <class Item> class LatestValue {
  static_assert(std::atomic<std::uint8_t>::is_always_lock_free);

 public:
  /// The producer's.
  void set(const Item& item) noexcept {
    places_[back_] = item;
    back_ = between_.exchange(static_cast<std::uint8_t>(back_ | fresh), std::memory_order_acq_rel) &
            place_mask;
  }
  /// The consumer's. The default value before anything was set.
  const Item& get() noexcept {
    if ((between_.load(std::memory_order_relaxed) & fresh) != 0) {
      front_ = between_.exchange(front_, std::memory_order_acq_rel) & place_mask;
    }
    return places_[front_];
  }

 private:
  static constexpr std::uint8_t fresh = 4;
  static constexpr std::uint8_t place_mask = 3;
  std::array<Item, 3> places_{};
  std::uint8_t front_ = 0;
  std::uint8_t back_ = 1;
  std::atomic<std::uint8_t> between_{2};
};

}  // namespace palpate::device
