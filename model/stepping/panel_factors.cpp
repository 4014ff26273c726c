// SPDX-License-Identifier: MIT
#include "model/stepping/panel_factors.hpp"

#include <algorithm>

namespace palpate {

namespace {

constexpr Eigen::Index widest = 16;
/// Share of a panel that may be zeros which a column of its own would not store.
constexpr double padding = 0.25;

}  // namespace

template <class Real>
void PanelFactors<Real>::take(const Eigen::SimplicialLDLT<Eigen::SparseMatrix<Real>>& factors) {
  const Eigen::SparseMatrix<Real>& l = factors.matrixL().nestedExpression();
  const Eigen::Index n = l.cols();
  const auto count = [&](Eigen::Index j) { return Eigen::Index{l.outerIndexPtr()[j + 1] - l.outerIndexPtr()[j]}; };
  const auto first_row = [&](Eigen::Index j) { return l.innerIndexPtr()[l.outerIndexPtr()[j]]; };
  panels_.clear();
  rows_.clear();
  values_.clear();
  Eigen::Index most_below = 0;
  for (Eigen::Index first = 0; first < n;) {
    Panel panel{first, 1, count(first), rows_.size(), values_.size()};
    Eigen::Index stored = panel.below;
    // The next column joins if it is the parent in the elimination tree: its rows contain these.
    for (Eigen::Index next = first + 1; next < n && panel.width < widest; ++next) {
      if (count(next - 1) == 0 || first_row(next - 1) != next) { break; }
      const Eigen::Index entries = stored + count(next);
      const Eigen::Index width = panel.width + 1;
      const Eigen::Index full = width * (width - 1) / 2 + width * count(next);
      if (static_cast<double>(full - entries) > padding * static_cast<double>(full)) { break; }
      panel.width = width;
      panel.below = count(next);
      stored = entries;
    }
    const Eigen::Index last = first + panel.width - 1;
    const int* begin = l.innerIndexPtr() + l.outerIndexPtr()[last];
    rows_.insert(rows_.end(), begin, begin + panel.below);
    const Eigen::Index height = panel.width + panel.below;
    values_.resize(values_.size() + static_cast<std::size_t>(height * panel.width), 0.0F);
    for (Eigen::Index j = first; j <= last; ++j) {
      float* column = values_.data() + panel.values + static_cast<std::size_t>((j - first) * height);
      for (typename Eigen::SparseMatrix<Real>::InnerIterator it(l, j); it; ++it) {
        const Eigen::Index place =
            it.row() <= last ? it.row() - first
                             : panel.width + (std::lower_bound(begin, begin + panel.below, it.row()) - begin);
        column[place] = static_cast<float>(it.value());
      }
    }
    most_below = std::max(most_below, panel.below);
    panels_.push_back(panel);
    first = last + 1;
  }
  order_ = factors.permutationP().indices();
  if (order_.size() == 0) { order_.setLinSpaced(n, 0, static_cast<int>(n) - 1); }
  inverse_pivots_ = factors.vectorD().cwiseInverse().template cast<float>();
  usable_ = inverse_pivots_.allFinite() &&
            Eigen::Map<const Eigen::VectorXf>(values_.data(), static_cast<Eigen::Index>(values_.size()))
                .allFinite();
  y_.setZero(n);
  gathered_.setZero(most_below);
}

template <class Real>
typename PanelFactors<Real>::Block PanelFactors<Real>::square(const Panel& panel) const noexcept {
  return {values_.data() + panel.values, panel.width, panel.width,
          Eigen::OuterStride<>(panel.width + panel.below)};
}

template <class Real>
typename PanelFactors<Real>::Block PanelFactors<Real>::lower(const Panel& panel) const noexcept {
  return {values_.data() + panel.values + panel.width, panel.below, panel.width,
          Eigen::OuterStride<>(panel.width + panel.below)};
}

template <class Real>
void PanelFactors<Real>::forward(const Panel& panel) noexcept {
  const Block among = square(panel);
  auto x = y_.segment(panel.first, panel.width);
  for (Eigen::Index c = 0; c + 1 < panel.width; ++c) {
    for (Eigen::Index r = c + 1; r < panel.width; ++r) { x(r) -= among(r, c) * x(c); }
  }
  if (panel.below == 0) { return; }
  gathered_.head(panel.below).noalias() = lower(panel) * x;
  const int* rows = rows_.data() + panel.rows;
  for (Eigen::Index i = 0; i < panel.below; ++i) { y_(rows[i]) -= gathered_(i); }
}

template <class Real>
void PanelFactors<Real>::backward(const Panel& panel) noexcept {
  const Block among = square(panel);
  auto x = y_.segment(panel.first, panel.width);
  if (panel.below > 0) {
    const int* rows = rows_.data() + panel.rows;
    for (Eigen::Index i = 0; i < panel.below; ++i) { gathered_(i) = y_(rows[i]); }
    x.noalias() -= lower(panel).transpose() * gathered_.head(panel.below);
  }
  for (Eigen::Index c = panel.width - 1; c >= 0; --c) {
    for (Eigen::Index r = c + 1; r < panel.width; ++r) { x(c) -= among(r, c) * x(r); }
  }
}

template <class Real>
void PanelFactors<Real>::solve(const Vector<Real>& right, Vector<Real>& out) noexcept {
  for (Eigen::Index i = 0; i < right.size(); ++i) { y_(order_(i)) = static_cast<float>(right(i)); }
  for (const Panel& panel : panels_) { forward(panel); }
  y_.array() *= inverse_pivots_.array();
  for (std::size_t p = panels_.size(); p-- > 0;) { backward(panels_[p]); }
  for (Eigen::Index i = 0; i < right.size(); ++i) { out(i) = static_cast<Real>(y_(order_(i))); }
}

template class PanelFactors<double>;
template class PanelFactors<float>;

}  // namespace palpate
