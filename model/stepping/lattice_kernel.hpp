// SPDX-License-Identifier: MIT
#pragma once
/// The loop over the springs of a regular lattice, without indices, for one instruction set
/// (model/EQUATIONS.md, "Lattice in lanes"). Included by one source file per instruction set; includes
/// no code that other files compile too, so that no instruction strays.

#include <xsimd/xsimd.hpp>

#include "model/stepping/lattice_view.hpp"

namespace palpate::lattice {

enum class Task { force, undamped_force, measured_force, measured_undamped_force, damping, energy };

/// Vector `i` of a node row against one vector of a neighbour's: what their springs do.
template <Task task, class Real, class Arch>
class RowVector {
 public:
  using Batch = xsimd::batch<Real, Arch>;
  static constexpr long lanes = static_cast<long>(Batch::size);
  static constexpr bool uses_velocity =
      task == Task::force || task == Task::measured_force || task == Task::damping;
  static constexpr bool measures =
      task == Task::measured_force || task == Task::measured_undamped_force || task == Task::energy;

  RowVector(const View<Real>& view, const Real* q, const Real* v, Real* f, long place) noexcept
      : q_(q), v_(v), f_(f), stride_(view.stride), place_(place) {
    for (int c = 0; c < 3; ++c) {
      position_[c] = load(q + place + c * stride_);
      if constexpr (uses_velocity) { velocity_[c] = load(v + place + c * stride_); }
    }
  }
  /// `constants` of these springs, `rest` their length.
  void join(long neighbour, const Real* constants, Real rest) noexcept {
    const Batch dx = load(q_ + neighbour) - position_[0];
    const Batch dy = load(q_ + neighbour + stride_) - position_[1];
    const Batch dz = load(q_ + neighbour + 2 * stride_) - position_[2];
    const Batch square = xsimd::fma(dz, dz, xsimd::fma(dy, dy, dx * dx));
    const Batch length = xsimd::sqrt(square);
    const Batch extension = length - Batch(rest);
    Batch tension(Real(0));
    if constexpr (task != Task::damping) { tension = load(constants) * extension; }
    if constexpr (measures) { energy_ = xsimd::fma(tension, extension, energy_); }
    if constexpr (task == Task::energy) { return; }
    const Batch inverse =
        xsimd::select(length > Batch(view_zero_length), Batch(Real(1)) / length, Batch(Real(0)));
    if constexpr (uses_velocity) {
      const Batch wx = load(v_ + neighbour) - velocity_[0];
      const Batch wy = load(v_ + neighbour + stride_) - velocity_[1];
      const Batch wz = load(v_ + neighbour + 2 * stride_) - velocity_[2];
      const Batch rate = xsimd::fma(wz, dz, xsimd::fma(wy, dy, wx * dx)) * inverse;
      tension = xsimd::fma(load(constants + lanes), rate, tension);
    }
    const Batch factor = tension * inverse;
    pull(0, neighbour, factor, dx);
    pull(1, neighbour + stride_, factor, dy);
    pull(2, neighbour + 2 * stride_, factor, dz);
  }
  void finish() noexcept {
    if constexpr (task != Task::energy) {
      for (int c = 0; c < 3; ++c) {
        Real* to = f_ + place_ + c * stride_;
        (load(to) + force_[c]).store_unaligned(to);
      }
    }
  }
  [[nodiscard]] Real energy() const noexcept { return Real(0.5) * xsimd::hadd(energy_); }

 private:
  static Batch load(const Real* from) noexcept { return Batch::load_unaligned(from); }
  void pull(int c, long neighbour, const Batch& factor, const Batch& d) noexcept {
    force_[c] = xsimd::fma(factor, d, force_[c]);
    xsimd::fnma(factor, d, load(f_ + neighbour)).store_unaligned(f_ + neighbour);
  }
  static constexpr Real view_zero_length = View<Real>::zero_length;

