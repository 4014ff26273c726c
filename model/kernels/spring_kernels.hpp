// SPDX-License-Identifier: MIT
#pragma once
/// Springs of a list: loops over single springs, for the printed forms and for dampers, and
/// adjacency groups, which fill SIMD registers. All equal NetworkProblem::force to rounding error.

#include <span>
#include <vector>

#include "model/kernels/kernel_views.hpp"
#include "model/kernels/system.hpp"
#include "model/problem/spring_law.hpp"
#include "model/problem/spring_network.hpp"

namespace palpate {

/// Spring between two free nodes; a and b are first coordinates.
template <class Real> using Link = SpringOf<Real>;

/// Spring from a free node to a fixed point, whose coordinates follow those of the free nodes at b.
template <class Real> struct Anchor : SpringOf<Real> { Real place[3]{}; };

template <class Real> struct SpringSet {
  std::vector<Link<Real>> links;
  std::vector<Anchor<Real>> anchors;
  SpringLaw law{};                      ///< adjacency groups compute the corrected law only
  bool lagged = false;                  ///< printed Eq. 9
  std::vector<Real> previous_length{};  ///< links, then anchors; used if `lagged`
  Real lag = Real(1);                   ///< time between two evaluations; used if `lagged` [s]
};

/// Calls visit(index, spring, b, d, w) for the links and then the anchors. b is the first
/// coordinate of the other end, or -1 for a fixed point; d = x_b - x_a [m] and w = v_b - v_a [m/s].
template <class Real, class Visit>
void for_each_spring(const SpringSet<Real>& springs, const Real* q, const Real* v, Visit visit) {
  using Vector3 = Eigen::Matrix<Real, 3, 1>;
  using Three = Eigen::Map<const Vector3>;
  std::size_t index = 0;
  for (const Link<Real>& s : springs.links) {
    visit(index++, s, s.b, Vector3(Three(q + s.b) - Three(q + s.a)),
          Vector3(Three(v + s.b) - Three(v + s.a)));
  }
  for (const Anchor<Real>& s : springs.anchors) {
    visit(index++, s, -1, Vector3(Three(s.place) - Three(q + s.a)), Vector3(-Three(v + s.a)));
  }
}

/// Adds all spring forces of the law, printed or corrected, to f.
template <class Real>
void add_forces(SpringSet<Real>& springs, const Real* q, const Real* v, Real* f) noexcept;
/// Adds -C(q) w to f.
template <class Real>
void add_damping(const SpringSet<Real>& springs, const Real* q, const Real* w, Real* f) noexcept;

/// Returns all kernels that this processor supports, widest first.
template <class Real> std::vector<adjacency::Kernels<Real>> adjacency_kernels();
template <> std::vector<adjacency::Kernels<double>> adjacency_kernels();
template <> std::vector<adjacency::Kernels<float>> adjacency_kernels();

template <class Real> class AdjacencySprings {
 public:
  explicit AdjacencySprings(
      const adjacency::Kernels<Real>& kernels = adjacency_kernels<Real>().front())
      : kernels_(kernels) {}
  /// Groups the links and anchors that have this law; includes dampers only if `damped`. Vectors
  /// have `spacing` numbers per node: adjacency::node_stride, with the fixed points after the free
  /// nodes, or 3, without fixed points; each evaluation then copies to padded vectors and back.
  /// Allocates.
  void take(const SpringSet<Real>& springs, bool damped, int spacing, int law = 0);
  [[nodiscard]] bool empty() const { return groups_.empty(); }
  /// Adds the forces of all springs to f.
  void add(const Real* q, const Real* v, Real* f) noexcept { add_with(force_, q, v, f); }
  /// Adds the forces of all springs to f and returns the elastic energy [J].
  double measure(const Real* q, const Real* v, Real* f) noexcept {
    return add_with(measured_force_, q, v, f);
  }
  /// Returns the lane that computes a spring of the set, counted over all batches; -1 for a spring
  /// that has another law. Only for springs with a law.
  [[nodiscard]] int lane_of(std::size_t spring) const { return lane_of_[spring]; }
  /// Returns the number of lanes of all batches.
  [[nodiscard]] std::size_t lanes() const { return lanes_; }
  /// Adds the forces of springs with a law; `law` has what a View has for them.
  void add_law(const adjacency::View<Real>& law, const Real* q, const Real* v, Real* f) noexcept {
    add_with(kernels_.of_law, q, v, f, law);
  }
  /// Writes the elastic tension of every lane [N] to law.tension.
  void find_tensions(const adjacency::View<Real>& law, const Real* q) noexcept {
    add_with(kernels_.tension_of_law, q, nullptr, nullptr, law);
  }
  /// Advances padded vectors by one step; see adjacency::Move.
  [[nodiscard]] double advance(const adjacency::Move<Real>& move, long nodes) const noexcept {
    return kernels_.advance(move, nodes);
  }
  [[nodiscard]] std::size_t memory_bytes() const {
    return groups_.size() * sizeof(adjacency::Group) +
           (partners_.size() + lane_of_.size()) * sizeof(int) +
           (numbers_.size() + q_.size() + v_.size() + f_.size()) * sizeof(Real);
  }

 private:
  /// Adds the group of a node with springs from it to nodes b.
  void add_group(int node, std::span<const Link<Real>> members);
  /// Allocates padded vectors for callers without padded vectors.
  void make_padded(const SpringSet<Real>& springs);
  /// Calls a kernel with the view `of_law` after adding the groups to it. Null forces are not
  /// added.
  double add_with(adjacency::Force<Real> kernel, const Real* q, const Real* v, Real* f,
                  adjacency::View<Real> of_law = {}) noexcept;

  adjacency::Kernels<Real> kernels_;
  bool damped_ = true;
  adjacency::Force<Real> force_ = nullptr;
  adjacency::Force<Real> measured_force_ = nullptr;
  std::vector<adjacency::Group> groups_;
  std::vector<int> partners_;
  std::vector<int> lane_of_{};
  std::size_t lanes_ = 0;
  AlignedVector<Real> numbers_;
  long free_nodes_ = 0;
  /// Free nodes, then fixed points; empty if the caller's vectors are padded.
  AlignedVector<Real> q_, v_, f_;
};

}  // namespace palpate
