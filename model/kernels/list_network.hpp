// SPDX-License-Identifier: MIT
#pragma once
/// Network of springs in a list, with the matrices that implicit schemes use.

#include <Eigen/SparseCore>
#include <array>
#include <cstdint>
#include <vector>

#include "model/kernels/network_system.hpp"
#include "model/kernels/spring_kernels.hpp"
#include "model/kernels/system.hpp"

namespace palpate {

/// Of vectors with three numbers for each node.
template <class Real> class SpringMatrices {
 public:
  /// a becomes a square matrix of `size` rows with an entry for all that jacobian() may fill, and
  /// for `further`, which are beside the first `of_nodes`. Allocates.
  void pattern(const SpringSet<Real>& springs, Eigen::Index of_nodes, Eigen::Index size,
               std::vector<Eigen::Triplet<Real>> further, Eigen::SparseMatrix<Real>& a);
  struct At {
    const Vector<Real>& q;
    const Vector<Real>& v;
    Real on_damping;
    Real on_stiffness;
  };
  /// a = M + on_damping C + on_stiffness K of the springs that pattern() was made for.
  void jacobian(const SpringSet<Real>& springs, const At& at, const Vector<Real>& mass,
                Eigen::SparseMatrix<Real>& a) const noexcept;
  [[nodiscard]] std::size_t memory_bytes() const {
    return link_slots_.size() * sizeof(link_slots_[0]) +
           anchor_slots_.size() * sizeof(anchor_slots_[0]) +
           diagonal_slots_.size() * sizeof(diagonal_slots_[0]);
  }

 private:
  /// Index of the first row of each of the three columns of blocks (a,a) (b,b) (a,b) (b,a), then
  /// of the anchors' (a,a).
  std::vector<std::array<std::int64_t, 12>> link_slots_;
  std::vector<std::array<std::int64_t, 3>> anchor_slots_;
  std::vector<std::int64_t> diagonal_slots_;
};

// Any network at all: free nodes one after the other, springs in lists, and the matrices that
// implicit schemes ask for.

/// What the vectors of a list hold: free nodes one after the other, and behind them one of the
/// following.
struct ListVectors {
  bool padded = false;  ///< a zero after each node's coordinates, and places that never move behind
                        ///< all: as springs in fans want them, and no matrix does
  Eigen::Index further = 0;  ///< coordinates of whose masses a derived class tells
};

template <class Real> class ListNetwork : public NetworkSystem<Real> {
 public:
  /// skip = false computes what the scene does not need, to the same bits.
  ListNetwork(const NetworkProblem& problem, const PrintedForm& printed, double h, bool skip,
              const ListVectors& vectors = {});

  void damping(const Vector<Real>& q, const Vector<Real>& w, Vector<Real>& f) noexcept override;
  [[nodiscard]] bool has_dampers() const override { return damped_; }
  /// Of forces, and of places and velocities: with padded vectors.
  [[nodiscard]] bool has_one_pass() const override { return spacing_ == adjacency::node_stride; }
  void prepare_one_pass() override;
  double one_pass(double t, double gate, Real h, State<Real>& state) noexcept override;
  void jacobian(const Vector<Real>& q, const Vector<Real>& v, Real on_damping, Real on_stiffness,
                Eigen::SparseMatrix<Real>& a) noexcept override;
  void pattern(Eigen::SparseMatrix<Real>& a) override;
  [[nodiscard]] Vector<Real> initial_position() const override;

 protected:
  void add_springs(const Vector<Real>& q, const Vector<Real>& v, Vector<Real>& f) noexcept override;
  double measure_springs(const Vector<Real>& q, const Vector<Real>& v,
                         Vector<Real>& f) noexcept override;
  [[nodiscard]] double elastic_energy(const Vector<Real>& q) const noexcept override;
  [[nodiscard]] std::size_t spring_bytes() const noexcept override;
  /// Entries of a pattern() that are not the nodes'.
  virtual void add_entries(std::vector<Eigen::Triplet<Real>>& /*entries*/) const {}

 private:
  void add_fixed_pairs() noexcept;
  static NodeLayout layout_of(const NetworkProblem& problem, const ListVectors& vectors);
  void sort_springs(const NetworkProblem& problem, bool skip);
  void remember_lengths();

  int spacing_;  ///< from one node's coordinates to the next one's
  SpringSet<Real> springs_;
  AdjacencySprings<Real> groups_{};  ///< the same springs, unless they pull as printed
  SpringKernel<Real> kernel_ = nullptr;
  bool damped_ = true;
  Vector<Real> next_force_;      ///< between two steps in one pass: the weight [N]
  SpringSet<Real> fixed_pairs_;  ///< only without skipping
  Vector<Real> fixed_q_, fixed_v_, fixed_f_;
  SpringMatrices<Real> matrices_;
};

}  // namespace palpate
