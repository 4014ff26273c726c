// SPDX-License-Identifier: MIT
#pragma once
/// Variation that is the same on every machine for one seed: the standard fixes the bits of
/// mt19937_64 but not those of its distributions.

#include <cstdint>
#include <random>

namespace palpate::device {

class Seeded {
 public:
  explicit Seeded(std::uint64_t seed) : engine_(seed) {}
  /// Uniform in [low, high).
  double uniform(double low, double high) {
    constexpr double unit = 0x1p-53;
    return low + (high - low) * (static_cast<double>(engine_() >> 11U) * unit);
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace palpate::device
