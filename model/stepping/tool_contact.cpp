// SPDX-License-Identifier: MIT
#include "model/stepping/tool_contact.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace palpate {

namespace {

/// Below this share of independence the constraints of tip and shaft count as one.
constexpr double independent = 1e-6;

Coupling coupling_of(const Scene& scene, const Drive& drive) {
  if (drive.kind == Drive::Kind::force) { return {.viscosity = drive.hand_viscosity}; }
  if (drive.kind != Drive::Kind::falcon) { return {}; }
  const FalconDrive falcon = scene.falcon.value_or(FalconDrive{});
  return {falcon.coupling_stiffness, falcon.coupling_viscosity};
}

double mass_of(const Scene& scene) { return scene.needle ? scene.needle->mass : scene.probe->mass; }

}  // namespace

template <class Real>
ToolContact<Real>::ToolContact(const Scene& scene, const NetworkProblem& problem,
                               const NodeLayout& layout)
    : path_(tool_path(scene, problem.network())),
      drive_(scene.drive.value_or(Drive{})),
      trajectory_(drive_, scene.simulation.duration + scene.simulation.step),
      needle_(scene.needle.has_value()),
      stride_(layout.stride),
      coupling_(coupling_of(scene, drive_)),
      start_place_(drive_.from),
      n_(path_.direction()),
      tolerance_(std::max(scene.simulation.solver_tolerance,
                          64.0 * static_cast<double>(std::numeric_limits<Real>::epsilon()))) {
  if (drive_.kind != Drive::Kind::trajectory) {
    tool_ = layout.size;
    mass_ = mass_of(scene);
  }
  const NodeVectors& held = problem.held_position();
  for (const NeedlePath::Knot& knot : path_.knots()) {
    Knot mine{supports_.size(), 0, knot.depth, 0.0, 0.0, 0.0, 0.0, 0.0};
    for (const NeedlePath::Support& s : path_.supports(knot)) {
      const Eigen::Index c = layout.first[static_cast<std::size_t>(s.node)];
      mine.held -= s.weight * n_.dot(problem.network().rest_position.col(s.node));
      if (c < 0) {
        mine.held += s.weight * n_.dot(held.col(s.node));
        continue;
      }
      const double inverse_mass = 1.0 / problem.mass()(problem.coordinate(s.node));
      supports_.push_back({c, s.weight, inverse_mass});
      mine.mobility += s.weight * s.weight * inverse_mass;
    }
    mine.count = supports_.size() - mine.first;
    knots_.push_back(mine);
  }
  across_[0] = n_.unitOrthogonal();
  across_[1] = n_.cross(across_[0]);
  shaft_share_.assign(knots_.size(), 0.0);
  place_ = place_begin_ = handle_place_ = start_place_;
  depth_ = cut_ = knots_.front().depth;
}

template <class Real>
double ToolContact<Real>::hand(double t) const noexcept {
  const double pushed = drive_.kind == Drive::Kind::force ? hand_force(drive_, t) : 0.0;
  return pushed + coupling_.stiffness * (handle_place_ - place_) +
         coupling_.viscosity * (handle_velocity_ - velocity_);
}

template <class Real>
double ToolContact<Real>::tool_mobility() const noexcept {
  return is_coordinate() && !at_bone_ ? 1.0 / mass_ : 0.0;
}

template <class Real>
bool ToolContact<Real>::is_locked(const Knot& knot) const noexcept {
  return needle_ && in_tissue() && knot.depth < depth_ && knot.mobility > 0.0;
}

template <class Real>
double ToolContact<Real>::tip_share(std::size_t knot) const noexcept {
  return knot == at_.knot ? 1.0 - at_.share : knot == at_.knot + 1 ? at_.share : 0.0;
}

template <class Real>
void ToolContact<Real>::gather(const Vector<Real>& q, const Vector<Real>& v) noexcept {
  const Eigen::Matrix<Real, 3, 1> n = n_.template cast<Real>();
  for (Knot& knot : knots_) {
    knot.displacement = knot.held;
    knot.velocity = 0.0;
    for (std::size_t i = knot.first; i < knot.first + knot.count; ++i) {
      const Support& s = supports_[i];
      const auto place = at_node(q, s.coordinate, stride_).template cast<double>();
      knot.displacement += s.weight * n_.dot(place);
      knot.velocity +=
          s.weight * static_cast<double>(n.dot(at_node(v, s.coordinate, stride_)));
    }
  }
}

template <class Real>
double ToolContact<Real>::displacement_at(NeedlePath::Place at) const noexcept {
  const double low = knots_[at.knot].displacement;
  return at.share == 0.0 ? low : low + at.share * (knots_[at.knot + 1].displacement - low);
}

