// SPDX-License-Identifier: MIT
#pragma once
/// A sparse L D L^T in dense panels of single precision, for a preconditioner: neighbouring columns with
/// the same rows are one panel, which is read once and in order. Solving is several times faster than
/// entry by entry in double, and as close as a preconditioner has to be.

#include <vector>

#include <Eigen/SparseCholesky>

#include "model/stepping/system.hpp"

namespace palpate {

template <class Real>
class PanelFactors {
 public:
  /// A successful factorisation; allocates.
  void take(const Eigen::SimplicialLDLT<Eigen::SparseMatrix<Real>>& factors);
  /// Whether single precision holds the factors.
  [[nodiscard]] bool usable() const { return usable_; }
  /// out = (L D L^T)^-1 right, to about 1e-7 of what the condition makes of it.
  void solve(const Vector<Real>& right, Vector<Real>& out) noexcept;
  [[nodiscard]] std::size_t panel_count() const { return panels_.size(); }

 private:
  /// Columns [first, first + width) and the rows below them that any of them touches.
  struct Panel {
    Eigen::Index first = 0;
    Eigen::Index width = 0;
    Eigen::Index below = 0;    ///< how many rows
    std::size_t rows = 0;      ///< where they begin in rows_
    std::size_t values = 0;    ///< of a column-major block of width + below rows
  };
  using Block = Eigen::Map<const Eigen::MatrixXf, 0, Eigen::OuterStride<>>;
  [[nodiscard]] Block square(const Panel& panel) const noexcept;
  [[nodiscard]] Block lower(const Panel& panel) const noexcept;
  void forward(const Panel& panel) noexcept;
  void backward(const Panel& panel) noexcept;

  bool usable_ = false;
  std::vector<Panel> panels_;
  std::vector<int> rows_;
  std::vector<float> values_;
  Eigen::VectorXi order_;  ///< coordinate i is row order_(i) of L
  Eigen::VectorXf inverse_pivots_;
  Eigen::VectorXf y_;
  Eigen::VectorXf gathered_;
};

}  // namespace palpate
