// SPDX-License-Identifier: MIT
#pragma once
/// Kernels that are timed: S26 with n nodes a side (bench_cases.hpp), in all available variants.

#include <functional>
#include <span>

#include "model/problem/scene.hpp"
#include "validation/bench/timing.hpp"

namespace palpate::bench {

struct KernelVariant {
  const char* name = "";
  Precision precision = Precision::double_precision;
  bool lattice = true;  ///< false: the same springs in a list
  bool uneven = false;  ///< individual stiffness for every spring
  bool damped = true;
  int threads = 1;
  /// lattice::Kernels::name of a lattice; nullptr: the best on this processor
  const char* instructions = nullptr;

  [[nodiscard]] bool in_double() const { return precision == Precision::double_precision; }
};

/// Returns all variants with one thread.
std::span<const KernelVariant> kernel_variants();

/// Returns the variants that memory bandwidth may limit, for the largest size.
std::span<const KernelVariant> largest_variants();

/// Semi-implicit Euler with steps of 1 ms, without the setup of a Simulation: bounds of the
/// spectrum alone take minutes for a million nodes.
struct Stepping {
  std::function<void(long times)> step{};
  double springs = 0.0;  ///< computed in a step
};
Stepping stepping_of(const KernelVariant& variant, int n);

/// Adds a very weak spring that is not part of a regular lattice, so that the list kernel is used.
void break_lattice(SpringNetwork& network);

/// Returns the minimum memory traffic of a step in one pass from the layout (lattice_view.hpp)
/// [bytes]: per node, position, velocity and force read and written, inverse mass read, and spring
/// constants that rows do not share.
double bytes_moved(const KernelVariant& variant, int n);

/// Returns the size of all data that a step accesses [bytes].
double working_set(const KernelVariant& variant, int n);

// Limits of this machine, measured together with the kernels.

/// Returns work of one square root and one division per number, with the instructions of the
/// lattice kernels: a lower limit of the cost of a spring. Buffers stay in the first-level cache;
/// one repetition processes `roots_at_once` numbers.
template <class Real> std::function<void(long times)> roots_and_quotients();
inline constexpr long roots_at_once = 2048;

/// Returns work of the vector update a += x b: two numbers read and one written in place, without
/// other memory traffic. The two vectors together have `bytes`, so the bandwidth is that of the
/// cache or memory level for a working set of this size. One repetition moves 1.5 `bytes`.
std::function<void(long times)> vector_update(double bytes);

/// Returns the slowdown of a thread by a second thread with its own work: 1 on two idle processors,
/// 2 if both share one, in between if memory limits them. Median of rounds, wall clock.
double side_by_side_slowdown(const std::function<void()>& mine, const std::function<void()>& other);

/// Returns the same slowdown for roots and quotients, which do not use memory.
double side_by_side_slowdown();

}  // namespace palpate::bench