template <class Real>
double ToolContact<Real>::velocity_at(NeedlePath::Place at) const noexcept {
  const double low = knots_[at.knot].velocity;
  return at.share == 0.0 ? low : low + at.share * (knots_[at.knot + 1].velocity - low);
}

template <class Real>
double ToolContact<Real>::depth_at(double s) const noexcept {
  std::size_t k = 0;
  while (k + 1 < knots_.size() && s >= knots_[k + 1].depth + knots_[k + 1].displacement) { ++k; }
  const double low = knots_[k].depth + knots_[k].displacement;
  if (k + 1 == knots_.size()) { return knots_[k].depth + (s - low); }
  const double high = knots_[k + 1].depth + knots_[k + 1].displacement;
  if (!(high > low) || s < low) { return knots_[k].depth + (s - low); }
  return knots_[k].depth + (s - low) / (high - low) * (knots_[k + 1].depth - knots_[k].depth);
}

template <class Real>
void ToolContact<Real>::place_tool(double t, const Vector<Real>& q,
                                   const Vector<Real>& v) noexcept {
  if (is_coordinate()) {
    place_ = static_cast<double>(q(tool_));
    velocity_ = static_cast<double>(v(tool_));
  } else {
    place_ = place_begin_ + velocity_ * (t - step_begin_);
  }
  switch (tip_) {
    case TipMode::outside: depth_ = knots_.front().depth; break;
    case TipMode::stuck: depth_ = cut_; break;
    case TipMode::cutting:
    case TipMode::in_track:
      depth_ = predict_ ? depth_begin_ + depth_rate_ * (t - step_begin_) : depth_at(place_);
      break;
  }
}

template <class Real>
void ToolContact<Real>::weigh() noexcept {
  at_ = path_.place(depth_);
  limit_ = needle_ && in_tissue() ? path_.friction(depth_, shaft_share_) : 0.0;
  if (limit_ > 0.0) {
    for (double& share : shaft_share_) { share /= limit_; }
  }
  const double own = tool_mobility();
  contact_ = {own, own, own, false, false};
  for (std::size_t k = 0; k < knots_.size(); ++k) {
    const double tip = tip_share(k);
    const double shaft = limit_ > 0.0 ? shaft_share_[k] : 0.0;
    contact_.tip_tip += tip * tip * knots_[k].mobility;
    contact_.tip_shaft += tip * shaft * knots_[k].mobility;
    contact_.shaft_shaft += shaft * shaft * knots_[k].mobility;
  }
}

template <class Real>
bool ToolContact<Real>::may_hold_shaft() const noexcept {
  if (!(limit_ > 0.0 && contact_.shaft_shaft > 0.0)) { return false; }
  if (tip_ != TipMode::stuck) { return true; }
  const double product = contact_.tip_tip * contact_.shaft_shaft;
  return product - contact_.tip_shaft * contact_.tip_shaft > independent * product;
}

template <class Real>
Eigen::Vector2d ToolContact<Real>::answer(double tip, double shaft, bool tip_held,
                                          bool shaft_held) const noexcept {
  const Contact& c = contact_;
  if (tip_held && shaft_held) {
    const double determinant = c.tip_tip * c.shaft_shaft - c.tip_shaft * c.tip_shaft;
    return {(c.shaft_shaft * tip - c.tip_shaft * shaft) / determinant,
            (c.tip_tip * shaft - c.tip_shaft * tip) / determinant};
  }
  return {tip_held ? tip / c.tip_tip : 0.0, shaft_held ? shaft / c.shaft_shaft : 0.0};
}

/// T and F_f within their laws. `tool_acceleration` is that of the tool without them.
template <class Real>
void ToolContact<Real>::solve(double tool_acceleration) noexcept {
  double tip = tool_acceleration + lag_.x();
  double shaft = tool_acceleration + lag_.y();
  for (std::size_t k = 0; k < knots_.size(); ++k) {
    tip -= tip_share(k) * knots_[k].acceleration;
    if (limit_ > 0.0) { shaft -= shaft_share_[k] * knots_[k].acceleration; }
  }
  const bool sticks = shaft_ == ShaftMode::stick && may_hold_shaft();
  const bool stuck = tip_ == TipMode::stuck && contact_.tip_tip > 0.0;
  const double slipping = shaft_ == ShaftMode::backward ? -limit_ : limit_;
  const bool rigid = tip_ == TipMode::stuck && !stuck;  // only fixed nodes around the tip
  if (tip_ == TipMode::cutting || (rigid && velocity_ > 0.0)) {
    // Bone has none: there the tip keeps the force with which it arrived, and bone adds its own.
    if (std::isfinite(cutting_force())) { tip_force_ = cutting_force(); }
  } else if (!rigid || velocity_ < 0.0) {
    tip_force_ = 0.0;
  }
  contact_.tip_held = contact_.shaft_held = false;
  shaft_force_ = shaft_ == ShaftMode::stick && !sticks ? std::clamp(shaft_force_, -limit_, limit_)
                                                       : slipping;
  if (stuck && sticks) {
    const Eigen::Vector2d both = answer(tip, shaft, true, true);
    take_tip(both.x());
    take_shaft(both.y());
    if (contact_.tip_held && contact_.shaft_held) { return; }
  }
  if (sticks && !contact_.tip_held) {  // the tip's force is known
    take_shaft((shaft - contact_.tip_shaft * tip_force_) / contact_.shaft_shaft);
  }
  if (stuck && !contact_.shaft_held) {  // the shaft's force is known
    take_tip((tip - contact_.tip_shaft * shaft_force_) / contact_.tip_tip);
  }
}

