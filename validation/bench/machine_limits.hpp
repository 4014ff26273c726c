// SPDX-License-Identifier: MIT
#pragma once
/// What this machine allows, measured beside what is judged by it.

#include <functional>
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

/// a += x b: two numbers read and one written, the latter where it was read, so that nothing else moves
/// between processor and memory. The two vectors together have `bytes`, so that the bandwidth is that of the
/// cache or memory which a working set of that size lives in.
class VectorUpdate {
 public:
  explicit VectorUpdate(double bytes);
  void repeat(long times);
  [[nodiscard]] double bytes_moved() const;  ///< in one repetition

 private:
  std::vector<double> a_, b_;
};

/// How many times longer two threads take, each with work of its own, than the first alone: 1 on two idle
/// processors, 2 where both share one, and in between where memory holds them up. Median of rounds, wall
/// clock.
double side_by_side_slowdown(const std::function<void()>& mine, const std::function<void()>& other);

/// The same of roots and quotients, which need nothing but processors.
double side_by_side_slowdown();

}  // namespace palpate::bench
