// SPDX-License-Identifier: MIT
#pragma once
/// What the kernels of a triangular solve in panels see, and the kernels that this machine can run
/// (model/EQUATIONS.md, "Panels of a factorisation").

namespace palpate::panels {

/// Columns that a block of rows has at most side by side: their sums stay in registers.
inline constexpr int tile = 8;

/// Columns [first, first + width) and the rows that they touch, their own first. Stored is not L but what
/// solves with it: the inverse of its own square, and the rows below times that inverse. Tiles of columns one
/// after the other, each in blocks of as many rows as there are lanes, each block by columns.
struct Panel {
  int first = 0;
  int width = 0;
  int blocks = 0;       ///< of rows
  int below = 0;        ///< rows below its own
  long rows = 0;        ///< where those begin in View::rows
  long values = 0;      ///< where the first tile begins in View::values
};

struct View {
  const Panel* panels = nullptr;
  long count = 0;
  const int* rows = nullptr;
  const float* values = nullptr;
  const float* inverse_pivots = nullptr;
  long size = 0;        ///< of the whole matrix
};

struct Kernels {
  const char* name = "";
  int lanes = 1;
  /// y = (L D L^T)^-1 y. `work` has a place for every row of the highest panel, in whole blocks.
  void (*solve)(const View& view, float* y, float* work) noexcept = nullptr;
};

Kernels baseline_kernels() noexcept;
/// Only where the processor has AVX2 and FMA.
Kernels avx2_kernels() noexcept;
/// Only where the processor has AVX-512.
Kernels avx512_kernels() noexcept;

}  // namespace palpate::panels