  const Real* q_;
  const Real* v_;
  Real* f_;
  long stride_;
  long place_;
  Batch position_[3]{};
  Batch velocity_[3]{};
  Batch force_[3]{Batch(Real(0)), Batch(Real(0)), Batch(Real(0))};
  Batch energy_ = Batch(Real(0));
};

/// The rows that a row's springs lead to, none of which comes before it.
struct Neighbours {
  int count = 0;
  bool own = false;  ///< springs within the row
  struct Row {
    long begin;
    long slot;
    bool sides;       ///< springs to the left and to the right too
    double rest[2];   ///< straight across, and to the sides
  } rows[neighbour_kinds];
};

/// `Arch` makes it a function of this instruction set alone.
template <class Arch, class Real>
Neighbours neighbours_of(const View<Real>& view, int row1, int row2, long row_length) noexcept {
  Neighbours found;
  const long own = static_cast<long>(row2) * view.rows1 + row1;
  const bool moves = view.row_moves[own] != 0;
  found.own = moves && view.own_springs;
  for (int kind = 0; kind < neighbour_kinds; ++kind) {
    const int at1 = row1 + neighbour_steps[kind][0];
    const int at2 = row2 + neighbour_steps[kind][1];
    if (at1 < 0 || at1 >= view.rows1 || at2 >= view.rows2 || !view.straight[kind]) { continue; }
    const long there = static_cast<long>(at2) * view.rows1 + at1;
    if (!moves && view.row_moves[there] == 0) { continue; }
    const int spans = kind % 2;  // kinds 1 and 3 lead along two axes
    found.rows[found.count++] = {view.lead + there * row_length,
                                 1 + 3L * kind,
                                 view.sides[kind],
                                 {static_cast<double>(view.rest[spans]),
                                  static_cast<double>(view.rest[spans + 1])}};
  }
  return found;
}

template <Task task, class Real, class Arch>
double go_through(const View<Real>& view, const Real* q, const Real* v, Real* f) noexcept {
  using Vector = RowVector<task, Real, Arch>;
  constexpr long lanes = Vector::lanes;
  const long row_length = view.vectors * lanes;
  const long slot_length = row_length * view.numbers;
  double energy = 0.0;
  for (int row2 = 0; row2 < view.rows2; ++row2) {
    for (int row1 = 0; row1 < view.rows1; ++row1) {
      const Neighbours near = neighbours_of<Arch>(view, row1, row2, row_length);
      if (near.count == 0 && !near.own) { continue; }
      const long row = static_cast<long>(row2) * view.rows1 + row1;
      const long begin = view.lead + row * row_length;
      const Real* table = view.tables + view.row_table[row];
      for (long i = 0; i < view.vectors; ++i) {
        // The piece's last node is beside the next piece's first: the same vector, one lane on.
        const long right = i + 1 < view.vectors ? (i + 1) * lanes : 1;
        const long left = i > 0 ? (i - 1) * lanes : (view.vectors - 1) * lanes - 1;
        const Real* constants = table + i * lanes * view.numbers;
        Vector own(view, q, v, f, begin + i * lanes);
        if (near.own) { own.join(begin + right, constants, view.rest[0]); }
        for (int n = 0; n < near.count; ++n) {
          const Neighbours::Row& there = near.rows[n];
          const Real* slot = constants + there.slot * slot_length;
          const Real across = static_cast<Real>(there.rest[0]);
          const Real aside = static_cast<Real>(there.rest[1]);
          if (there.sides) { own.join(there.begin + left, slot, aside); }
          own.join(there.begin + i * lanes, slot + slot_length, across);
          if (there.sides) { own.join(there.begin + right, slot + 2 * slot_length, aside); }
        }
        own.finish();
        if constexpr (Vector::measures) { energy += static_cast<double>(own.energy()); }
      }
    }
  }
  return energy;
}

template <class Real, class Arch>
void roots_and_quotients(const Real* from, Real* to, long count) noexcept {
  using Batch = xsimd::batch<Real, Arch>;
  for (long n = 0; n < count; n += static_cast<long>(Batch::size)) {
    (Batch(Real(1)) / xsimd::sqrt(Batch::load_unaligned(from + n))).store_unaligned(to + n);
  }
}

template <class Real, class Arch>
Kernels<Real> kernels_for(const char* name) noexcept {
  return {.name = name,
          .lanes = static_cast<int>(xsimd::batch<Real, Arch>::size),
          .force = &go_through<Task::force, Real, Arch>,
          .undamped_force = &go_through<Task::undamped_force, Real, Arch>,
          .measured_force = &go_through<Task::measured_force, Real, Arch>,
          .measured_undamped_force = &go_through<Task::measured_undamped_force, Real, Arch>,
          .damping = &go_through<Task::damping, Real, Arch>,
          .energy = &go_through<Task::energy, Real, Arch>,
          .roots_and_quotients = &roots_and_quotients<Real, Arch>};
}

}  // namespace palpate::lattice
