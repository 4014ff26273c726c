// SPDX-License-Identifier: MIT
#pragma once
/// The loop over the springs of a regular lattice, without indices, for one instruction set
/// (model/EQUATIONS.md, "Lattice in lanes"). Included by one source file per instruction set; includes
/// no code that other files compile too, so that no instruction strays.

#include <xsimd/xsimd.hpp>

#include "model/stepping/fused.hpp"
#include "model/stepping/lattice_view.hpp"
#include "model/stepping/spring_length.hpp"

namespace palpate::lattice {

/// A step is one of semi-implicit Euler in the same pass: a row whose springs have all been gone through
/// moves, and its forces begin anew, while later rows still stand where they were. Fetching steps ask memory for the
/// rows to come, which pays where a lattice outgrows the caches.
enum class Task {
  force,
  undamped_force,
  measured_force,
  measured_undamped_force,
  step,
  undamped_step,
  fetching_step,
  fetching_undamped_step,
  damping,
  energy
};

constexpr bool fetches(Task task) { return task == Task::fetching_step || task == Task::fetching_undamped_step; }
constexpr bool sees_velocity(Task task) {
  return task == Task::force || task == Task::measured_force || task == Task::step || task == Task::fetching_step ||
         task == Task::damping;
}
constexpr bool measures_energy(Task task) {
  return task == Task::measured_force || task == Task::measured_undamped_force || task == Task::energy;
}
constexpr bool takes_step(Task task) {
  return task == Task::step || task == Task::undamped_step || fetches(task);
}

/// Vector `i` of a node row against one vector of a neighbour's: what their springs do.
template <Task task, class Real, class Arch>
class RowVector {
 public:
  using Batch = xsimd::batch<Real, Arch>;
  static constexpr long lanes = static_cast<long>(Batch::size);

  /// Vector that begins at element `i` of a row; `force_stride` in a step.
  RowVector(const Nodes<Real>& row, long i, long force_stride) noexcept
      : own_(row), place_(i), force_stride_(takes_step(task) ? force_stride : row.stride) {
    for (int c = 0; c < 3; ++c) {
      position_[c] = load(row.q + i + c * row.stride);
      if constexpr (sees_velocity(task)) { velocity_[c] = load(row.v + i + c * row.stride); }
    }
  }
  /// The vector at element `i` of another row; `constants` of these springs, `rest` their length.
  void join(const Nodes<Real>& row, long i, const Real* constants, Real rest) noexcept {
    const Real* q = row.q + i;
    const Batch dx = load(q) - position_[0];
    const Batch dy = load(q + row.stride) - position_[1];
    const Batch dz = load(q + 2 * row.stride) - position_[2];
    const Batch square = fused::add(dz, dz, fused::add(dy, dy, dx * dx));
    const SpringLengths<Real, Arch> lengths(square, View<Real>::zero_length);
    SpringNumbers<Batch> spring{.stiffness = Batch(Real(0)), .rest = Batch(rest), .viscosity = Batch(Real(0))};
    if constexpr (task != Task::damping) { spring.stiffness = load(constants); }
    if constexpr (measures_energy(task)) {
      const Batch extension = lengths.length() - spring.rest;
      energy_ = fused::add(spring.stiffness * extension, extension, energy_);
    }
    if constexpr (task == Task::energy) { return; }
    Batch factor;
    if constexpr (sees_velocity(task)) {
      const Real* v = row.v + i;
      const Batch wx = load(v) - velocity_[0];
      const Batch wy = load(v + row.stride) - velocity_[1];
      const Batch wz = load(v + 2 * row.stride) - velocity_[2];
      spring.viscosity = load(constants + lanes);
      factor = lengths.pull(spring, fused::add(wz, dz, fused::add(wy, dy, wx * dx)));
    } else {
      factor = lengths.pull(spring);
    }
    Real* f = row.f + i;
    pull(0, f, factor, dx);
    pull(1, f + force_stride(row), factor, dy);
    pull(2, f + 2 * force_stride(row), factor, dz);
  }
  void finish() noexcept {
    if constexpr (task != Task::energy) {
      for (int c = 0; c < 3; ++c) {
        Real* to = own_.f + place_ + c * force_stride(own_);
        (load(to) + force_[c]).store_unaligned(to);
      }
    }
  }
  [[nodiscard]] Real energy() const noexcept { return Real(0.5) * xsimd::hadd(energy_); }

 private:
  /// The compiler is to see where it is the stride of all else.
  long force_stride(const Nodes<Real>& row) const noexcept {
    if constexpr (takes_step(task)) { return force_stride_; }
    return row.stride;
  }
  static Batch load(const Real* from) noexcept { return Batch::load_unaligned(from); }
  void pull(int c, Real* f, const Batch& factor, const Batch& d) noexcept {
    force_[c] = fused::add(factor, d, force_[c]);
    fused::subtract(factor, d, load(f)).store_unaligned(f);
  }

