// SPDX-License-Identifier: MIT
#pragma once
/// What `bench/kernels` shows.

#include <span>
#include <string>
#include <vector>

#include "validation/bench/kernel_variants.hpp"
#include "validation/outcome.hpp"

namespace palpate::bench {

/// Of a spring's square root and division alone [ns].
struct RootLimits {
  double in_double = 0.0;
  double in_float = 0.0;
};

/// One kernel at one size, all per spring and step.
struct KernelTime {
  const KernelVariant* variant = nullptr;
  double least = 0.0;      ///< [ns]
  double median = 0.0;     ///< [ns]
  double bytes = 0.0;      ///< that memory moves; lattices only
  double bandwidth = 0.0;  ///< [bytes/s] of a working set of that size; lattices only
  double root = 0.0;       ///< root and quotient [ns]

  [[nodiscard]] double memory() const { return 1e9 * bytes / bandwidth; }  ///< [ns]
  /// No step of a lattice can be quicker [ns].
  [[nodiscard]] double bound() const { return memory() > root ? memory() : root; }
};

/// "1.23", as times stand in tables and sentences.
std::string two_digits(double value);

struct KernelSize {
  int n = 0;
  std::vector<KernelTime> times{};  ///< in the order of kernel_variants(), those that were timed

  /// nullptr if it was not timed at this size.
  [[nodiscard]] const KernelTime* find(std::string_view name) const;
};

std::vector<Table> kernel_tables(std::span<const KernelSize> sizes, const RootLimits& limits);
std::vector<Figure> kernel_figures(std::span<const KernelSize> sizes, const RootLimits& limits);

}  // namespace palpate::bench
