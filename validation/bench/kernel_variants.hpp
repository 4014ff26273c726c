// SPDX-License-Identifier: MIT
#pragma once
/// The kernels that are timed: S26 of n nodes a side (bench_cases.hpp), stepped in every way there
/// is.

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "model/problem/scene.hpp"
#include "validation/bench/timing.hpp"

namespace palpate::bench {

struct KernelVariant {
  const char* name = "";
  Precision precision = Precision::double_precision;
  bool lattice = true;  ///< else the same springs in a list
  bool uneven = false;  ///< stiffness of its own for every spring
  bool damped = true;
  int threads = 1;
  const char* instructions =
      nullptr;  ///< lattice::Kernels::name of a lattice; nullptr: the best here

  [[nodiscard]] bool in_double() const { return precision == Precision::double_precision; }
};

/// One thread, all that differs otherwise.
std::span<const KernelVariant> kernel_variants();

/// Those that memory may hold back, for the largest size.
std::span<const KernelVariant> largest_variants();

/// Semi-implicit Euler with 1 ms, step after step, without what a Simulation knows besides: bounds
/// of the spectrum alone take minutes for a million nodes.
class Stepping {
 public:
  virtual ~Stepping() = default;
  virtual void step(long times) = 0;
  [[nodiscard]] virtual double springs() const = 0;  ///< that are computed
};
std::unique_ptr<Stepping> stepping_of(const KernelVariant& variant, int n);

/// Adds a spring that no lattice has, so weak that it changes nothing: the network goes through its
/// list.
void break_lattice(SpringNetwork& network);

/// What a step in one pass cannot do without, from its layout (lattice_view.hpp): of each node
/// position and velocity, read and written, the inverse mass, read, and the constants of its
/// springs where no two rows share them [bytes]. Forces are kept for two layers at a time and stay
/// in the cache.
double bytes_moved(const KernelVariant& variant, int n);

/// All that a step touches [bytes].
double working_set(const KernelVariant& variant, int n);

// What this machine allows, measured beside what is judged by it.

/// A square root and a division for every number, with the instructions that kernels of lattices
/// use: no spring can cost less. Buffers stay in the first cache; one repetition goes through
/// `count` numbers.
template <class Real> class RootsAndQuotients {
 public:
  static constexpr long count = 2048;
  RootsAndQuotients();
  void repeat(long times);

 private:
  std::vector<Real> from_;
  std::vector<Real> to_;
};

/// a += x b: two numbers read and one written, the latter where it was read, so that nothing else
/// moves between processor and memory. The two vectors together have `bytes`, so that the bandwidth
/// is that of the cache or memory which a working set of that size lives in.
class VectorUpdate {
 public:
  explicit VectorUpdate(double bytes);
  void repeat(long times);
  [[nodiscard]] double bytes_moved() const;  ///< in one repetition

 private:
  std::vector<double> a_, b_;
};

/// How many times longer two threads take, each with work of its own, than the first alone: 1 on
/// two idle processors, 2 where both share one, and in between where memory holds them up. Median
/// of rounds, wall clock.
double side_by_side_slowdown(const std::function<void()>& mine, const std::function<void()>& other);

/// The same of roots and quotients, which need nothing but processors.
double side_by_side_slowdown();

}  // namespace palpate::bench
