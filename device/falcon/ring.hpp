// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>

namespace palpate::device::falcon {

/// First in, first out, of at most `capacity` items; never allocates.
template <class Item, std::size_t capacity>
class Ring {
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
