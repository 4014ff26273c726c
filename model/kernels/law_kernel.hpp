// SPDX-License-Identifier: MIT
#pragma once
/// Kernels of springs that stiffen or relax. One source file per instruction set includes this
/// header; `Arch` gives each instantiation its own functions.

#include <xsimd/xsimd.hpp>

#include "model/kernels/kernel_views.hpp"
#include "model/kernels/simd.hpp"
#include "model/problem/cell_law.hpp"

namespace palpate::laws {

/// Batches of springs of a view, one after the other.
template <class Real, class Arch> class SpringBatches {
 public:
  using Batch = xsimd::batch<Real, Arch>;
  using Three = Vector3Of<Batch>;
  static constexpr long lanes = static_cast<long>(Batch::size);

  explicit SpringBatches(const View<Real>& view) noexcept : view_(view) {}
  /// Calls visit(batch index, elastic tension, d, inverse length) for every batch; d points from
  /// end a to end b.
  template <class Visit> void for_each(const Real* q, Visit visit) noexcept {
    long batch = 0;
    for (long group = 0; group < view_.count; ++group) {
      const StiffeningNumbers<Real>& stiffening = view_.groups[group].stiffening;
      for (const long end = batch + view_.groups[group].batches; batch < end; ++batch) {
        const Three d = load(batch, 1, q, view_.fixed) - load(batch, 0, q, view_.fixed);
        const Batch length = xsimd::sqrt(d.dot(d) + Batch(least_square<Real>));
        const Batch rest = number(batch, 1);
        Batch extension = length - rest;
        if (!stiffening.linear) {
          extension = rest * stretched(stiffening, Batch(extension / rest)).value;
        }
        visit(batch, Batch(number(batch, 0) * extension), d, Batch(Batch(Real(1)) / length));
      }
    }
  }
  [[nodiscard]] Batch viscosity(long batch) const noexcept { return number(batch, 2); }
  [[nodiscard]] Batch at(const Real* all, long batch) const noexcept {
    return Batch::load_unaligned(all + lanes * batch);
  }
  /// Loads an end of the springs: coordinates of free nodes from `moving`, and of fixed nodes from
  /// `fixed`, or zero if that is null.
  [[nodiscard]] Three load(long batch, long end, const Real* moving,
                           const Real* fixed) const noexcept {
    const int* first = ends(batch, end);
    alignas(64) Real place[3][lanes];
    for (long lane = 0; lane < lanes; ++lane) {
      const int at = first[lane];
      const Real* from = at >= 0 ? moving + at : fixed != nullptr ? fixed + (-1 - at) : nullptr;
      for (long axis = 0; axis < 3; ++axis) {
        place[axis][lane] = from != nullptr ? from[axis] : Real(0);
      }
    }
    return {Batch::load_aligned(place[0]), Batch::load_aligned(place[1]),
            Batch::load_aligned(place[2])};
  }
  /// Adds forces to an end of the springs.
  void spread(long batch, long end, const Three& force, Real* f) const noexcept {
    const int* first = ends(batch, end);
    alignas(64) Real on[3][lanes];
    force.x.store_aligned(on[0]);
    force.y.store_aligned(on[1]);
    force.z.store_aligned(on[2]);
    for (long lane = 0; lane < lanes; ++lane) {
      if (first[lane] < 0) { continue; }
      for (long axis = 0; axis < 3; ++axis) { f[first[lane] + axis] += on[axis][lane]; }
    }
  }

 private:
  [[nodiscard]] const int* ends(long batch, long end) const noexcept {
    return view_.ends + (2 * batch + end) * lanes;
  }
  [[nodiscard]] Batch number(long batch, long which) const noexcept {
    return Batch::load_unaligned(view_.numbers + (3 * batch + which) * lanes);
  }
  const View<Real>& view_;
};

template <class Real, class Arch>
void add_forces(const View<Real>& view, const Real* q, const Real* v, Real* f) noexcept {
  using Batches = SpringBatches<Real, Arch>;
  using Batch = typename Batches::Batch;
  Batches springs(view);
  springs.for_each(q, [&](long batch, const Batch& elastic, const auto& d, const Batch& inverse) {
    const auto w = springs.load(batch, 1, v, nullptr) - springs.load(batch, 0, v, nullptr);
    const Batch tension = springs.at(view.share, batch) * elastic - springs.at(view.held, batch) +
                          springs.viscosity(batch) * (w.dot(d) * inverse);
    const auto pull = d.scaled(Batch(tension * inverse));
    springs.spread(batch, 0, pull, f);
    springs.spread(batch, 1, pull.scaled(Batch(Real(-1))), f);
  });
}

template <class Real, class Arch>
void find_tensions(const View<Real>& view, const Real* q, Real* tension) noexcept {
  using Batch = xsimd::batch<Real, Arch>;
  SpringBatches<Real, Arch>(view).for_each(
      q, [&](long batch, const Batch& elastic, const auto&, const Batch&) {
        elastic.store_unaligned(tension + static_cast<long>(Batch::size) * batch);
      });
}

template <class Real, class Arch> Kernels<Real> kernels_for() noexcept {
  return {.lanes = static_cast<int>(xsimd::batch<Real, Arch>::size),
          .force = &add_forces<Real, Arch>,
          .tension = &find_tensions<Real, Arch>};
}

}  // namespace palpate::laws
