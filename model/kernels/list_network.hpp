// SPDX-License-Identifier: MIT
#pragma once
/// Network of springs in a list, of any topology, and the matrices of implicit schemes.

#include <Eigen/SparseCore>
#include <array>
#include <cstdint>
#include <vector>

#include "model/kernels/network_system.hpp"
#include "model/kernels/spring_kernels.hpp"
#include "model/kernels/system.hpp"

namespace palpate {

/// Layout of the vectors of a list network.
struct ListVectors {
  /// Padded 4-vectors, fixed points after the free nodes; not available with matrices.
  bool padded = false;
  Eigen::Index further = 0;  ///< additional coordinates, with masses from a derived class
};

template <class Real> class ListNetwork : public NetworkSystem<Real> {
 public:
  /// Builds the network. skip = false computes unnecessary terms too, with identical results.
  ListNetwork(const NetworkProblem& problem, const PrintedForm& printed, double h, bool skip,
              const ListVectors& vectors = {});

  void damping(const Vector<Real>& q, const Vector<Real>& w, Vector<Real>& f) noexcept override;
  [[nodiscard]] bool has_dampers() const override { return damped_; }
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
  /// Adds entries of the pattern that do not belong to nodes.
  virtual void add_entries(std::vector<Eigen::Triplet<Real>>& /*entries*/) const {}

 private:
  void add_fixed_pairs() noexcept;
  static NodeLayout layout_of(const NetworkProblem& problem, const ListVectors& vectors);
  void sort_springs(const NetworkProblem& problem, bool skip);
  void remember_lengths();

  int spacing_;  ///< offset between the coordinates of consecutive nodes
  SpringSet<Real> springs_;
  AdjacencySprings<Real> groups_{};  ///< the same springs, unless a printed form is selected
  bool damped_ = true;
  Vector<Real> next_force_;      ///< weight, between two one-pass steps [N]
  SpringSet<Real> fixed_pairs_;  ///< only with skip = false
  Vector<Real> fixed_q_, fixed_v_, fixed_f_;
  /// Entries of a matrix that a spring changes: the first rows of the three columns of its blocks
  /// (a,a) (b,b) (a,b) (b,a); an anchor has the first block only.
  std::vector<std::array<std::int64_t, 12>> slots_;
  std::vector<std::int64_t> diagonal_slots_;
};

}  // namespace palpate
