// SPDX-License-Identifier: MIT
#pragma once
/// Kernels of a regular lattice (model/EQUATIONS.md, "Lattice in lanes"), for one source file per
/// instruction set. They must not include code that other files compile: the linker could keep the
/// version for the wrong instruction set.

#include <type_traits>
#include <xsimd/xsimd.hpp>

#include "model/kernels/kernel_views.hpp"
#include "model/kernels/simd.hpp"

namespace palpate::lattice {

/// Task::step is a semi-implicit Euler step in the same pass: a row moves once its springs are
/// computed, while later rows still have their old positions.
enum class Task {
  force,
  undamped_force,
  measured_force,
  measured_undamped_force,
  step,
  undamped_step,
  damping,
  energy
};

constexpr bool sees_velocity(Task task) {
  return task == Task::force || task == Task::measured_force || task == Task::step ||
         task == Task::damping;
}
constexpr bool measures_energy(Task task) {
  return task == Task::measured_force || task == Task::measured_undamped_force ||
         task == Task::energy;
}
constexpr bool takes_step(Task task) { return task == Task::step || task == Task::undamped_step; }

/// One vector of nodes and the forces of its springs.
template <Task task, Fetch fetch, class Real, class Arch> class RowVector {
 public:
  using Batch = xsimd::batch<Real, Arch>;
  using Lengths = SpringLengths<Real, Arch>;
  static constexpr long lanes = static_cast<long>(Batch::size);

  /// Loads the vector that begins at element `i` of a row.
  RowVector(const Nodes<Real>& row, long i) noexcept : own_(row), place_(i) {
    for (int c = 0; c < 3; ++c) {
      position_[c] = load(row.q + i + c * lanes);
      if constexpr (sees_velocity(task)) { velocity_[c] = load(row.v + i + c * lanes); }
    }
  }
  /// Adds the forces of the springs between this vector and the vector at element `i` of another
  /// row. `constants` belong to these springs; `rest` is their rest length [m].
  PALPATE_ALWAYS_INLINE void join(const Nodes<Real>& row, long i, const Real* constants,
                                  const Real& rest) noexcept {
    if constexpr (fetch == Fetch::rows_and_constants) { fetch_constants(constants); }
    const Real* q = row.q + i;
    const Batch dx = position_[0] - load(q);  // from the other node to this one [m]
    const Batch dy = position_[1] - load(q + lanes);
    const Batch dz = position_[2] - load(q + 2 * lanes);
    const Lengths lengths(
        fused::add(dz, dz, fused::add(dy, dy, fused::add(dx, dx, Batch(least_square<Real>)))));
    SpringNumbers<Batch> spring{
        .stiffness = Batch(Real(0)), .rest = Batch(rest), .viscosity = Batch(Real(0))};
    if constexpr (task != Task::damping) { spring.stiffness = load(constants); }
    if constexpr (measures_energy(task)) {
      energy_ = add_twice_energy(spring, Batch(lengths.length()), energy_);
    }
    if constexpr (task == Task::energy) { return; }
    Batch factor;
    if constexpr (sees_velocity(task)) {
      const Real* v = row.v + i;
      const Batch wx = velocity_[0] - load(v);
      const Batch wy = velocity_[1] - load(v + lanes);
      const Batch wz = velocity_[2] - load(v + 2 * lanes);
      const Batch rate = fused::add(wz, dz, fused::add(wy, dy, wx * dx));  // L' L
      spring.viscosity = load(constants + lanes);
      factor = lengths.pull(spring, rate);
    } else {
      factor = lengths.pull(spring);
    }
    Real* f = row.f + i;
    pull(0, f, factor, dx);
    pull(1, f + lanes, factor, dy);
    pull(2, f + 2 * lanes, factor, dz);
  }
  /// Stores the forces of this vector.
  void finish() noexcept {
    if constexpr (task != Task::energy) {
      for (int c = 0; c < 3; ++c) {
        Real* to = own_.f + place_ + c * lanes;
        (load(to) + force_[c]).store_unaligned(to);
      }
    }
  }
  [[nodiscard]] Real energy() const noexcept { return Real(0.5) * xsimd::hadd(energy_); }

 private:
  /// Prefetches the constants of the vector four positions ahead into the second-level cache, which
  /// supports more outstanding lines than the first.
  static void fetch_constants(const Real* constants) noexcept {
    constexpr int second_cache = 2;
    constexpr long numbers = sees_velocity(task) ? 2 : 1;
    const Real* ahead = constants + 4 * slots * numbers * lanes;
    for (long n = 0; n < numbers; ++n) { __builtin_prefetch(ahead + n * lanes, 0, second_cache); }
  }
  static Batch load(const Real* from) noexcept { return Batch::load_unaligned(from); }
  /// Adds the force of a spring to both ends; `d` points from the other node to this one. With
  /// AVX-512 a single product is used for both ends, because Zen 4 issues additions in parallel
  /// with multiplications. Other instruction sets need one instruction less without it.
  void pull(int c, Real* f, const Batch& factor, const Batch& d) noexcept {
    if constexpr (fused::is_avx512<Arch>) {
      const Batch force = factor * d;
      force_[c] = force_[c] - force;
      asm(""
          : "+v"(force_[c].data));  // keeps the subtraction here; g++ 12 would delay it and run out
                                    // of registers
      (load(f) + force).store_unaligned(f);
    } else {
      force_[c] = fused::subtract(factor, d, force_[c]);
      fused::add(factor, d, load(f)).store_unaligned(f);
    }
  }

  const Nodes<Real>& own_;
  long place_;
  Batch position_[3]{};
  Batch velocity_[3]{};
  Batch force_[3]{Batch(Real(0)), Batch(Real(0)), Batch(Real(0))};
  Batch energy_ = Batch(Real(0));
};

/// Neighbouring rows that receive spring forces from a row, within a slab.
template <class Arch, class Real> struct Neighbours {
  Nodes<Real> own;
  int count = 0;
  bool within = false;  ///< springs within the row exist
  struct Row {
    Nodes<Real> at;
    const Link<Real>* link;
  } rows[neighbour_kinds];
};

/// Element offsets of vector `i` of a row and of its neighbours, and the constants of its springs.
template <class Arch, class Real> struct Columns {
  long left;
  long here;
  long right;
  const Real* constants;
  long slot_length;
  Real own_rest;  ///< rest length of springs within the row [m]

  PALPATE_ALWAYS_INLINE Columns(const View<Real>& view, long i, const Real* table) noexcept
      : own_rest(view.own_rest) {
    constexpr long lanes = static_cast<long>(xsimd::batch<Real, Arch>::size);
    constexpr long block = 3 * lanes;
    // The last node of a segment is next to the first node of the next segment: the same vector,
    // one lane further.
    left = i > 0 ? (i - 1) * block : (view.vectors - 1) * block - 1;
    here = i * block;
    right = i + 1 < view.vectors ? (i + 1) * block : 1;
    slot_length = lanes * view.numbers;
    constants = table + i * slots * slot_length;
  }
};

/// Visits the springs of a vector in a fixed order.
template <class Vector, class Arch, class Real>
PALPATE_ALWAYS_INLINE inline void join_neighbours(Vector& vector,
                                                  const Neighbours<Arch, Real>& near,
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

/// Computes the springs of vector `i` of a row. Returns their energy [J] if the task measures it.
template <Task task, Fetch fetch, class Arch, class Real>
PALPATE_ALWAYS_INLINE inline double compute_vector(const View<Real>& view,
                                                   const Neighbours<Arch, Real>& near, long i,
                                                   const Real* table) noexcept {
  using Vector = RowVector<task, fetch, Real, Arch>;
  const Columns<Arch, Real> at(view, i, table);
  Vector vector(near.own, at.here);
  join_neighbours(vector, near, at);
  vector.finish();
  if constexpr (measures_energy(task)) { return static_cast<double>(vector.energy()); }
  return 0.0;
}

/// Returns the nodes from element `begin` on. Pointers that a task does not use stay null. `Arch`
/// in the following templates gives each instruction set its own functions.
template <Task task, class Arch, class Real>
Nodes<Real> from_element(const Nodes<Real>& nodes, long begin) noexcept {
  Nodes<Real> row{.q = nodes.q + begin};
  if constexpr (sees_velocity(task)) { row.v = nodes.v + begin; }
  if constexpr (task != Task::energy) { row.f = nodes.f + begin; }
  return row;
}

/// Two consecutive layers, from their first rows. A layer that belongs to another thread is
/// replaced by its copy.
template <class Arch, class Real> struct LayerPair { Nodes<Real> nodes[2]; };

template <Task task, class Arch, class Real>
LayerPair<Arch, Real> layers_from(const View<Real>& view, const Slab<Real>& slab,
                                  const Fields<Real>& fields, int row2) noexcept {
  const Nodes<Real> all{fields.q, fields.v, fields.f};
  const auto layer = [&](int number) {
    return from_element<task, Arch>(all, view.lead + number * view.layer_length);
  };
  LayerPair<Arch, Real> pair{};
  pair.nodes[0] = slab.below != nullptr ? *slab.below : layer(row2);
  const bool copied = row2 + 1 == slab.end && slab.beyond != nullptr;
  if (row2 + 1 < view.rows2) { pair.nodes[1] = copied ? *slab.beyond : layer(row2 + 1); }
  return pair;
}

/// Returns the neighbours of a row; springs between two rows that do not move are omitted.
template <Task task, class Arch, class Real>
PALPATE_ALWAYS_INLINE inline Neighbours<Arch, Real> neighbours_of(
    const View<Real>& view, const Slab<Real>& slab, const LayerPair<Arch, Real>& layers, int row1,
    int row2) noexcept {
  const bool below = slab.below != nullptr;
  const Links<Real>& links = view.links[row1 == 0 ? 0 : row1 + 1 < view.rows1 ? 1 : 2];
  const unsigned char* const moves = view.row_moves + static_cast<long>(row2) * view.rows1 + row1;
  const long row = row1 * view.row_length;
  Neighbours<Arch, Real> found;
  found.own = from_element<task, Arch>(layers.nodes[0], row);
  found.within = *moves != 0 && view.own_springs && !below;
  const int end = row2 + 1 < view.rows2 ? links.count : links.within;
  for (int n = below ? links.within : 0; n < end; ++n) {
    const Link<Real>& link = links.to[n];
    if (*moves == 0 && moves[link.rows] == 0) { continue; }
    const long there = row + link.elements;
    found.rows[found.count++] = {from_element<task, Arch>(layers.nodes[link.layers], there), &link};
  }
  return found;
}

/// Moves the row that begins at element `begin`: v += h f / m, x += h v, f = weight. Returns the
/// sum of squares of v.
template <class Arch, class Real>
PALPATE_ALWAYS_INLINE inline double move_row(const Fields<Real>& fields, long begin,
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
      Real* force = fields.f + at;
      const Batch a = Batch::load_unaligned(force) * inverse_mass;
      const Batch v = Batch::load_unaligned(move.v + at) + h * a;
      v.store_unaligned(move.v + at);
      (Batch::load_unaligned(move.q + at) + h * v).store_unaligned(move.q + at);
      const Batch next =
          move.weight != nullptr ? Batch::load_unaligned(move.weight + at) : Batch(Real(0));
      next.store_unaligned(force);
      squares = fused::add(v, v, squares);
    }
  }
  return static_cast<double>(xsimd::hadd(squares));
}

