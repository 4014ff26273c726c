// SPDX-License-Identifier: MIT
#pragma once
/// Random numbers, vectors and orders that are identical on every machine.

#include <Eigen/Core>
#include <cstddef>
#include <utility>

#include "device/seeded.hpp"

namespace palpate {

/// Generator of uniform random numbers in [low, high).
class Random : public device::Seeded {
 public:
  using Seeded::Seeded;
  double operator()(double low, double high) { return uniform(low, high); }
  Eigen::VectorXd vector(Eigen::Index size, double amplitude) {
    Eigen::VectorXd values(size);
    for (double& value : values) { value = uniform(-amplitude, amplitude); }
    return values;
  }
  /// Puts the values into a random order (Fisher-Yates).
  template <class Values> void shuffle(Values& values) {
    for (std::size_t n = values.size(); n > 1; --n) {
      std::swap(values[n - 1],
                values[static_cast<std::size_t>(uniform(0.0, static_cast<double>(n)))]);
    }
  }
};

}  // namespace palpate
