// SPDX-License-Identifier: MIT
#pragma once
/// Random numbers that are identical on every machine.

#include <Eigen/Core>
#include <cstdint>
#include <random>

namespace palpate {

/// Generator of uniform random numbers in [low, high) that are identical on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : bits_(seed) {}
  double operator()(double low, double high) {
    return low + (high - low) * static_cast<double>(bits_() >> 11) * 0x1p-53;
  }
  Eigen::VectorXd vector(Eigen::Index size, double amplitude) {
    Eigen::VectorXd values(size);
    for (double& value : values) { value = (*this)(-amplitude, amplitude); }
    return values;
  }

 private:
  std::mt19937_64 bits_;
};

}  // namespace palpate