/// Moves the rows of a folded layer. Its last row is connected to its first, so no row moves before
/// all springs of the layer are computed.
template <class Arch, class Real>
double move_layer(const View<Real>& view, const Fields<Real>& fields, int row2) noexcept {
  double sum = 0.0;
  for (long row1 = 0; row1 < view.rows1; ++row1) {
    const long row = static_cast<long>(row2) * view.rows1 + row1;
    if (view.row_moves[row] == 0) { continue; }
    sum += move_row<Arch>(fields, view.lead + row * view.row_length, view.row_length);
  }
  return sum;
}

/// Prefetches vector `i` of the row after the next neighbouring row; there are more streams than
/// hardware prefetchers track. Always inline, because g++ 12 removes a call that only prefetches.
template <Task task, class Arch, class Real>
PALPATE_ALWAYS_INLINE inline void fetch_row(const View<Real>& view, const Fields<Real>& fields,
                                            long row, long i) noexcept {
  constexpr long lanes = static_cast<long>(xsimd::batch<Real, Arch>::size);
  const long next_layer =
      row < (view.rows2 - 2L) * view.rows1 ? view.rows1 : 0;  // there is no row after the last one
  const long own = view.lead + row * view.row_length + i * 3 * lanes;
  const long ahead = own + (next_layer + 2) * view.row_length;
  for (long c = 0; c < 3; ++c) {
    __builtin_prefetch(fields.q + ahead + c * lanes);
    if constexpr (sees_velocity(task)) { __builtin_prefetch(fields.v + ahead + c * lanes); }
    __builtin_prefetch(fields.f + ahead + c * lanes);
  }
  if constexpr (takes_step(task)) {
    __builtin_prefetch(fields.move->inverse_mass + own + view.row_length);
  }
}

