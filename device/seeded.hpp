// SPDX-License-Identifier: MIT
#pragma once
/// Random numbers that are equal on every machine for one seed. The standard defines the bits of
/// mt19937_64 but not those of its distributions.

#include <cstdint>
#include <random>

namespace palpate::device {

class Seeded {
 public:
  explicit Seeded(std::uint64_t seed) : engine_(seed) {}
  /// Returns a uniform random number in [low, high), with 53 bits.
  double uniform(double low = 0.0, double high = 1.0) {
    constexpr double unit = 0x1p-53;
    return low + (high - low) * (static_cast<double>(engine_() >> 11U) * unit);
  }
  /// Returns an approximately normal random number, mean 0, SD 1: the sum of twelve uniform numbers
  /// (Irwin-Hall). It avoids a logarithm that libraries may round differently.
  double normal() {
    constexpr int terms = 12;  // each of variance 1/12
    double sum = 0.0;
    for (int n = 0; n < terms; ++n) { sum += uniform(-0.5, 0.5); }
    return sum;
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace palpate::device
