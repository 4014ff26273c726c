// SPDX-License-Identifier: MIT
#pragma once
/// The loops over springs one by one: of the printed forms, and of the physical law between fixed nodes that nothing
/// leaves out. Each equals the specification (NetworkProblem::force) to rounding, and springs in fans are compared with
/// them.

#include <vector>

#include "model/dynamics/spring_force.hpp"

namespace palpate {

/// A spring between two free nodes; a and b are first coordinates.
template <class Real>
struct Link {
  int a;
  int b;
  Real stiffness;
  Real viscosity;
  Real rest_length;
};

/// A spring from a free node to a place that never moves; b is where that place's coordinates are, or would be, behind
/// those of the free nodes.
template <class Real>
struct Anchor {
  int a;
  int b;
  Real stiffness;
  Real viscosity;
  Real rest_length;
  Real place[3];
};

template <class Real>
struct SpringSet {
  std::vector<Link<Real>> links;
  std::vector<Anchor<Real>> anchors;
  SpringLaw law{};                      ///< of the printed kernels only
  bool lagged = false;                  ///< printed Eq. 9
  std::vector<Real> previous_length{};  ///< links, then anchors; lagged only
  Real lag = Real(1);                   ///< [s] between two evaluations; lagged only
};

/// Adds all spring forces; f is not cleared.
template <class Real>
using SpringKernel = void (*)(SpringSet<Real>& springs, const Real* q, const Real* v,
                              Real* f) noexcept;

struct KernelTraits {
  bool damped = true;
  bool printed = false;  ///< any erratum of the force law
};

template <class Real>
SpringKernel<Real> spring_kernel_for(KernelTraits traits) noexcept;

/// Adds -C(q) w.
template <class Real>
void add_damping(const SpringSet<Real>& springs, const Real* q, const Real* w, Real* f) noexcept;

}  // namespace palpate
