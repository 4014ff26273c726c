// SPDX-License-Identifier: MIT
/// Between two steps: places and velocities of the tissue that tip and shaft hold meet those of the tool.
#include "model/stepping/tool_contact.hpp"

namespace palpate {

template <class Real>
void ToolContact<Real>::match_positions(State<Real>& state) noexcept {
  if (!contact_.tip_held) { return; }
  const double gap = place_ - depth_ - displacement_at(at_);
  const double push_by = gap / contact_.tip_tip;
  for (const std::size_t k : {at_.knot, at_.knot + 1}) {
    if (k >= knots_.size()) { break; }
    const double share = tip_share(k) * push_by;
    knots_[k].displacement += share * knots_[k].mobility;
    for (std::size_t i = knots_[k].first; i < knots_[k].first + knots_[k].count; ++i) {
      const Support& s = supports_[i];
      at_node(state.position, s.coordinate, stride_) +=
          (share * s.weight * s.inverse_mass * n_).template cast<Real>();
    }
  }
  if (is_coordinate() && !at_bone_) {
    place_ -= push_by / mass_;
    state.position(tool_) = static_cast<Real>(place_);
  }
}

template <class Real>
void ToolContact<Real>::match_velocities(State<Real>& state) noexcept {
  double tip = velocity_;
  double shaft = velocity_;
  for (std::size_t k = 0; k < knots_.size(); ++k) {
    tip -= tip_share(k) * knots_[k].velocity;
    if (limit_ > 0.0) { shaft -= shaft_share_[k] * knots_[k].velocity; }
  }
  const Eigen::Vector2d impulse = answer(tip, shaft, contact_.tip_held, contact_.shaft_held);
  losses_.impact += 0.5 * (impulse.x() * tip + impulse.y() * shaft);
  losses_.impulse += impulse.sum();
  if (!is_coordinate()) { losses_.jerk += impulse.sum() * velocity_; }
  for (std::size_t k = 0; k < knots_.size(); ++k) {
    Knot& knot = knots_[k];
    const double along = tip_share(k) * impulse.x() +
                         (limit_ > 0.0 ? shaft_share_[k] * impulse.y() : 0.0);
    const bool locked = is_locked(knot);
    if (along == 0.0 && !locked) { continue; }
    Eigen::Vector3d change = along * n_;
    if (locked) {
      Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
      for (std::size_t i = knot.first; i < knot.first + knot.count; ++i) {
        velocity += supports_[i].weight *
                    at_node(state.velocity, supports_[i].coordinate, stride_)
                        .template cast<double>();
      }
      const Eigen::Vector3d sideways = (velocity - n_.dot(velocity) * n_) / knot.mobility;
      losses_.impact += 0.5 * sideways.squaredNorm() * knot.mobility;
      change -= sideways;
    }
    knot.velocity += along * knot.mobility;
    for (std::size_t i = knot.first; i < knot.first + knot.count; ++i) {
      const Support& s = supports_[i];
      at_node(state.velocity, s.coordinate, stride_) +=
          (s.weight * s.inverse_mass * change).template cast<Real>();
    }
  }
  if (is_coordinate() && !at_bone_) {
    velocity_ -= impulse.sum() / mass_;
    state.velocity(tool_) = static_cast<Real>(velocity_);
  }
}

template void ToolContact<double>::match_positions(State<double>&) noexcept;
template void ToolContact<float>::match_positions(State<float>&) noexcept;
template void ToolContact<double>::match_velocities(State<double>&) noexcept;
template void ToolContact<float>::match_velocities(State<float>&) noexcept;

}  // namespace palpate
