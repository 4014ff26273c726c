// SPDX-License-Identifier: MIT
#pragma once
/// Sparse L D L^T factorisation in dense supernodes of single precision, for a preconditioner
/// (model/EQUATIONS.md, "Supernodes of a factorisation").

#include <Eigen/SparseCholesky>
#include <vector>

#include "model/kernels/kernel_views.hpp"
#include "model/kernels/system.hpp"

namespace palpate {

/// Returns all kernels that this processor supports, widest first.
std::vector<supernodes::Kernels> supernode_kernels();

template <class Real> class SupernodeFactors {
 public:
  using Factors =
      Eigen::SimplicialLDLT<Eigen::SparseMatrix<Real>, Eigen::Lower, Eigen::NaturalOrdering<int>>;
  using Order = Eigen::PermutationMatrix<Eigen::Dynamic>;
  explicit SupernodeFactors(const supernodes::Kernels& kernels = supernode_kernels().front())
      : kernels_(kernels) {}
  /// Factorises a symmetric matrix in an order of its rows; allocates. Returns false if it has no
  /// factors.
  bool factorise(const Eigen::SparseMatrix<Real>& matrix, const Order& order);
  /// Returns true if the factors are in the range of single precision.
  [[nodiscard]] bool usable() const { return usable_; }
  /// Computes out = (L D L^T)^-1 right to about 1e-7 times the condition number.
  void solve(const Vector<Real>& right, Vector<Real>& out) noexcept;
  [[nodiscard]] std::size_t supernode_count() const { return supernodes_.size(); }
  /// Returns the size of the values, which every solve reads twice.
  [[nodiscard]] std::size_t memory_bytes() const { return values_.size() * sizeof(float); }

 private:
  using Lower = Eigen::SparseMatrix<Real>;
  /// Returns the supernode that begins at column `first`.
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
