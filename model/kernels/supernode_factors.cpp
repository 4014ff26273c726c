// SPDX-License-Identifier: MIT

#include "model/kernels/supernode_factors.hpp"

#include <algorithm>

#include "model/kernels/instruction_set.hpp"

namespace palpate {

namespace {

constexpr Eigen::Index widest = 32;
/// Largest fraction of zeros in a supernode that separate columns would not store.
constexpr double padding = 0.25;

template <class Real> Eigen::Index entries_of(const Eigen::SparseMatrix<Real>& l, Eigen::Index j) {
  return l.outerIndexPtr()[j + 1] - l.outerIndexPtr()[j];
}

template <class Real> const int* rows_of(const Eigen::SparseMatrix<Real>& l, Eigen::Index j) {
  return l.innerIndexPtr() + l.outerIndexPtr()[j];
}

}  // namespace

std::vector<supernodes::Kernels> supernode_kernels() {
  return kernels_here(&KernelSet::supernodes);
}

template <class Real>
supernodes::Supernode SupernodeFactors<Real>::supernode_at(const Lower& l,
                                                           Eigen::Index first) const {
  Eigen::Index width = 1;
  Eigen::Index stored = entries_of(l, first);
  // The next column is added if it is the parent in the elimination tree: its rows contain these.
  for (Eigen::Index next = first + 1; next < l.cols() && width < widest; ++next, ++width) {
    if (entries_of(l, next - 1) == 0 || *rows_of(l, next - 1) != next) { break; }
    const Eigen::Index entries = stored + entries_of(l, next);
    const Eigen::Index full = (width + 1) * width / 2 + (width + 1) * entries_of(l, next);
    if (static_cast<double>(full - entries) > padding * static_cast<double>(full)) { break; }
    stored = entries;
  }
  const Eigen::Index below = entries_of(l, first + width - 1);
  const Eigen::Index lanes = kernels_.lanes;
  return {.first = static_cast<int>(first),
          .width = static_cast<int>(width),
          .blocks = static_cast<int>((width + below + lanes - 1) / lanes),
          .below = static_cast<int>(below),
          .rows = static_cast<long>(rows_.size()),
          .values = static_cast<long>(values_.size())};
}

/// Stores a supernode: copies the columns, multiplies by the inverse of their unit lower triangle,
/// and divides the result into tiles.
template <class Real>
void SupernodeFactors<Real>::store(const Lower& l, const supernodes::Supernode& supernode) {
  const Eigen::Index last = supernode.first + supernode.width - 1;
  const int* begin = rows_of(l, last);
  const int* end = begin + supernode.below;
  rows_.insert(rows_.end(), begin, end);
  Eigen::MatrixXd full = Eigen::MatrixXd::Zero(supernode.blocks * kernels_.lanes, supernode.width);
  full.topRows(supernode.width).diagonal().setOnes();
  for (Eigen::Index j = supernode.first; j <= last; ++j) {
    for (typename Lower::InnerIterator it(l, j); it; ++it) {
      const Eigen::Index row =
          it.row() <= last ? it.row() - supernode.first
                           : supernode.width + (std::lower_bound(begin, end, it.row()) - begin);
      full(row, j - supernode.first) = static_cast<double>(it.value());
    }
  }
  const Eigen::MatrixXd inverse =
      full.topRows(supernode.width)
          .triangularView<Eigen::UnitLower>()
          .solve(Eigen::MatrixXd::Identity(supernode.width, supernode.width));
  full.bottomRows(full.rows() - supernode.width) *= inverse;
  full.topRows(supernode.width) = inverse;
  for (Eigen::Index tile = 0; tile < supernode.width; tile += supernodes::tile) {
    const Eigen::Index columns = std::min<Eigen::Index>(supernodes::tile, supernode.width - tile);
    for (Eigen::Index row = 0; row < full.rows(); row += kernels_.lanes) {
      const Eigen::MatrixXf block = full.block(row, tile, kernels_.lanes, columns).cast<float>();
      values_.insert(values_.end(), block.data(), block.data() + block.size());
    }
  }
}

template <class Real>
bool SupernodeFactors<Real>::factorise(const Eigen::SparseMatrix<Real>& matrix,
                                       const Order& order) {
  Eigen::SparseMatrix<Real> ordered;
  ordered.template selfadjointView<Eigen::Lower>() =
      matrix.template selfadjointView<Eigen::Lower>().twistedBy(order);
  const Factors factors(ordered);
  if (factors.info() != Eigen::Success) { return false; }
  const Lower& l = factors.matrixL().nestedExpression();
  const Eigen::Index n = l.cols();
  supernodes_.clear();
  rows_.clear();
  values_.clear();
  int highest = 0;
  for (Eigen::Index first = 0; first < n; first += supernodes_.back().width) {
    supernodes_.push_back(supernode_at(l, first));
    store(l, supernodes_.back());
    highest = std::max(highest, supernodes_.back().blocks);
  }
  order_ = order.indices();
  inverse_pivots_ = factors.vectorD().cwiseInverse().template cast<float>();
  usable_ =
      inverse_pivots_.allFinite() &&
      Eigen::Map<const Eigen::VectorXf>(values_.data(), static_cast<Eigen::Index>(values_.size()))
          .allFinite();
  y_.setZero(n);
  work_.setZero(highest * kernels_.lanes);
  return true;
}

template <class Real>
void SupernodeFactors<Real>::solve(const Vector<Real>& right, Vector<Real>& out) noexcept {
  for (Eigen::Index i = 0; i < right.size(); ++i) { y_(order_(i)) = static_cast<float>(right(i)); }
  kernels_.solve({.supernodes = supernodes_.data(),
                  .count = static_cast<long>(supernodes_.size()),
                  .rows = rows_.data(),
                  .values = values_.data(),
                  .inverse_pivots = inverse_pivots_.data(),
                  .size = static_cast<long>(y_.size())},
                 y_.data(), work_.data());
  for (Eigen::Index i = 0; i < right.size(); ++i) { out(i) = static_cast<Real>(y_(order_(i))); }
}

template class SupernodeFactors<double>;
template class SupernodeFactors<float>;

}  // namespace palpate