/// What sticking needs, or the nearest force within the law. An implicit step takes what is needed, so
/// that Newton's method sees one set of constraints, and revise() looks at the law when it ends.
template <class Real>
void ToolContact<Real>::take_tip(double needed) noexcept {
  const double within = std::clamp(needed, 0.0, cutting_force());
  contact_.tip_held = predict_ || within == needed;
  tip_force_ = contact_.tip_held ? needed : within;
}
template <class Real>
void ToolContact<Real>::take_shaft(double needed) noexcept {
  const double within = std::clamp(needed, -limit_, limit_);
  contact_.shaft_held = predict_ || within == needed;
  shaft_force_ = contact_.shaft_held ? needed : within;
}

template <class Real>
void ToolContact<Real>::push(std::size_t knot, double force, Vector<Real>& f) const noexcept {
  if (force == 0.0) { return; }
  const Knot& k = knots_[knot];
  for (std::size_t i = k.first; i < k.first + k.count; ++i) {
    at_node(f, supports_[i].coordinate, stride_) +=
        (supports_[i].weight * force * n_).template cast<Real>();
  }
}

template <class Real>
void ToolContact<Real>::apply(double t, const Vector<Real>& q, const Vector<Real>& v,
                              Vector<Real>& f) noexcept {
  gather(q, v);
  place_tool(t, q, v);
  weigh();
  for (Knot& knot : knots_) {
    Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();
    for (std::size_t i = knot.first; i < knot.first + knot.count; ++i) {
      const Support& s = supports_[i];
      acceleration += (s.weight * s.inverse_mass) *
                      at_node(f, s.coordinate, stride_).template cast<double>();
    }
    knot.acceleration = n_.dot(acceleration);
    if (!is_locked(knot)) { continue; }
    const Eigen::Vector3d force = (knot.acceleration * n_ - acceleration) / knot.mobility;
    for (std::size_t i = knot.first; i < knot.first + knot.count; ++i) {
      at_node(f, supports_[i].coordinate, stride_) +=
          (supports_[i].weight * force).template cast<Real>();
    }
    sideways_ -= force;
  }
  const double pushed = is_coordinate() ? hand(t) : 0.0;
  solve(is_coordinate() && !at_bone_ ? pushed / mass_ : 0.0);
  for (std::size_t k = 0; k < knots_.size(); ++k) {
    push(k, tip_share(k) * tip_force_ + (limit_ > 0.0 ? shaft_share_[k] * shaft_force_ : 0.0), f);
  }
  const double tissue = tip_force_ + shaft_force_;
  bone_force_ = 0.0;
  if (is_coordinate()) {
    if (at_bone_) { bone_force_ = std::max(pushed - tissue, 0.0); }
    f(tool_) = static_cast<Real>(pushed - tissue - bone_force_);
  } else {
    bone_force_ = drive_.grip_stiffness * std::max(trajectory_.place(t) - path_.bone(), 0.0);
  }
  const bool cuts = tip_ == TipMode::cutting;
  forces_.cutting = cuts ? tip_force_ : 0.0;
  forces_.friction = shaft_force_;
  forces_.stiffness = (cuts ? 0.0 : tip_force_) + bone_force_;
  forces_.total = forces_.cutting + forces_.friction + forces_.stiffness;
  forces_.applied = is_coordinate() ? pushed : forces_.total;
  forces_.lateral = sideways_.norm();
  hand_power_end_ = forces_.applied * velocity_;
  if (first_evaluation_) { hand_power_begin_ = hand_power_end_; }
  first_evaluation_ = false;
  sideways_.setZero();
}

template class ToolContact<double>;
template class ToolContact<float>;

}  // namespace palpate
