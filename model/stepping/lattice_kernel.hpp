// SPDX-License-Identifier: MIT
#pragma once
/// The loop over the springs of a regular lattice, without indices, for one instruction set
/// (model/EQUATIONS.md, "Lattice in lanes"). Included by one source file per instruction set; includes
/// no code that other files compile too, so that no instruction strays.

#include <xsimd/xsimd.hpp>

#include "model/stepping/always_inline.hpp"
#include "model/stepping/fused.hpp"
#include "model/stepping/lattice_joins.hpp"
#include "model/stepping/lattice_vector.hpp"
#include "model/stepping/lattice_view.hpp"

namespace palpate::lattice {

/// From element `begin` on, forces from `force_begin`. What a task does not need stays null. `Arch` in what follows
/// makes functions of this instruction set alone.
template <Task task, class Arch, class Real>
Nodes<Real> from_element(const Nodes<Real>& nodes, long begin, long force_begin) noexcept {
  Nodes<Real> row{.q = nodes.q + begin};
  if constexpr (sees_velocity(task)) { row.v = nodes.v + begin; }
  if constexpr (task != Task::energy) { row.f = nodes.f + force_begin; }
  return row;
}

/// Where the forces of a layer's first row begin.
template <Task task, class Arch, class Real>
long force_begin(const View<Real>& view, const Fields<Real>& fields, int layer) noexcept {
  const int kept = takes_step(task) && fields.force_layers > 0 ? layer % fields.force_layers : layer;
  return view.lead + kept * view.layer_length;
}

/// A layer and the next, from where their first rows begin. Where another thread moves one, its copy stands for it.
template <class Arch, class Real>
struct LayerPair {
  Nodes<Real> nodes[2];
};

template <Task task, class Arch, class Real>
LayerPair<Arch, Real> layers_from(const View<Real>& view, const Slab<Real>& slab, const Fields<Real>& fields,
                                  int row2) noexcept {
  const Nodes<Real> all{fields.q, fields.v, fields.f};
  const auto layer = [&](int number) {
    return from_element<task, Arch>(all, view.lead + number * view.layer_length,
                                    force_begin<task, Arch>(view, fields, number));
  };
  LayerPair<Arch, Real> pair{};
  pair.nodes[0] = slab.below != nullptr ? *slab.below : layer(row2);
  const bool copied = row2 + 1 == slab.end && slab.beyond != nullptr;
  if (row2 + 1 < view.rows2) { pair.nodes[1] = copied ? *slab.beyond : layer(row2 + 1); }
  return pair;
}

/// Springs between two rows at rest are not looked at.
template <Task task, class Arch, class Real>
PALPATE_ALWAYS_INLINE inline Neighbours<Arch, Real> neighbours_of(const View<Real>& view, const Slab<Real>& slab,
                                                                  const LayerPair<Arch, Real>& layers, int row1,
                                                                  int row2) noexcept {
  const bool below = slab.below != nullptr;
  const Links<Real>& links = view.links[row1 == 0 ? 0 : row1 + 1 < view.rows1 ? 1 : 2];
  const unsigned char* const moves = view.row_moves + static_cast<long>(row2) * view.rows1 + row1;
  const long row = row1 * view.row_length;
  Neighbours<Arch, Real> found;
  found.own = from_element<task, Arch>(layers.nodes[0], row, row);
  found.within = *moves != 0 && view.own_springs && !below;
  const int end = row2 + 1 < view.rows2 ? links.count : links.within;
  for (int n = below ? links.within : 0; n < end; ++n) {
    const Link<Real>& link = links.to[n];
    if (*moves == 0 && moves[link.rows] == 0) { continue; }
    const long there = row + link.elements;
    found.rows[found.count++] = {from_element<task, Arch>(layers.nodes[link.layers], there, there), &link};
  }
  found.all = found.within && found.count == neighbour_kinds && links.sides;
  return found;
}

/// v += h f / m, x += h v, f = 0 of the row that begins at element `begin`, whose forces are at `f`; returns the sum of
/// squares of v.
template <class Arch, class Real>
PALPATE_ALWAYS_INLINE inline double move_row(const Fields<Real>& fields, long begin, Real* f,
                                             long row_length) noexcept {
  using Batch = xsimd::batch<Real, Arch>;
  const Move<Real>& move = *fields.move;
  const Batch h(move.h);
  Batch squares(Real(0));
  constexpr long lanes = static_cast<long>(Batch::size);
  for (long i = 0; i < row_length; i += 3 * lanes) {
    const Batch inverse_mass = Batch::load_unaligned(move.inverse_mass + begin + i);
    for (long c = 0; c < 3; ++c) {
      const long at = begin + i + c * lanes;
      Real* force = f + i + c * lanes;
      const Batch a = Batch::load_unaligned(force) * inverse_mass;
      const Batch v = Batch::load_unaligned(move.v + at) + h * a;
      v.store_unaligned(move.v + at);
      (Batch::load_unaligned(move.q + at) + h * v).store_unaligned(move.q + at);
      Batch(Real(0)).store_unaligned(force);
      squares = fused::add(v, v, squares);
    }
  }
  return static_cast<double>(xsimd::hadd(squares));
}

/// The last row of a folded layer leads to its first: all stand until it is gone through.
template <class Arch, class Real>
double move_layer(const View<Real>& view, const Fields<Real>& fields, int row2, Real* f, long row_length) noexcept {
  double sum = 0.0;
  for (long row1 = 0; row1 < view.rows1; ++row1) {
    const long row = static_cast<long>(row2) * view.rows1 + row1;
    if (view.row_moves[row] == 0) { continue; }
    sum += move_row<Arch>(fields, view.lead + row * row_length, f + row1 * row_length, row_length);
  }
  return sum;
}

/// Asks memory for vector `i` of the row after the next that this row's springs lead to, and of what is read besides:
/// more streams than processors foresee. g++ 12 leaves a call out that does nothing else.
template <Task task, class Arch, class Real>
PALPATE_ALWAYS_INLINE inline void fetch_row(const View<Real>& view, const Fields<Real>& fields, long row,
                                            long i) noexcept {
  constexpr long lanes = static_cast<long>(xsimd::batch<Real, Arch>::size);
  const long next_layer = row < (view.rows2 - 2L) * view.rows1 ? view.rows1 : 0;  // beyond the last there is nothing
  const long own = view.lead + row * view.row_length + i * 3 * lanes;
  const long ahead = own + (next_layer + 2) * view.row_length;
  for (long c = 0; c < 3; ++c) {
    __builtin_prefetch(fields.q + ahead + c * lanes);
    if constexpr (sees_velocity(task)) { __builtin_prefetch(fields.v + ahead + c * lanes); }
  }
  if constexpr (takes_step(task)) { __builtin_prefetch(fields.move->inverse_mass + own + view.row_length); }
  if (fields.force_layers == 0) {
    for (long c = 0; c < 3; ++c) { __builtin_prefetch(fields.f + ahead + c * lanes); }
  }
}

template <Task task, Fetch fetch, class Real, class Arch>
double go_through(const View<Real>& view, const Slab<Real>& slab, const Fields<Real>& fields) noexcept {
  const long row_length = view.row_length;
  const bool moves = takes_step(task) && slab.below == nullptr;
  double sum = 0.0;
  for (int row2 = slab.begin; row2 < slab.end; ++row2) {
    const auto layers = layers_from<task, Arch>(view, slab, fields, row2);
    for (int row1 = 0; row1 < view.rows1; ++row1) {
      const auto near = neighbours_of<task, Arch>(view, slab, layers, row1, row2);
      const long row = static_cast<long>(row2) * view.rows1 + row1;
      const Real* table = view.tables + view.row_table[row];
      const bool joined = near.count > 0 || near.within;
      for (long i = 0; joined && i < view.vectors; ++i) {
        if constexpr (fetch != Fetch::nothing) { fetch_row<task, Arch>(view, fields, row, i); }
        const double energy = go_through_vector<task, fetch>(view, near, i, table);
        if constexpr (measures_energy(task)) { sum += energy; }
      }
      if constexpr (takes_step(task)) {
        if (moves && !view.folded && view.row_moves[row] != 0) {
          sum += move_row<Arch>(fields, view.lead + row * row_length, near.own.f, row_length);
        }
      }
    }
    if constexpr (takes_step(task)) {
      if (moves && view.folded) { sum += move_layer<Arch>(view, fields, row2, layers.nodes[0].f, row_length); }
    }
  }
  return sum;
}

template <class Real, class Arch>
void roots_and_quotients(const Real* from, Real* to, long count) noexcept {
  using Batch = xsimd::batch<Real, Arch>;
  for (long n = 0; n < count; n += static_cast<long>(Batch::size)) {
    (Batch(Real(1)) / xsimd::sqrt(Batch::load_unaligned(from + n))).store_unaligned(to + n);
  }
}

template <Task task, class Real, class Arch>
FetchingKernels<Real> fetching() noexcept {
  return {{&go_through<task, Fetch::nothing, Real, Arch>, &go_through<task, Fetch::rows, Real, Arch>,
           &go_through<task, Fetch::rows_and_constants, Real, Arch>}};
}

template <class Real, class Arch>
Kernels<Real> kernels_for(const char* name) noexcept {
  return {.name = name,
          .lanes = static_cast<int>(xsimd::batch<Real, Arch>::size),
          .force = fetching<Task::force, Real, Arch>(),
          .undamped_force = fetching<Task::undamped_force, Real, Arch>(),
          .measured_force = &go_through<Task::measured_force, Fetch::nothing, Real, Arch>,
          .measured_undamped_force = &go_through<Task::measured_undamped_force, Fetch::nothing, Real, Arch>,
          .step = fetching<Task::step, Real, Arch>(),
          .undamped_step = fetching<Task::undamped_step, Real, Arch>(),
          .damping = &go_through<Task::damping, Fetch::nothing, Real, Arch>,
          .energy = &go_through<Task::energy, Fetch::nothing, Real, Arch>,
          .roots_and_quotients = &roots_and_quotients<Real, Arch>};
}

}  // namespace palpate::lattice
