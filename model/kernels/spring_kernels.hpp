// SPDX-License-Identifier: MIT
#pragma once
/// Loops over single springs, for the printed forms, and for pairs of fixed nodes if nothing is
/// skipped. Each loop equals NetworkProblem::force to rounding error; tests compare the kernels of
/// adjacency groups with them.

#include <span>
#include <vector>

#include "model/kernels/kernel_views.hpp"
#include "model/kernels/system.hpp"
#include "model/problem/spring_law.hpp"

namespace palpate {

/// Spring between two free nodes; a and b are first coordinates.
template <class Real> struct Link {
  int a;
  int b;
  Real stiffness;
  Real viscosity;
  Real rest_length;
};

/// Spring from a free node to a fixed point; b is the index of the fixed point's coordinates after
/// those of the free nodes, whether or not they are stored.
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
  SpringLaw law{};                      ///< used by the printed kernels only
  bool lagged = false;                  ///< printed Eq. 9
  std::vector<Real> previous_length{};  ///< links, then anchors; used if `lagged`
  Real lag = Real(1);                   ///< time between two evaluations; used if `lagged` [s]
};

/// Adds all spring forces to f without clearing it.
template <class Real>
using SpringKernel = void (*)(SpringSet<Real>& springs, const Real* q, const Real* v,
                              Real* f) noexcept;

struct KernelTraits {
  bool damped = true;
  bool printed = false;  ///< any erratum of the force law is selected
};

template <class Real> SpringKernel<Real> spring_kernel_for(KernelTraits traits) noexcept;

/// Adds -C(q) w to f.
template <class Real>
void add_damping(const SpringSet<Real>& springs, const Real* q, const Real* w, Real* f) noexcept;

// Springs of a list in adjacency groups, which fill SIMD registers. The forces equal those of
// spring_kernel_for() of the physical law to rounding error.

/// Returns all kernels that this processor supports, widest first.
template <class Real> std::vector<adjacency::Kernels<Real>> adjacency_kernels();

template <class Real> class AdjacencySprings {
 public:
  explicit AdjacencySprings(
      const adjacency::Kernels<Real>& kernels = adjacency_kernels<Real>().front())
      : kernels_(kernels) {}
  /// Groups the links and anchors; includes dampers only if `damped`. Vectors have `spacing`
  /// numbers per node. With adjacency::node_stride, fixed points follow the free nodes and the
  /// vectors are used in place. With 3, there are no fixed points and each evaluation copies to
  /// padded vectors and back. Allocates.
  void take(const SpringSet<Real>& springs, bool damped, int spacing);
  [[nodiscard]] bool empty() const { return groups_.empty(); }
  /// Adds the forces of all springs to f.
  void add(const Real* q, const Real* v, Real* f) noexcept { add_with(force_, q, v, f); }
  /// Adds the forces of all springs to f and returns the elastic energy [J].
  double measure(const Real* q, const Real* v, Real* f) noexcept {
    return add_with(measured_force_, q, v, f);
  }
  /// Advances padded vectors by one step; see adjacency::Move.
  [[nodiscard]] double advance(const adjacency::Move<Real>& move, long nodes) const noexcept {
    return kernels_.advance(move, nodes);
  }
  [[nodiscard]] std::size_t memory_bytes() const {
    return groups_.size() * sizeof(adjacency::Group) + partners_.size() * sizeof(int) +
           (numbers_.size() + q_.size() + v_.size() + f_.size()) * sizeof(Real);
  }

 private:
  /// Spring in the adjacency group of one of its ends.
  struct Member {
    int partner;  ///< node at the other end
    Real stiffness;
    Real viscosity;
    Real rest_length;
  };
  void add_group(int node, std::span<const Member> members);
  /// Allocates padded vectors for callers without padded vectors.
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
      f_;  ///< free nodes, then fixed points; empty if the caller's vectors are padded
};

}  // namespace palpate
