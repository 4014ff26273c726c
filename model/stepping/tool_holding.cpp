// SPDX-License-Identifier: MIT
/// What tip, shaft and bone hold, as a system of equations has to know it (model/EQUATIONS.md, "Held constraints").
#include <algorithm>
#include <vector>

#include "model/stepping/tool_contact.hpp"

namespace palpate {

template <class Real>
void ToolContact<Real>::hold(const Vector<Real>& x, const Vector<Real>& mass,
                             Vector<Real>& product) noexcept {
  double tip = 0.0;
  double shaft = 0.0;
  for (std::size_t k = 0; k < knots_.size(); ++k) {
    const Knot& knot = knots_[k];
    Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();
    for (std::size_t i = knot.first; i < knot.first + knot.count; ++i) {
      const Eigen::Index c = supports_[i].coordinate;
      const Eigen::Matrix<Real, 3, 1> force =
          at_node(product, c, stride_) -
          at_node(mass, c, stride_).cwiseProduct(at_node(x, c, stride_));
      acceleration +=
          (supports_[i].weight * supports_[i].inverse_mass) * force.template cast<double>();
    }
    const double along = n_.dot(acceleration);
    tip -= tip_share(k) * along;
    if (limit_ > 0.0) { shaft -= shaft_share_[k] * along; }
    if (!is_locked(knot)) { continue; }
    const Eigen::Vector3d force = (along * n_ - acceleration) / knot.mobility;
    for (std::size_t i = knot.first; i < knot.first + knot.count; ++i) {
      at_node(product, supports_[i].coordinate, stride_) +=
          (supports_[i].weight * force).template cast<Real>();
    }
  }
  if (is_coordinate()) {
    const double own = static_cast<double>(product(tool_) - mass(tool_) * x(tool_));
    if (at_bone_) {
      product(tool_) = mass(tool_) * x(tool_);
    } else {
      tip += own / mass_;
      shaft += own / mass_;
    }
  }
  if (!contact_.tip_held && !contact_.shaft_held) { return; }
  const Eigen::Vector2d force = answer(tip, shaft, contact_.tip_held, contact_.shaft_held);
  for (std::size_t k = 0; k < knots_.size(); ++k) {
    push(k, tip_share(k) * force.x() + (limit_ > 0.0 ? shaft_share_[k] * force.y() : 0.0), product);
  }
  if (is_coordinate() && !at_bone_) { product(tool_) -= static_cast<Real>(force.sum()); }
}

template <class Real>
void ToolContact<Real>::learn_response(Eigen::Index dof,
                                       const typename HeldResponse<Real>::Solve& solve) {
  std::vector<std::size_t> begin;
  for (const Knot& knot : knots_) { begin.push_back(knot.first); }
  begin.push_back(supports_.size());
  held_.learn(supports_, begin, tool_, mass_, dof, solve);
}

/// What hold() holds, as rows: tip, shaft, two directions across the needle for each locked knot,
/// and a tool that bone stops.
template <class Real>
void ToolContact<Real>::begin_holding() noexcept {
  held_.clear();
  const double own = is_coordinate() && !at_bone_ ? 1.0 : 0.0;
  if (contact_.tip_held) {
    const std::size_t count = std::min<std::size_t>(2, knots_.size() - at_.knot);
    const auto row = held_.add_row(at_.knot, count, own);
    for (std::size_t n = 0; n < count; ++n) { row[n] = -tip_share(at_.knot + n) * n_; }
  }
  if (contact_.shaft_held) {
    const std::size_t count = std::min(at_.knot + 2, knots_.size());  // no friction beyond the tip
    const auto row = held_.add_row(0, count, own);
    for (std::size_t k = 0; k < count; ++k) { row[k] = -shaft_share_[k] * n_; }
  }
  for (std::size_t k = 0; k < knots_.size(); ++k) {
    if (!is_locked(knots_[k])) { continue; }
    held_.add_row(k, 1, 0.0)[0] = across_[0];
    held_.add_row(k, 1, 0.0)[0] = across_[1];
  }
  if (is_coordinate() && at_bone_) { held_.add_row(0, 0, 1.0); }
  held_.factorise();
}

template void ToolContact<double>::hold(const Vector<double>&, const Vector<double>&, Vector<double>&) noexcept;
template void ToolContact<float>::hold(const Vector<float>&, const Vector<float>&, Vector<float>&) noexcept;
template void ToolContact<double>::learn_response(Eigen::Index, const HeldResponse<double>::Solve&);
template void ToolContact<float>::learn_response(Eigen::Index, const HeldResponse<float>::Solve&);
template void ToolContact<double>::begin_holding() noexcept;
template void ToolContact<float>::begin_holding() noexcept;

}  // namespace palpate
