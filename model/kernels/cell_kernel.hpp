// SPDX-License-Identifier: MIT
#pragma once
/// Kernels of cells. One source file per instruction set includes this header; `Arch` gives each
/// instantiation its own functions.

#include <xsimd/xsimd.hpp>

#include "model/kernels/kernel_views.hpp"
#include "model/kernels/simd.hpp"
#include "model/problem/cell_law.hpp"

namespace palpate {

template <class Real, class Arch> struct CollapseSlope<xsimd::batch<Real, Arch>> {
  using Batch = xsimd::batch<Real, Arch>;
  static Batch of(const Batch& j) noexcept;
};
template <class Real, class Arch>
auto CollapseSlope<xsimd::batch<Real, Arch>>::of(const Batch& j) noexcept -> Batch {
  constexpr auto begin = static_cast<Real>(collapse_begin);
  constexpr auto linear = static_cast<Real>(collapse_linear);
  if (xsimd::all(j >= Batch(begin))) { return Batch(Real(0)); }
  constexpr Real log_linear = Real(-2.302585092994045684);
  static_assert(collapse_linear == 0.1);  // of the logarithm
  constexpr Real left = Real(1) - linear;
  constexpr Real curvature =
      (Real(-2) * log_linear + Real(4) * left / linear + left * left / (linear * linear)) / begin;
  const Batch s = xsimd::min(xsimd::max(j / Batch(begin), Batch(linear)), Batch(Real(1)));
  const Batch rest = Batch(Real(1)) - s;
  const Batch slope = Batch(Real(2)) * rest * xsimd::log(s) - rest * rest / s;
  return slope + xsimd::min(j - Batch(linear * begin), Batch(Real(0))) * Batch(curvature);
}

namespace cells {

/// Loads one vector per corner: coordinates of free nodes from `moving`, and of fixed nodes from
/// `fixed`, or zero if that is null.
template <class Real, class Arch>
Corners<xsimd::batch<Real, Arch>> load(const int* first, const Real* moving,
                                       const Real* fixed) noexcept {
  using Batch = xsimd::batch<Real, Arch>;
  constexpr long lanes = static_cast<long>(Batch::size);
  Corners<Batch> corners;
  for (long n = 0; n < 8; ++n) {
    alignas(64) Real x[lanes];
    alignas(64) Real y[lanes];
    alignas(64) Real z[lanes];
    for (long lane = 0; lane < lanes; ++lane) {
      const int at = first[n * lanes + lane];
      const Real* from = at >= 0 ? moving + at : fixed != nullptr ? fixed + (-1 - at) : nullptr;
      x[lane] = from != nullptr ? from[0] : Real(0);
      y[lane] = from != nullptr ? from[1] : Real(0);
      z[lane] = from != nullptr ? from[2] : Real(0);
    }
    corners[static_cast<unsigned>(n)] = {Batch::load_aligned(x), Batch::load_aligned(y),
                                         Batch::load_aligned(z)};
  }
  return corners;
}

enum class Terms { elastic, damped, relaxing };

template <Terms terms, class Real, class Arch>
void add_forces(const View<Real>& view, const Real* q, const Real* v, Real* f) noexcept {
  using Batch = xsimd::batch<Real, Arch>;
  constexpr long lanes = static_cast<long>(Batch::size);
  for (long batch = 0; batch < view.batches; ++batch) {
    const int* first = view.first + 8 * lanes * batch;
    const Real* numbers = view.numbers + 4 * lanes * batch;
    const CellNumbers<Batch> cell{
        Batch::load_unaligned(numbers), Batch::load_unaligned(numbers + lanes),
        Batch::load_unaligned(numbers + 2 * lanes), Batch::load_unaligned(numbers + 3 * lanes)};
    const Corners<Batch> x = load<Real, Arch>(first, q, view.fixed);
    Corners<Batch> on;
    for (auto& corner : on) { corner = {Batch(Real(0)), Batch(Real(0)), Batch(Real(0))}; }
    if constexpr (terms == Terms::relaxing) {
      const RelaxedCell<Batch> relaxed{Batch::load_unaligned(view.share + lanes * batch),
                                       Batch::load_unaligned(view.held + lanes * batch)};
      add_cell_forces<true>(cell, x, load<Real, Arch>(first, v, nullptr), on, &relaxed);
    } else if constexpr (terms == Terms::damped) {
      add_cell_forces<true>(cell, x, load<Real, Arch>(first, v, nullptr), on);
    } else {
      add_cell_forces<false>(cell, x, x, on);
    }
    for (long n = 0; n < 8; ++n) {
      const auto corner = static_cast<unsigned>(n);
      alignas(64) Real force[3][lanes];
      on[corner].x.store_aligned(force[0]);
      on[corner].y.store_aligned(force[1]);
      on[corner].z.store_aligned(force[2]);
      for (long lane = 0; lane < lanes; ++lane) {
        const int at = first[n * lanes + lane];
        if (at < 0) { continue; }
        for (long axis = 0; axis < 3; ++axis) { f[at + axis] += force[axis][lane]; }
      }
    }
  }
}

template <class Real, class Arch> Kernels<Real> kernels_for() noexcept {
  return {.lanes = static_cast<int>(xsimd::batch<Real, Arch>::size),
          .damped = &add_forces<Terms::damped, Real, Arch>,
          .undamped = &add_forces<Terms::elastic, Real, Arch>,
          .relaxing = &add_forces<Terms::relaxing, Real, Arch>};
}

}  // namespace cells
}  // namespace palpate
