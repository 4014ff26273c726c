// SPDX-License-Identifier: MIT
#pragma once
/// What the kernels of springs in fans see, and the kernels that this machine can run.

namespace palpate::fans {

/// Springs that one free node answers for: groups of as many as there are lanes, filled up with springs of no stiffness
/// back to the node itself.
struct Fan {
  int node = 0;  ///< its first coordinate
  int groups = 0;
};

/// Numbers of a node in every vector: x, y, z and a zero, which fill a register together.
inline constexpr int quad = 4;
/// Numbers of a group, one vector after the other: stiffness, rest length and viscosity.
inline constexpr int group_numbers(bool damped) { return damped ? 3 : 2; }
/// Whose numbers and partners memory is asked for, that many groups before they are gone through; as many follow the
/// last one.
inline constexpr int groups_ahead = 24;

template <class Real>
struct View {
  const Fan* fans = nullptr;
  long count = 0;
  const int* partners = nullptr;  ///< first coordinates of the other ends, by groups
  const Real* numbers = nullptr;  ///< by groups
};

/// Adds the forces of springs, and of dampers if there are any, to f. Vectors have a quad for each node, and for each
/// place that never moves, on which forces are written too. Those that measure do the same to the same bits and return
/// the springs' energy [J], the others 0.
template <class Real>
using Force = double (*)(const View<Real>& view, const Real* q, const Real* v, Real* f) noexcept;
/// Quads of nodes from vectors with three numbers each.
template <class Real>
using Spread = void (*)(const Real* packed, long nodes, Real* quads) noexcept;
/// Adds quads to a vector with three numbers for each node.
template <class Real>
using Collect = void (*)(const Real* quads, long nodes, Real* packed) noexcept;

/// A step of semi-implicit Euler with forces that are known, to the bits of one sweep after another. All have a quad
/// for each node.
template <class Real>
struct Move {
  Real* q = nullptr;
  Real* v = nullptr;
  Real* f = nullptr;                     ///< becomes the weight
  const Real* inverse_mass = nullptr;
  const Real* weight = nullptr;          ///< or zero without
  Real h = Real(0);                      ///< [s]
};
/// Returns the sum of squares of the new velocities.
template <class Real>
using Advance = double (*)(const Move<Real>& move, long nodes) noexcept;

template <class Real>
struct Kernels {
  const char* name = "";
  int lanes = 1;
  Force<Real> damped = nullptr;
  Force<Real> damped_measured = nullptr;
  Force<Real> undamped = nullptr;
  Force<Real> undamped_measured = nullptr;
  Spread<Real> spread = nullptr;
  Collect<Real> collect = nullptr;
  Advance<Real> advance = nullptr;
};

template <class Real>
Kernels<Real> baseline_kernels() noexcept;
/// Only where the processor has AVX2 and FMA. Longer registers gained nothing (docs/bench.md).
template <class Real>
Kernels<Real> avx2_kernels() noexcept;

}  // namespace palpate::fans
