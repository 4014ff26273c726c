// SPDX-License-Identifier: MIT
#pragma once
/// What the kernels of springs in fans see, and the kernels that this machine can run.

namespace palpate::fans {

/// The springs of one free node that lead to nodes after it, and those to places that never move: groups of
/// as many springs as there are lanes, filled up with springs of no stiffness back to the node itself.
struct Fan {
  int node = 0;     ///< its first coordinate
  int links = 0;    ///< groups
  int anchors = 0;  ///< groups
};

/// Numbers of a group, one vector after the other.
inline constexpr int link_numbers = 3;    ///< stiffness, viscosity, rest length
inline constexpr int anchor_numbers = 6;  ///< and the place

template <class Real>
struct View {
  static constexpr Real zero_length = Real(1e-12);  ///< as in spring_force.hpp [m]
  const Fan* fans = nullptr;
  long count = 0;
  const int* partners = nullptr;   ///< first coordinates, by groups of links
  const Real* numbers = nullptr;   ///< of each fan's links, then of its anchors
};

template <class Real>
struct Kernels {
  const char* name = "";
  int lanes = 1;
  /// Adds the forces of springs and dampers to f.
  void (*force)(const View<Real>& view, const Real* q, const Real* v, Real* f) noexcept = nullptr;
  /// The same to the same bits, and returns the springs' energy [J].
  double (*measured_force)(const View<Real>& view, const Real* q, const Real* v, Real* f) noexcept = nullptr;
};

template <class Real>
Kernels<Real> baseline_kernels() noexcept;
/// Only where the processor has AVX2 and FMA.
template <class Real>
Kernels<Real> avx2_kernels() noexcept;
/// Only where the processor has AVX-512.
template <class Real>
Kernels<Real> avx512_kernels() noexcept;

}  // namespace palpate::fans
