// SPDX-License-Identifier: MIT
#pragma once
/// A network as an integrator sees it: free nodes only, springs split into links and anchors, the
/// kernel picked for what the scene needs.

#include <array>
#include <cstdint>

#include "model/dynamics/problem.hpp"
#include "model/stepping/spring_kernels.hpp"
#include "model/stepping/system.hpp"

namespace palpate {

template <class Real>
class NetworkSystem final : public System<Real> {
 public:
  /// skip = false computes what the scene does not need, to the same bits.
  NetworkSystem(const NetworkProblem& problem, const PrintedForm& printed, double h, bool skip);

  void force(double t, double gate, const Vector<Real>& q, const Vector<Real>& v,
             Vector<Real>& f) noexcept override;
  void add_loads(double t, double gate, Real weight, Vector<Real>& f) noexcept override;
  void damping(const Vector<Real>& q, const Vector<Real>& w, Vector<Real>& f) noexcept override;
  void jacobian(const Vector<Real>& q, const Vector<Real>& v, Real on_damping, Real on_stiffness,
                Eigen::SparseMatrix<Real>& a) noexcept override;
  void pattern(Eigen::SparseMatrix<Real>& a) override;

  [[nodiscard]] double energy(const Vector<Real>& q, const Vector<Real>& v) const noexcept;
  [[nodiscard]] int zero_length_springs(const Vector<Real>& q) const noexcept;
  [[nodiscard]] std::size_t spring_count() const {
    return springs_.links.size() + springs_.anchors.size() + between_fixed_.size();
  }
  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  struct LoadOnCoordinate {
    int load;
    int coordinate;
  };
  void sort_springs(const NetworkProblem& problem, bool skip);
  void add_block(Real* values, const std::int64_t* columns, Real factor,
                 const Eigen::Matrix<Real, 3, 3>& block) const noexcept;

  SpringSet<Real> springs_;
  SpringKernel<Real> kernel_ = nullptr;
  bool damped_ = true;
  std::vector<Load> loads_;
  std::vector<LoadOnCoordinate> loaded_;
  bool weighs_ = false;
  Vector<Real> weight_;                      ///< m g per coordinate [N]; empty without gravity
  Eigen::Vector3d gravity_;
  SpringSet<Real> fixed_pairs_;              ///< only without skipping
  std::vector<Spring> between_fixed_;        ///< likewise
  Vector<Real> fixed_q_, fixed_v_, fixed_f_;
  /// Index of the first row of each of the three columns of blocks (a,a) (b,b) (a,b) (b,a), then
  /// of the anchors' (a,a); made by pattern().
  std::vector<std::array<std::int64_t, 12>> link_slots_;
  std::vector<std::array<std::int64_t, 3>> anchor_slots_;
  std::vector<std::int64_t> diagonal_slots_;
};

}  // namespace palpate
