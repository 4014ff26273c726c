// SPDX-License-Identifier: MIT
#pragma once
/// A sparse L D L^T in dense supernodes of single precision, for a preconditioner: neighbouring
/// columns with the same rows are one supernode, which is read once and in order. Solving is
/// several times faster than entry by entry in double, and as close as a preconditioner has to be
/// (model/EQUATIONS.md, "Panels of a factorisation").

#include <Eigen/SparseCholesky>
#include <vector>

#include "model/kernels/kernel_views.hpp"
#include "model/kernels/system.hpp"

namespace palpate {

/// All that this processor can run, the best first.
std::vector<supernodes::Kernels> supernode_kernels();

template <class Real> class SupernodeFactors {
 public:
  using Factors = Eigen::SimplicialLDLT<Eigen::SparseMatrix<Real>>;
  explicit SupernodeFactors(const supernodes::Kernels& kernels = supernode_kernels().front())
      : kernels_(kernels) {}
  /// A successful factorisation; allocates.
  void take(const Factors& factors);
  /// Whether single precision holds the factors.
  [[nodiscard]] bool usable() const { return usable_; }
  /// out = (L D L^T)^-1 right, to about 1e-7 of what the condition makes of it.
  void solve(const Vector<Real>& right, Vector<Real>& out) noexcept;
  [[nodiscard]] std::size_t supernode_count() const { return supernodes_.size(); }
  /// Read twice by every solve.
  [[nodiscard]] std::size_t memory_bytes() const { return values_.size() * sizeof(float); }

 private:
  using Lower = Eigen::SparseMatrix<Real>;
  /// The supernode that begins at a column.
  [[nodiscard]] supernodes::Supernode supernode_at(const Lower& l, Eigen::Index first) const;
  void store(const Lower& l, const supernodes::Supernode& supernode);

  supernodes::Kernels kernels_;
  bool usable_ = false;
  std::vector<supernodes::Supernode> supernodes_;
  std::vector<int> rows_;
  AlignedVector<float> values_;
  Eigen::VectorXi order_;  ///< coordinate i is row order_(i) of L
  Eigen::VectorXf inverse_pivots_;
  Eigen::VectorXf y_;
  Eigen::VectorXf work_;
};

}  // namespace palpate