template <Task task, Fetch fetch, class Real, class Arch>
double compute_slab(const View<Real>& view, const Slab<Real>& slab,
                    const Fields<Real>& fields) noexcept {
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
        const double energy = compute_vector<task, fetch>(view, near, i, table);
        if constexpr (measures_energy(task)) { sum += energy; }
      }
      if constexpr (takes_step(task)) {
        if (moves && !view.folded && view.row_moves[row] != 0) {
          sum += move_row<Arch>(fields, view.lead + row * view.row_length, view.row_length);
        }
      }
    }
    if constexpr (takes_step(task)) {
      if (moves && view.folded) { sum += move_layer<Arch>(view, fields, row2); }
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

template <Task task, class Real, class Arch> FetchingKernels<Real> fetching() noexcept {
  return {{&compute_slab<task, Fetch::nothing, Real, Arch>,
           &compute_slab<task, Fetch::rows, Real, Arch>,
           &compute_slab<task, Fetch::rows_and_constants, Real, Arch>}};
}

template <class Real, class Arch> Kernels<Real> kernels_for(const char* name) noexcept {
  return {.name = name,
          .lanes = static_cast<int>(xsimd::batch<Real, Arch>::size),
          .force = fetching<Task::force, Real, Arch>(),
          .undamped_force = fetching<Task::undamped_force, Real, Arch>(),
          .measured_force = &compute_slab<Task::measured_force, Fetch::nothing, Real, Arch>,
          .measured_undamped_force =
              &compute_slab<Task::measured_undamped_force, Fetch::nothing, Real, Arch>,
          .step = fetching<Task::step, Real, Arch>(),
          .undamped_step = fetching<Task::undamped_step, Real, Arch>(),
          .damping = &compute_slab<Task::damping, Fetch::nothing, Real, Arch>,
          .energy = &compute_slab<Task::energy, Fetch::nothing, Real, Arch>,
          .roots_and_quotients = &roots_and_quotients<Real, Arch>};
}

}  // namespace palpate::lattice
