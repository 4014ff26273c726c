// SPDX-License-Identifier: MIT
#pragma once
/// What the kernels of springs in fans see, and the kernels that this machine can run.

namespace palpate::fans {

/// Springs that one free node answers for: groups of as many as there are lanes, filled up with springs of no stiffness
/// back to the node itself.
struct Fan {
  int node = 0;  ///< where its state begins
  int groups = 0;
};

/// Numbers of a node's place, velocity or force: x, y, z and a zero, which fill a register together.
inline constexpr int quad = 4;
/// Numbers of a node: its place, and next to it its velocity.
inline constexpr int node_numbers(bool damped) { return damped ? 2 * quad : quad; }
/// Numbers of a group, one vector after the other: stiffness, rest length and viscosity.
inline constexpr int group_numbers(bool damped) { return damped ? 3 : 2; }

/// Free nodes come first, in the order of their coordinates, three each; places that never move come after them.
template <class Real>
struct View {
  static constexpr Real zero_length = Real(1e-12);  ///< as in spring_force.hpp [m]
  const Fan* fans = nullptr;
  long count = 0;
  const int* partners = nullptr;  ///< where the states of the other ends begin, by groups
  const Real* numbers = nullptr;  ///< by groups
  long free_nodes = 0;
  long nodes = 0;
  Real* states = nullptr;  ///< node_numbers() of each node; those of free nodes are written
  Real* forces = nullptr;  ///< `quad` numbers of each node; written
};

/// Adds the forces of springs, and of dampers if there are any, to f.
template <class Real>
using Force = void (*)(const View<Real>& view, const Real* q, const Real* v, Real* f) noexcept;
/// The same to the same bits, and returns the springs' energy [J].
template <class Real>
using MeasuredForce = double (*)(const View<Real>& view, const Real* q, const Real* v, Real* f) noexcept;

template <class Real>
struct Kernels {
  const char* name = "";
  int lanes = 1;
  Force<Real> damped = nullptr;
  MeasuredForce<Real> damped_measured = nullptr;
  Force<Real> undamped = nullptr;
  MeasuredForce<Real> undamped_measured = nullptr;
};

template <class Real>
Kernels<Real> baseline_kernels() noexcept;
/// Only where the processor has AVX2 and FMA. Longer registers gained nothing (docs/bench.md).
template <class Real>
Kernels<Real> avx2_kernels() noexcept;

}  // namespace palpate::fans
