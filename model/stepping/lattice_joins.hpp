// SPDX-License-Identifier: MIT
#pragma once
/// In which order the springs of a vector of a regular lattice's nodes are gone through
/// (model/EQUATIONS.md, "Lattice in lanes"). Included by one source file per instruction set; includes no code that
/// other files compile too, so that no instruction strays.

#include <type_traits>
#include <utility>

#include <xsimd/xsimd.hpp>

#include "model/stepping/always_inline.hpp"
#include "model/stepping/lattice_vector.hpp"
#include "model/stepping/lattice_view.hpp"

namespace palpate::lattice {

/// The rows that a row's springs lead to, of those that a slab asks for.
template <class Arch, class Real>
struct Neighbours {
  Nodes<Real> own;
  int count = 0;
  bool within = false;  ///< springs within the row
  bool all = false;     ///< these, and all of every kind to other rows
  struct Row {
    Nodes<Real> at;
    const Link<Real>* link;
  } rows[neighbour_kinds];
};

/// Where vector `i` of a row is, those beside it are, and its springs' constants.
template <class Arch, class Real>
struct Columns {
  long left;
  long here;
  long right;
  const Real* constants;
  long slot_length;
  Real own_rest;  ///< length [m] of springs within the row

  PALPATE_ALWAYS_INLINE Columns(const View<Real>& view, long i, const Real* table) noexcept : own_rest(view.own_rest) {
    constexpr long lanes = static_cast<long>(xsimd::batch<Real, Arch>::size);
    constexpr long block = 3 * lanes;
    // The piece's last node is beside the next piece's first: the same vector, one lane on.
    left = i > 0 ? (i - 1) * block : (view.vectors - 1) * block - 1;
    here = i * block;
    right = i + 1 < view.vectors ? (i + 1) * block : 1;
    slot_length = lanes * view.numbers;
    constants = table + i * slots * slot_length;
  }
};

/// One after the other.
template <class Vector, class Arch, class Real>
PALPATE_ALWAYS_INLINE inline void join_in_turn(Vector& vector, const Neighbours<Arch, Real>& near,
                                               const Columns<Arch, Real>& at) noexcept {
  if (near.within) { vector.join(near.own, at.right, at.constants, at.own_rest); }
  for (int n = 0; n < near.count; ++n) {
    const auto& [there, link] = near.rows[n];
    const Real* slot = at.constants + link->constants;
    if (link->sides) { vector.join(there, at.left, slot, link->rest_aside); }
    vector.join(there, at.here, slot + at.slot_length, link->rest_across);
    if (link->sides) { vector.join(there, at.right, slot + 2 * at.slot_length, link->rest_aside); }
  }
}

/// The same, to the bit, for a vector that has springs of every kind: each begins while the one before is measured and
/// the one before that ends, so that no processor has to look far ahead for something to do. It takes the registers of
/// AVX-512.
template <class Vector, class Arch, class Real>
PALPATE_ALWAYS_INLINE inline void join_staggered(Vector& vector, const Neighbours<Arch, Real>& near,
                                                 const Columns<Arch, Real>& at) noexcept {
  typename Vector::Springs springs[slots];
  const auto begin = [&](int n) PALPATE_ALWAYS_INLINE {
    if (n == 0) {
      vector.begin(springs[0], near.own, at.right, at.constants, at.own_rest);
      return;
    }
    const auto& [there, link] = near.rows[(n - 1) / 3];
    const int side = (n - 1) % 3;
    const Real* constants = at.constants + link->constants + side * at.slot_length;
    const long column = side == 0 ? at.left : side == 1 ? at.here : at.right;
    vector.begin(springs[n], there, column, constants, side == 1 ? link->rest_across : link->rest_aside);
  };
  const auto stage = [&]<int n>(std::integral_constant<int, n>) PALPATE_ALWAYS_INLINE {
    if constexpr (n < slots) { begin(n); }
    asm volatile("" ::: "memory");  // g++ 12 would put some of that off
    if constexpr (n >= 1 && n <= slots) { vector.measure(springs[n - 1]); }
    if constexpr (n >= 2) { vector.end(springs[n - 2]); }
  };
  [&]<int... n>(std::integer_sequence<int, n...>) PALPATE_ALWAYS_INLINE {
    (stage(std::integral_constant<int, n>{}), ...);
  }(std::make_integer_sequence<int, slots + 2>{});
}

/// Goes through the springs of vector `i` of a row. Returns their energy [J] if the task measures it.
template <Task task, Fetch fetch, class Arch, class Real>
PALPATE_ALWAYS_INLINE inline double go_through_vector(const View<Real>& view, const Neighbours<Arch, Real>& near,
                                                      long i, const Real* table) noexcept {
  using Vector = RowVector<task, fetch, Real, Arch>;
  constexpr bool staggers = fused::is_avx512<Arch> && !measures_energy(task) && task != Task::damping;
  const Columns<Arch, Real> at(view, i, table);
  Vector vector(near.own, at.here);
  if (staggers && near.all) {
    if constexpr (staggers) { join_staggered(vector, near, at); }
  } else {
    join_in_turn(vector, near, at);
  }
  vector.finish();
  if constexpr (measures_energy(task)) { return static_cast<double>(vector.energy()); }
  return 0.0;
}

}  // namespace palpate::lattice
