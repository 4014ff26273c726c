// SPDX-License-Identifier: MIT
#pragma once
/// Triangular solves in supernodes for one instruction set (model/EQUATIONS.md, "Supernodes of a
/// factorisation"). One source file per instruction set includes this header. It must not include
/// functions that other files compile: the linker could keep a copy that needs another instruction
/// set.

#include <xsimd/xsimd.hpp>

#include "model/kernels/kernel_views.hpp"
#include "model/kernels/simd.hpp"

namespace palpate::supernodes {

template <class Arch> struct Lanes {
  using Batch = xsimd::batch<float, Arch>;
  static constexpr long count = static_cast<long>(Batch::size);
};

/// Adds tile * x to `sums`, one per row; the tile has `columns` columns. Two independent sums per
/// block shorten the dependency chain.
template <int columns, class Arch>
void add_rows(const float* values, long blocks, const float* x, float* sums) noexcept {
  using Batch = typename Lanes<Arch>::Batch;
  constexpr long lanes = Lanes<Arch>::count;
  Batch share[columns];
  for (int c = 0; c < columns; ++c) { share[c] = Batch(x[c]); }
  for (long b = 0; b < blocks; ++b, values += columns * lanes) {
    Batch even = Batch::load_unaligned(sums + b * lanes);
    Batch odd(0.0F);
    for (int c = 0; c < columns; c += 2) {
      even = fused::add(Batch::load_unaligned(values + c * lanes), share[c], even);
      if (c + 1 < columns) {
        odd = fused::add(Batch::load_unaligned(values + (c + 1) * lanes), share[c + 1], odd);
      }
    }
    (even + odd).store_unaligned(sums + b * lanes);
  }
}

/// Sets x to tile^T * `from`.
template <int columns, class Arch>
void sum_columns(const float* values, long blocks, const float* from, float* x) noexcept {
  using Batch = typename Lanes<Arch>::Batch;
  constexpr long lanes = Lanes<Arch>::count;
  Batch sums[columns];
  for (int c = 0; c < columns; ++c) { sums[c] = Batch(0.0F); }
  for (long b = 0; b < blocks; ++b, values += columns * lanes) {
    const Batch rows = Batch::load_unaligned(from + b * lanes);
    for (int c = 0; c < columns; ++c) {
      sums[c] = fused::add(Batch::load_unaligned(values + c * lanes), rows, sums[c]);
    }
  }
  for (int c = 0; c < columns; ++c) { x[c] = xsimd::hadd(sums[c]); }
}

using TileKernel = void (*)(const float* values, long blocks, const float* from,
                            float* to) noexcept;

/// Kernels by number of columns; index 0 is one column.
template <class Arch> struct Tiles {
  static constexpr TileKernel add[tile] = {
      &add_rows<1, Arch>, &add_rows<2, Arch>, &add_rows<3, Arch>, &add_rows<4, Arch>,
      &add_rows<5, Arch>, &add_rows<6, Arch>, &add_rows<7, Arch>, &add_rows<8, Arch>};
  static constexpr TileKernel sum[tile] = {
      &sum_columns<1, Arch>, &sum_columns<2, Arch>, &sum_columns<3, Arch>, &sum_columns<4, Arch>,
      &sum_columns<5, Arch>, &sum_columns<6, Arch>, &sum_columns<7, Arch>, &sum_columns<8, Arch>};
};

template <class Arch>
void forward(const View& view, const Supernode& supernode, float* y, float* work) noexcept {
  constexpr long lanes = Lanes<Arch>::count;
  for (long i = 0; i < supernode.blocks * lanes; ++i) { work[i] = 0.0F; }
  const float* values = view.values + supernode.values;
  float* x = y + supernode.first;
  for (int c = 0; c < supernode.width; c += tile) {
    const int columns = supernode.width - c < tile ? supernode.width - c : tile;
    Tiles<Arch>::add[columns - 1](values, supernode.blocks, x + c, work);
    values += static_cast<long>(columns) * supernode.blocks * lanes;
  }
  for (int i = 0; i < supernode.width; ++i) { x[i] = work[i]; }
  const int* rows = view.rows + supernode.rows;
  const float* below = work + supernode.width;
  for (int i = 0; i < supernode.below; ++i) { y[rows[i]] -= below[i]; }
}

template <class Arch>
void backward(const View& view, const Supernode& supernode, float* y, float* work) noexcept {
  constexpr long lanes = Lanes<Arch>::count;
  float* x = y + supernode.first;
  for (int i = 0; i < supernode.width; ++i) { work[i] = x[i]; }
  const int* rows = view.rows + supernode.rows;
  float* below = work + supernode.width;
  for (int i = 0; i < supernode.below; ++i) { below[i] = -y[rows[i]]; }
  for (long i = supernode.width + supernode.below; i < supernode.blocks * lanes; ++i) {
    work[i] = 0.0F;
  }
  const float* values = view.values + supernode.values;
  for (int c = 0; c < supernode.width; c += tile) {
    const int columns = supernode.width - c < tile ? supernode.width - c : tile;
    Tiles<Arch>::sum[columns - 1](values, supernode.blocks, work, x + c);
    values += static_cast<long>(columns) * supernode.blocks * lanes;
  }
}

template <class Arch> void solve(const View& view, float* y, float* work) noexcept {
  for (long p = 0; p < view.count; ++p) { forward<Arch>(view, view.supernodes[p], y, work); }
  for (long i = 0; i < view.size; ++i) { y[i] *= view.inverse_pivots[i]; }
  for (long p = view.count; p-- > 0;) { backward<Arch>(view, view.supernodes[p], y, work); }
}

template <class Arch> Kernels kernels_for(const char* name) noexcept {
  return {.name = name, .lanes = static_cast<int>(Lanes<Arch>::count), .solve = &solve<Arch>};
}

}  // namespace palpate::supernodes
