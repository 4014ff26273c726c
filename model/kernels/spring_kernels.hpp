// SPDX-License-Identifier: MIT
#pragma once
/// Loops over single springs, for the printed forms and for pairs of fixed nodes when nothing is
/// skipped. Each equals NetworkProblem::force to rounding; tests compare the kernels of adjacency
/// groups with them.

#include <span>
#include <vector>

#include "model/kernels/kernel_views.hpp"
#include "model/kernels/system.hpp"
#include "model/problem/spring_law.hpp"

namespace palpate {

/// A spring between two free nodes; a and b are first coordinates.
template <class Real> struct Link {
  int a;
  int b;
  Real stiffness;
  Real viscosity;
  Real rest_length;
};

/// A spring from a free node to a place that never moves; b is where that place's coordinates are,
/// or would be, behind those of the free nodes.
template <class Real> struct Anchor {
  int a;
  int b;
  Real stiffness;
  Real viscosity;
  Real rest_length;
  Real place[3];
};

template <class Real> struct SpringSet {
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

template <class Real> SpringKernel<Real> spring_kernel_for(KernelTraits traits) noexcept;

/// Adds -C(q) w.
template <class Real>
void add_damping(const SpringSet<Real>& springs, const Real* q, const Real* w, Real* f) noexcept;

// The springs of a list, gathered by nodes, so that as many as a register holds are computed at
// once. Equals spring_kernel_for() of the physical law to rounding.

/// All that this processor can run, the best first.
template <class Real> std::vector<adjacency::Kernels<Real>> adjacency_kernels();

template <class Real> class AdjacencySprings {
 public:
  explicit AdjacencySprings(
      const adjacency::Kernels<Real>& kernels = adjacency_kernels<Real>().front())
      : kernels_(kernels) {}
  /// Links and anchors; without their dampers unless `damped`. Vectors have `spacing` numbers for
  /// each node: adjacency::node_stride with places that never move behind the free nodes, read and
  /// written as they lie; or 3 and no such places, copied to padded vectors and back at every
  /// evaluation. Allocates.
  void take(const SpringSet<Real>& springs, bool damped, int spacing);
  [[nodiscard]] bool empty() const { return groups_.empty(); }
  /// Adds the forces of all springs to f.
  void add(const Real* q, const Real* v, Real* f) noexcept { add_with(force_, q, v, f); }
  /// add(), and returns the springs' energy [J].
  double measure(const Real* q, const Real* v, Real* f) noexcept {
    return add_with(measured_force_, q, v, f);
  }
  /// For padded vectors; see adjacency::Move.
  [[nodiscard]] double advance(const adjacency::Move<Real>& move, long nodes) const noexcept {
    return kernels_.advance(move, nodes);
  }
  [[nodiscard]] std::size_t memory_bytes() const {
    return groups_.size() * sizeof(adjacency::Group) + partners_.size() * sizeof(int) +
           (numbers_.size() + q_.size() + v_.size() + f_.size()) * sizeof(Real);
  }

 private:
  /// A spring as one of its ends sees it.
  struct Member {
    int partner;  ///< a node
    Real stiffness;
    Real viscosity;
    Real rest_length;
  };
  void add_group(int node, std::span<const Member> members);
  /// PaddedVectors of one's own, for vectors without.
  void make_padded(const SpringSet<Real>& springs);
  double add_with(adjacency::Force<Real> kernel, const Real* q, const Real* v, Real* f) noexcept;

  adjacency::Kernels<Real> kernels_;
  bool damped_ = true;
  adjacency::Force<Real> force_ = nullptr;
  adjacency::Force<Real> measured_force_ = nullptr;
  std::vector<adjacency::Group> groups_;
  std::vector<int> partners_;
  AlignedVector<Real> numbers_;
  long free_nodes_ = 0;
  AlignedVector<Real> q_, v_,
      f_;  ///< free nodes, then places that never move; empty where the vectors are padded
};

}  // namespace palpate
