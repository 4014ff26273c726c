// SPDX-License-Identifier: MIT
#pragma once
/// The kernels that are timed: S26 of n nodes a side (bench_cases.hpp), stepped in every way there is.

#include <memory>
#include <span>

#include "model/dynamics/scene.hpp"
#include "validation/bench/interleaved.hpp"

namespace palpate::bench {

struct KernelVariant {
  const char* name = "";
  Precision precision = Precision::double_precision;
  bool lattice = true;  ///< else the same springs in a list
  bool uneven = false;  ///< stiffness of its own for every spring
  bool damped = true;
  int threads = 1;
  const char* instructions = nullptr;  ///< lattice::Kernels::name of a lattice; nullptr: the best here

  [[nodiscard]] bool in_double() const { return precision == Precision::double_precision; }
};

/// One thread, all that differs otherwise.
std::span<const KernelVariant> kernel_variants();

/// Those that memory may hold back, for the largest size.
std::span<const KernelVariant> largest_variants();

/// Semi-implicit Euler with 1 ms, step after step, without what a Simulation knows besides: bounds of the
/// spectrum alone take minutes for a million nodes.
class Stepping {
 public:
  virtual ~Stepping() = default;
  virtual void step(long times) = 0;
  [[nodiscard]] virtual double springs() const = 0;  ///< that are computed
};
std::unique_ptr<Stepping> stepping_of(const KernelVariant& variant, int n);

/// Adds a spring that no lattice has, so weak that it changes nothing: the network goes through its list.
void break_lattice(SpringNetwork& network);

/// What a step in one pass cannot do without, from its layout (lattice_view.hpp): of each node position and
/// velocity, read and written, the inverse mass, read, and the constants of its springs where no two rows share
/// them [bytes]. Forces are kept for two layers at a time and stay in the cache.
double bytes_moved(const KernelVariant& variant, int n);

/// All that a step touches [bytes].
double working_set(const KernelVariant& variant, int n);

}  // namespace palpate::bench
