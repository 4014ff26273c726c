// SPDX-License-Identifier: MIT
#pragma once
/// What the springs between two vectors of a regular lattice's nodes do (model/EQUATIONS.md, "Lattice in lanes").
/// Included by one source file per instruction set; includes no code that other files compile too, so that no
/// instruction strays.

#include <xsimd/xsimd.hpp>

#include "model/stepping/always_inline.hpp"
#include "model/stepping/fused.hpp"
#include "model/stepping/lattice_view.hpp"
#include "model/stepping/spring_length.hpp"

namespace palpate::lattice {

/// A step is one of semi-implicit Euler in the same pass: a row whose springs have all been gone through
/// moves, and its forces begin anew, while later rows still stand where they were.
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
  return task == Task::force || task == Task::measured_force || task == Task::step || task == Task::damping;
}
constexpr bool measures_energy(Task task) {
  return task == Task::measured_force || task == Task::measured_undamped_force || task == Task::energy;
}
constexpr bool takes_step(Task task) {
  return task == Task::step || task == Task::undamped_step;
}

/// Vector `i` of a node row against one vector of a neighbour's: what their springs do.
template <Task task, Fetch fetch, class Real, class Arch>
class RowVector {
 public:
  using Batch = xsimd::batch<Real, Arch>;
  using Lengths = SpringLengths<Real, Arch>;
  static constexpr long lanes = static_cast<long>(Batch::size);

  /// Vector that begins at element `i` of a row.
  RowVector(const Nodes<Real>& row, long i) noexcept : own_(row), place_(i) {
    for (int c = 0; c < 3; ++c) {
      position_[c] = load(row.q + i + c * lanes);
      if constexpr (sees_velocity(task)) { velocity_[c] = load(row.v + i + c * lanes); }
    }
  }
  /// Springs to another vector, which are gone through in three stages: begin(), measure() and end().
  struct Springs {
    Batch d[3];  ///< from there to here [m]
    Batch square;
    Batch rate;  ///< of the length, times the length
    Lengths lengths;
    const Real* constants;
    const Real* rest;
    Real* f;  ///< there
  };
  /// To the vector at element `i` of another row; `constants` of these springs, `rest` their length.
  PALPATE_ALWAYS_INLINE void begin(Springs& springs, const Nodes<Real>& row, long i, const Real* constants,
                                   const Real& rest) const noexcept {
    if constexpr (fetch == Fetch::rows_and_constants) { fetch_constants(constants); }
    const Real* q = row.q + i;
    springs.d[0] = position_[0] - load(q);
    springs.d[1] = position_[1] - load(q + lanes);
    springs.d[2] = position_[2] - load(q + 2 * lanes);
    const auto& [dx, dy, dz] = springs.d;
    springs.square = fused::add(dz, dz, fused::add(dy, dy, fused::add(dx, dx, Batch(least_square<Real>))));
    if constexpr (sees_velocity(task)) {
      const Real* v = row.v + i;
      const Batch wx = velocity_[0] - load(v);
      const Batch wy = velocity_[1] - load(v + lanes);
      const Batch wz = velocity_[2] - load(v + 2 * lanes);
      springs.rate = fused::add(wz, dz, fused::add(wy, dy, wx * dx));
    }
    springs.constants = constants;
    springs.rest = &rest;
    if constexpr (task != Task::energy) { springs.f = row.f + i; }
  }
  PALPATE_ALWAYS_INLINE void measure(Springs& springs) const noexcept { springs.lengths = Lengths(springs.square); }
  PALPATE_ALWAYS_INLINE void end(const Springs& springs) noexcept {
    const Lengths& lengths = springs.lengths;
    SpringNumbers<Batch> spring{
        .stiffness = Batch(Real(0)), .rest = Batch(*springs.rest), .viscosity = Batch(Real(0))};
    if constexpr (task != Task::damping) { spring.stiffness = load(springs.constants); }
    if constexpr (measures_energy(task)) {
      const Batch extension = lengths.length() - spring.rest;
      energy_ = fused::add(spring.stiffness * extension, extension, energy_);
    }
    if constexpr (task == Task::energy) { return; }
    Batch factor;
    if constexpr (sees_velocity(task)) {
      spring.viscosity = load(springs.constants + lanes);
      factor = lengths.pull(spring, springs.rate);
    } else {
      factor = lengths.pull(spring);
    }
    pull(0, springs.f, factor, springs.d[0]);
    pull(1, springs.f + lanes, factor, springs.d[1]);
    pull(2, springs.f + 2 * lanes, factor, springs.d[2]);
  }
  PALPATE_ALWAYS_INLINE void join(const Nodes<Real>& row, long i, const Real* constants, const Real& rest) noexcept {
    Springs springs;
    begin(springs, row, i, constants, rest);
    measure(springs);
    end(springs);
  }
  /// Keeps the forces of this vector.
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
  /// Asks the second cache, which can wait for more lines than the first, for those of the vector four further on.
  static void fetch_constants(const Real* constants) noexcept {
    constexpr int second_cache = 2;
    constexpr long numbers = sees_velocity(task) ? 2 : 1;
    const Real* ahead = constants + 4 * slots * numbers * lanes;
    for (long n = 0; n < numbers; ++n) { __builtin_prefetch(ahead + n * lanes, 0, second_cache); }
  }
  static Batch load(const Real* from) noexcept { return Batch::load_unaligned(from); }
  /// `d` leads here from there. With AVX-512 one product serves both ends: Zen 4 adds beside it multiplies, and is
  /// quicker with fewer multiplications. The others take an instruction less.
  void pull(int c, Real* f, const Batch& factor, const Batch& d) noexcept {
    if constexpr (fused::is_avx512<Arch>) {
      const Batch force = factor * d;
      force_[c] = force_[c] - force;
      asm("" : "+v"(force_[c].data));  // g++ 12 would put the subtraction off and run out of registers
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

}  // namespace palpate::lattice
