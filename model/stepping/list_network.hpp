// SPDX-License-Identifier: MIT
#pragma once
/// Any network at all: free nodes one after the other, springs in lists, and the matrices that implicit schemes
/// ask for.

#include "model/stepping/network_system.hpp"
#include "model/stepping/spring_fans.hpp"
#include "model/stepping/spring_matrices.hpp"

namespace palpate {

/// What the vectors of a list hold: free nodes one after the other, and behind them one of the following.
struct ListVectors {
  bool quads = false;  ///< a zero after each node's coordinates, and places that never move behind all: as springs in
                       ///< fans want them, and no matrix does
  Eigen::Index further = 0;  ///< coordinates of whose masses a derived class tells
};

template <class Real>
class ListNetwork : public NetworkSystem<Real> {
 public:
  /// skip = false computes what the scene does not need, to the same bits.
  ListNetwork(const NetworkProblem& problem, const PrintedForm& printed, double h, bool skip,
              const ListVectors& vectors = {});

  void damping(const Vector<Real>& q, const Vector<Real>& w, Vector<Real>& f) noexcept override;
  [[nodiscard]] bool has_dampers() const override { return damped_; }
  /// Of forces, and of places and velocities: with quads.
  [[nodiscard]] bool has_one_pass() const override { return spacing_ == fans::quad; }
  void prepare_one_pass() override;
  double one_pass(double t, double gate, Real h, State<Real>& state) noexcept override;
  void jacobian(const Vector<Real>& q, const Vector<Real>& v, Real on_damping, Real on_stiffness,
                Eigen::SparseMatrix<Real>& a) noexcept override;
  void pattern(Eigen::SparseMatrix<Real>& a) override;
  [[nodiscard]] Vector<Real> initial_position() const override;

 protected:
  void add_springs(const Vector<Real>& q, const Vector<Real>& v, Vector<Real>& f) noexcept override;
  double measure_springs(const Vector<Real>& q, const Vector<Real>& v, Vector<Real>& f) noexcept override;
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
  SpringFans<Real> fans_{};  ///< the same springs, unless they pull as printed
  SpringKernel<Real> kernel_ = nullptr;
  bool damped_ = true;
  Vector<Real> next_force_;  ///< between two steps in one pass: the weight [N]
  SpringSet<Real> fixed_pairs_;  ///< only without skipping
  Vector<Real> fixed_q_, fixed_v_, fixed_f_;
  SpringMatrices<Real> matrices_;
};

}  // namespace palpate
