// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace palpate::device::falcon {

/// First-in first-out queue of at most `capacity` items, for one thread; never allocates.
template <class Item, std::size_t capacity> class Ring {
 public:
  /// Returns false and does nothing if the queue is full.
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

// Lock-free transfer of data between two threads. Neither side allocates, loops or makes a system
// call.

/// Single-producer single-consumer queue of at most `capacity` items; `capacity` is a power of two.
template <class Item, std::size_t capacity> class HandoverQueue {
  static_assert((capacity & (capacity - 1)) == 0 && std::atomic<std::size_t>::is_always_lock_free);

 public:
  /// Adds an item; called by the producer only. Returns false and does nothing if the queue is
  /// full.
  bool push(const Item& item) noexcept {
    const std::size_t end = end_.load(std::memory_order_relaxed);
    if (end - begin_.load(std::memory_order_acquire) == capacity) { return false; }
    items_[end % capacity] = item;
    end_.store(end + 1, std::memory_order_release);
    return true;
  }
  /// Removes the oldest item; called by the consumer only. Returns nothing if the queue is empty.
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
  alignas(cache_line) std::atomic<std::size_t> begin_{0};  ///< items removed; does not wrap
  alignas(cache_line) std::atomic<std::size_t> end_{0};
};

/// Triple buffer that passes only the newest value from one producer to one consumer.
template <class Item> class LatestValue {
  static_assert(std::atomic<std::uint8_t>::is_always_lock_free);

 public:
  /// Stores a new value; called by the producer only.
  void set(const Item& item) noexcept {
    places_[back_] = item;
    back_ = between_.exchange(static_cast<std::uint8_t>(back_ | fresh), std::memory_order_acq_rel) &
            place_mask;
  }
  /// Returns the newest value; called by the consumer only. Returns the default before the first
  /// set().
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
