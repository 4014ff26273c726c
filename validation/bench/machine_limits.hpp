// SPDX-License-Identifier: MIT
#pragma once
/// What this machine allows, measured beside what is judged by it.

#include <vector>

#include "validation/bench/interleaved.hpp"

namespace palpate::bench {

/// A square root and a division for every number, with the instructions that kernels of lattices use: no
/// spring can cost less. Buffers stay in the first cache; one repetition goes through `count` numbers.
template <class Real>
class RootsAndQuotients {
 public:
  static constexpr long count = 2048;
  RootsAndQuotients();
  void repeat(long times);

 private:
  std::vector<Real> from_;
  std::vector<Real> to_;
};

/// a = b + c x over vectors far larger than any cache.
class Triad {
 public:
  static constexpr std::size_t count = 6'000'000;       ///< of each of three vectors of doubles
  static constexpr double bytes = 3.0 * 8.0 * count;    ///< moved in one repetition
  Triad();
  void repeat(long times);

 private:
  std::vector<double> a_, b_, c_;
};

}  // namespace palpate::bench
