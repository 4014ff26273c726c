// SPDX-License-Identifier: MIT
#pragma once
/// The matrices of springs in lists, as implicit schemes ask for them.

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/SparseCore>

#include "model/stepping/spring_kernels.hpp"
#include "model/stepping/system.hpp"

namespace palpate {

/// Of vectors with three numbers for each node.
template <class Real>
class SpringMatrices {
 public:
  /// a becomes a square matrix of `size` rows with an entry for all that jacobian() may fill, and for `further`, which
  /// are beside the first `of_nodes`. Allocates.
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
    return link_slots_.size() * sizeof(link_slots_[0]) + anchor_slots_.size() * sizeof(anchor_slots_[0]) +
           diagonal_slots_.size() * sizeof(diagonal_slots_[0]);
  }

 private:
  /// Index of the first row of each of the three columns of blocks (a,a) (b,b) (a,b) (b,a), then
  /// of the anchors' (a,a).
  std::vector<std::array<std::int64_t, 12>> link_slots_;
  std::vector<std::array<std::int64_t, 3>> anchor_slots_;
  std::vector<std::int64_t> diagonal_slots_;
};

}  // namespace palpate
