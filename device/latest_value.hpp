// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace palpate::device {

/// Triple buffer that passes only the newest value from one producer to one consumer. Neither side
/// waits, and both sides work in place.
template <class Item> class LatestValue {
  static_assert(std::atomic<std::uint8_t>::is_always_lock_free);

 public:
  LatestValue() = default;
  /// Fills all three places, so that later values of the same size need no memory.
  explicit LatestValue(const Item& item) : places_{item, item, item} {}

  /// Place that the producer may write. Its old content is that of an earlier value.
  [[nodiscard]] Item& back() noexcept { return places_[back_]; }
  /// Makes back() the newest value; called by the producer only.
  void publish() noexcept {
    back_ = between_.exchange(static_cast<std::uint8_t>(back_ | fresh), std::memory_order_acq_rel) &
            place_mask;
  }
  /// Stores a new value; called by the producer only.
  void set(const Item& item) noexcept {
    back() = item;
    publish();
  }

  /// Moves to the newest value; called by the consumer only. Returns false if there is no newer
  /// one.
  bool update() noexcept {
    if ((between_.load(std::memory_order_relaxed) & fresh) == 0) { return false; }
    front_ = between_.exchange(front_, std::memory_order_acq_rel) & place_mask;
    return true;
  }
  /// The value of the last update(), which no producer changes; called by the consumer only.
  [[nodiscard]] const Item& front() const noexcept { return places_[front_]; }
  /// Returns the newest value; called by the consumer only. Returns the initial one before the
  /// first set().
  const Item& get() noexcept {
    update();
    return front();
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