  const Nodes<Real>& own_;
  long place_;
  long force_stride_;
  Batch position_[3]{};
  Batch velocity_[3]{};
  Batch force_[3]{Batch(Real(0)), Batch(Real(0)), Batch(Real(0))};
  Batch energy_ = Batch(Real(0));
};

/// From element `begin` on, forces from `force_begin`. What a task does not need stays null. `Arch` in what follows
/// makes functions of this instruction set alone.
template <Task task, class Arch, class Real>
Nodes<Real> from_element(const Nodes<Real>& nodes, long begin, long force_begin) noexcept {
  Nodes<Real> row{.q = nodes.q + begin, .stride = nodes.stride};
  if constexpr (sees_velocity(task)) { row.v = nodes.v + begin; }
  if constexpr (task != Task::energy) { row.f = nodes.f + force_begin; }
  return row;
}

/// Where the forces of a layer's first row begin.
template <Task task, class Arch, class Real>
long force_begin(const View<Real>& view, const Fields<Real>& fields, int layer, long row_length) noexcept {
  const int kept = takes_step(task) && fields.force_layers > 0 ? layer % fields.force_layers : layer;
  return view.lead + static_cast<long>(kept) * view.rows1 * row_length;
}

/// The rows that a row's springs lead to.
template <class Arch, class Real>
struct Neighbours {
  int count = 0;
  bool own = false;  ///< springs within the row
  struct Row {
    Nodes<Real> at;
    long slot;
    bool sides;
    Real rest[2];  ///< straight across, and to the sides
  } rows[neighbour_kinds];
};

template <Task task, class Arch, class Real>
Neighbours<Arch, Real> neighbours_of(const View<Real>& view, const Slab<Real>& slab, const Nodes<Real>& all,
                                     const long (&layers)[2], const long (&forces)[2], int row1, int row2,
                                     long row_length) noexcept {
  Neighbours<Arch, Real> found;
  const unsigned char* const own = view.row_moves + static_cast<long>(row2) * view.rows1 + row1;
  const bool below = slab.below != nullptr;
  found.own = *own != 0 && view.own_springs && !below;
  const Links& links = view.links[row1 == 0 ? 0 : row1 + 1 < view.rows1 ? 1 : 2];
  const int end = row2 + 1 < view.rows2 ? links.count : links.within;
  for (int n = below ? links.within : 0; n < end; ++n) {
    const Link& link = links.to[n];
    if (*own == 0 && own[link.rows] == 0) { continue; }
    const long in_layer = row1 * row_length + link.elements;
    const bool copy = row2 + link.layers == slab.end && slab.beyond != nullptr;
    found.rows[found.count++] = {copy ? from_element<task, Arch>(*slab.beyond, in_layer, in_layer)
                                      : from_element<task, Arch>(all, layers[link.layers] + in_layer,
                                                                 forces[link.layers] + in_layer),
                                 link.slot,
                                 link.sides,
                                 {view.rest[link.spans], view.rest[link.spans + 1]}};
  }
  return found;
}

/// v += h f / m, x += h v, f = 0 of the row that begins at element `begin`, whose forces are at `f`; returns the sum of
/// squares of v.
template <class Arch, class Real>
double move_row(const View<Real>& view, const Fields<Real>& fields, long begin, Real* f, long row_length) noexcept {
  using Batch = xsimd::batch<Real, Arch>;
  const Move<Real>& move = *fields.move;
  const Batch h(move.h);
  Batch squares(Real(0));
  for (long i = 0; i < row_length; i += static_cast<long>(Batch::size)) {
    const Batch inverse_mass = Batch::load_unaligned(move.inverse_mass + begin + i);
    for (long c = 0; c < 3; ++c) {
      const long at = begin + i + c * view.stride;
      Real* force = f + i + c * fields.force_stride;
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
    sum += move_row<Arch>(view, fields, view.lead + row * row_length, f + row1 * row_length, row_length);
  }
  return sum;
}

/// Asks memory for a vector of the row after the next that this row's springs lead to, and for masses of the next row:
/// more streams than processors foresee. `own` is the vector's first element and `next` that of the same one a layer
/// further on. Always inline: g++ 12 leaves a call out that does nothing else.
template <Task task, class Arch, class Real>
[[gnu::always_inline]] inline void fetch_ahead(const View<Real>& view, const Fields<Real>& fields, long own, long next,
                                               long row_length) noexcept {
  const long ahead = next + 2 * row_length;
  for (long c = 0; c < 3; ++c) {
    __builtin_prefetch(fields.q + ahead + c * view.stride);
    if constexpr (sees_velocity(task)) { __builtin_prefetch(fields.v + ahead + c * view.stride); }
  }
  __builtin_prefetch(fields.move->inverse_mass + own + row_length);
}

template <Task task, class Real, class Arch>
double go_through(const View<Real>& view, const Slab<Real>& slab, const Fields<Real>& fields) noexcept {
  using Vector = RowVector<task, Real, Arch>;
  constexpr long lanes = Vector::lanes;
  const long row_length = view.vectors * lanes;
  const long slot_length = lanes * view.numbers;
  const Nodes<Real> all{fields.q, fields.v, fields.f, view.stride};
  double sum = 0.0;
  for (int row2 = slab.begin; row2 < slab.end; ++row2) {
    const long layer_length = view.rows1 * row_length;
    const long layers[2] = {view.lead + row2 * layer_length, view.lead + (row2 + 1) * layer_length};
    const long forces[2] = {force_begin<task, Arch>(view, fields, row2, row_length),
                            force_begin<task, Arch>(view, fields, row2 + 1, row_length)};
    for (int row1 = 0; row1 < view.rows1; ++row1) {
      const auto near = neighbours_of<task, Arch>(view, slab, all, layers, forces, row1, row2, row_length);
      const long row = static_cast<long>(row2) * view.rows1 + row1;
      const long begin = layers[0] + row1 * row_length;
      const bool joined = near.count > 0 || near.own;
      const long own_forces = forces[0] + row1 * row_length;
      const Nodes<Real> own = slab.below != nullptr
                                  ? from_element<task, Arch>(*slab.below, row1 * row_length, row1 * row_length)
                                  : from_element<task, Arch>(all, begin, own_forces);
      const Real* table = view.tables + view.row_table[row];
      for (long i = 0; joined && i < view.vectors; ++i) {
        if constexpr (fetches(task)) {
          const long next = row2 + 2 < view.rows2 ? layers[1] - layers[0] : 0;  // beyond the last there is nothing
          fetch_ahead<task, Arch>(view, fields, begin + i * lanes, begin + i * lanes + next, row_length);
        }
        // The piece's last node is beside the next piece's first: the same vector, one lane on.
        const long right = i + 1 < view.vectors ? (i + 1) * lanes : 1;
        const long left = i > 0 ? (i - 1) * lanes : (view.vectors - 1) * lanes - 1;
        const Real* constants = table + i * slots * slot_length;
        Vector vector(own, i * lanes, fields.force_stride);
        if (near.own) { vector.join(own, right, constants, view.rest[0]); }
        for (int n = 0; n < near.count; ++n) {
          const auto& there = near.rows[n];
          const Real* slot = constants + there.slot * slot_length;
          if (there.sides) { vector.join(there.at, left, slot, there.rest[1]); }
          vector.join(there.at, i * lanes, slot + slot_length, there.rest[0]);
          if (there.sides) { vector.join(there.at, right, slot + 2 * slot_length, there.rest[1]); }
        }
        vector.finish();
        if constexpr (measures_energy(task)) { sum += static_cast<double>(vector.energy()); }
      }
      if constexpr (takes_step(task)) {
        if (slab.below == nullptr && !view.folded && view.row_moves[row] != 0) {
          sum += move_row<Arch>(view, fields, begin, fields.f + own_forces, row_length);
        }
      }
    }
    if constexpr (takes_step(task)) {
      if (slab.below == nullptr && view.folded) {
        sum += move_layer<Arch>(view, fields, row2, fields.f + forces[0], row_length);
      }
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

template <class Real, class Arch>
Kernels<Real> kernels_for(const char* name) noexcept {
  return {.name = name,
          .lanes = static_cast<int>(xsimd::batch<Real, Arch>::size),
          .force = &go_through<Task::force, Real, Arch>,
          .undamped_force = &go_through<Task::undamped_force, Real, Arch>,
          .measured_force = &go_through<Task::measured_force, Real, Arch>,
          .measured_undamped_force = &go_through<Task::measured_undamped_force, Real, Arch>,
          .step = &go_through<Task::step, Real, Arch>,
          .undamped_step = &go_through<Task::undamped_step, Real, Arch>,
          .fetching_step = &go_through<Task::fetching_step, Real, Arch>,
          .fetching_undamped_step = &go_through<Task::fetching_undamped_step, Real, Arch>,
          .damping = &go_through<Task::damping, Real, Arch>,
          .energy = &go_through<Task::energy, Real, Arch>,
          .roots_and_quotients = &roots_and_quotients<Real, Arch>};
}

}  // namespace palpate::lattice
