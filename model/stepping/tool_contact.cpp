// SPDX-License-Identifier: MIT

#include "model/stepping/tool_contact.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace palpate {

namespace {

/// Relative determinant below which the constraints of tip and shaft are treated as one.
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
    : ToolState(scene, problem.network()),
      drive_(scene.drive.value_or(Drive{})),
      trajectory_(drive_, scene.simulation.duration + scene.simulation.step),
      needle_(scene.needle.has_value()),
      stride_(layout.stride),
      coupling_(coupling_of(scene, drive_)),
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
  place_ = place_begin_ = handle_place_ = drive_.from;
  depth_ = cut_ = knots_.front().depth;
}

template <class Real> double ToolContact<Real>::hand(double t) const noexcept {
  const double pushed = drive_.kind == Drive::Kind::force ? hand_force(drive_, t) : 0.0;
  return pushed + coupling_.stiffness * (handle_place_ - place_) +
         coupling_.viscosity * (handle_velocity_ - velocity_);
}

template <class Real> double ToolContact<Real>::tool_mobility() const noexcept {
  return is_coordinate() && !at_bone_ ? 1.0 / mass_ : 0.0;
}

template <class Real> bool ToolContact<Real>::is_locked(const Knot& knot) const noexcept {
  return needle_ && in_tissue() && knot.depth < depth_ && knot.mobility > 0.0;
}

template <class Real> double ToolContact<Real>::tip_share(std::size_t knot) const noexcept {
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
      knot.velocity += s.weight * static_cast<double>(n.dot(at_node(v, s.coordinate, stride_)));
    }
  }
}

template <class Real>
double ToolContact<Real>::displacement_at(NeedlePath::Place at) const noexcept {
  const double low = knots_[at.knot].displacement;
  return at.share == 0.0 ? low : low + at.share * (knots_[at.knot + 1].displacement - low);
}

template <class Real> double ToolContact<Real>::velocity_at(NeedlePath::Place at) const noexcept {
  const double low = knots_[at.knot].velocity;
  return at.share == 0.0 ? low : low + at.share * (knots_[at.knot + 1].velocity - low);
}

template <class Real> double ToolContact<Real>::depth_at(double s) const noexcept {
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

template <class Real> void ToolContact<Real>::weigh() noexcept {
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

template <class Real> bool ToolContact<Real>::may_hold_shaft() const noexcept {
  if (!(limit_ > 0.0 && contact_.shaft_shaft > 0.0)) { return false; }
  if (tip_ != TipMode::stuck) { return true; }
  const double product = contact_.tip_tip * contact_.shaft_shaft;
  return product - contact_.tip_shaft * contact_.tip_shaft > independent * product;
}

template <class Real>
Eigen::Vector2d ToolContact<Real>::solve_contact_forces(double tip, double shaft, bool tip_held,
                                                        bool shaft_held) const noexcept {
  const Contact& c = contact_;
  if (tip_held && shaft_held) {
    const double determinant = c.tip_tip * c.shaft_shaft - c.tip_shaft * c.tip_shaft;
    return {(c.shaft_shaft * tip - c.tip_shaft * shaft) / determinant,
            (c.tip_tip * shaft - c.tip_shaft * tip) / determinant};
  }
  return {tip_held ? tip / c.tip_tip : 0.0, shaft_held ? shaft / c.shaft_shaft : 0.0};
}

/// Computes T and F_f within their laws. `tool_acceleration` is that of the tool without them.
template <class Real> void ToolContact<Real>::solve(double tool_acceleration) noexcept {
  double tip = tool_acceleration + lag_.x();
  double shaft = tool_acceleration + lag_.y();
  for (std::size_t k = 0; k < knots_.size(); ++k) {
    tip -= tip_share(k) * knots_[k].acceleration;
    if (limit_ > 0.0) { shaft -= shaft_share_[k] * knots_[k].acceleration; }
  }
  const bool sticks = shaft_ == ShaftMode::stick && may_hold_shaft();
  const bool stuck = tip_ == TipMode::stuck && contact_.tip_tip > 0.0;
  const double slipping = shaft_ == ShaftMode::backward ? -limit_ : limit_;
  const bool rigid = tip_ == TipMode::stuck && !stuck;  // only fixed nodes support the tip
  if (tip_ == TipMode::cutting || (rigid && velocity_ > 0.0)) {
    // Bone has no finite cutting force: the tip keeps its force at arrival, and the reaction of the
    // bone is added.
    if (std::isfinite(cutting_force())) { tip_force_ = cutting_force(); }
  } else if (!rigid || velocity_ < 0.0) {
    tip_force_ = 0.0;
  }
  contact_.tip_held = contact_.shaft_held = false;
  shaft_force_ =
      shaft_ == ShaftMode::stick && !sticks ? std::clamp(shaft_force_, -limit_, limit_) : slipping;
  if (stuck && sticks) {
    const Eigen::Vector2d both = solve_contact_forces(tip, shaft, true, true);
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

/// Sets the tip force to the one that sticking needs, or to the nearest force within the law.
/// Implicit steps take the needed force, so that Newton's method has a fixed set of constraints;
/// update_active_set() checks the law at the end of the step.
template <class Real> void ToolContact<Real>::take_tip(double needed) noexcept {
  const double within = std::clamp(needed, 0.0, cutting_force());
  contact_.tip_held = predict_ || within == needed;
  tip_force_ = contact_.tip_held ? needed : within;
}
template <class Real> void ToolContact<Real>::take_shaft(double needed) noexcept {
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
      acceleration +=
          (s.weight * s.inverse_mass) * at_node(f, s.coordinate, stride_).template cast<double>();
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

// Changes between two steps: modes of tip and shaft, and the velocities of parts that begin to
// stick.

namespace {
/// Distance from the skin [m] at which the tip has left it. Smaller rebounds of a resting tip are
/// not reported.
constexpr double clear_of_skin = 1e-6;
}  // namespace

template <class Real> void ToolContact<Real>::begin(State<Real>& state) {
  if (is_coordinate()) {
    state.position.conservativeResize(tool_ + 1);
    state.velocity.conservativeResize(tool_ + 1);
    state.position(tool_) = static_cast<Real>(drive_.from);
    state.velocity(tool_) = Real(0);
  }
  gather(state.position, state.velocity);
  change_tip(0.0);
}

template <class Real>
bool ToolContact<Real>::begin_step(double t, double h, State<Real>& state, bool predict) noexcept {
  step_begin_ = t;
  step_length_ = h;
  predict_ = predict;
  depth_begin_ = depth_;
  first_evaluation_ = true;
  const bool changed = !is_coordinate() && follow(t, h, state);
  if (predict && in_tissue()) {
    gather(state.position, state.velocity);
    weigh();
    lag_ = Eigen::Vector2d(velocity_ - velocity_at(at_), slip_now()) / h;
    predict_cutting();
  }
  return changed;
}

template <class Real>
bool ToolContact<Real>::follow(double t, double h, State<Real>& state) noexcept {
  const double from = std::min(trajectory_.place(t), path_.bone());
  const double to = std::min(trajectory_.place(t + h), path_.bone());
  const double velocity = (to - from) / h;
  // Rounding of position differences is not a jump.
  const double rounding =
      8.0 * std::numeric_limits<double>::epsilon() * std::max(std::abs(from), std::abs(to)) / h;
  place_begin_ = from;
  if (std::abs(velocity - velocity_) <= rounding) { return false; }
  velocity_ = velocity;
  if (!in_tissue()) { return false; }
  gather(state.position, state.velocity);
  weigh();
  contact_.tip_held = tip_ == TipMode::stuck && contact_.tip_tip > 0.0 &&
                      velocity_ > velocity_at(at_);  // the tip can push but not pull
  turn_shaft(h);
  match_velocities(state);
  dissipated_power_begin_ = dissipated_power();
  return true;
}

template <class Real> double ToolContact<Real>::slip_now() const noexcept {
  double slip = velocity_;
  for (std::size_t k = 0; k < knots_.size() && limit_ > 0.0; ++k) {
    slip -= shaft_share_[k] * knots_[k].velocity;
  }
  return slip;
}

/// Sets the shaft's mode after a jump of the drive. The shaft slides in the direction of motion, or
/// sticks if its limited friction can stop the slip within the step.
template <class Real> void ToolContact<Real>::turn_shaft(double h) noexcept {
  slip_ = limit_ > 0.0 ? slip_now() : 0.0;
  const bool rests = may_hold_shaft() && std::abs(slip_) <= limit_ * contact_.shaft_shaft * h;
  contact_.shaft_held = rests;
  if (rests) {
    shaft_ = ShaftMode::stick;
  } else if (slip_ != 0.0) {
    shaft_ = slip_ > 0.0 ? ShaftMode::forward : ShaftMode::backward;
  }
}

template <class Real> Eigen::Vector2d ToolContact<Real>::dissipated_power() const noexcept {
  const double slip = slip_now();
  const double cut = cutting_force() * (velocity_ - velocity_at(at_));
  return {tip_ == TipMode::cutting ? cut : 0.0,
          shaft_ == ShaftMode::stick ? 0.0 : limit_ * std::abs(slip)};
}

template <class Real> void ToolContact<Real>::end_step(double t, State<Real>& state) noexcept {
  gather(state.position, state.velocity);
  lag_.setZero();
  const bool stuck = tip_ == TipMode::stuck;
  step_tip_change_ = stuck && stuck_before_ ? tip_force_ - step_tip_force_ : 0.0;
  step_tip_force_ = tip_force_;
  stuck_before_ = stuck;
  if (predict_) {  // if update_active_set found no solution, the force is limited by the law
    predict_ = false;
    if (contact_.tip_held) { take_tip(tip_force_); }
    if (contact_.shaft_held) { take_shaft(shaft_force_); }
  }
  place_tool(t, state.position, state.velocity);
  const Contact held = contact_;
  account(t - step_begin_);
  meet_bone(t, state);
  change_modes(t, held);
  if (in_tissue()) {
    match_positions(state);
    match_velocities(state);
  }
  dissipated_power_begin_ = dissipated_power();
  depth_rate_ = depth_rate();
  if (syringe_) { syringe_->advance(step_length_, in_tissue(), interval().role); }
}

/// Adds the work of the hand and the dissipated energy in a step of h.
template <class Real> void ToolContact<Real>::account(double h) noexcept {
  losses_.hand += 0.5 * h * (hand_power_begin_ + hand_power_end_);
  if (!in_tissue()) { return; }
  weigh();
  const Eigen::Vector2d lost = 0.5 * h * (dissipated_power_begin_ + dissipated_power());
  losses_.cutting += lost.x();
  losses_.friction += lost.y();
}

template <class Real> void ToolContact<Real>::meet_bone(double t, State<Real>& state) noexcept {
  if (!is_coordinate()) {
    at_bone_ = trajectory_.place(t) >= path_.bone();
  } else if (!at_bone_ && place_ >= path_.bone() && velocity_ > 0.0) {
    place_ = path_.bone();
    losses_.impact += 0.5 * mass_ * velocity_ * velocity_;
    velocity_ = 0.0;
    state.position(tool_) = static_cast<Real>(place_);
    state.velocity(tool_) = Real(0);
    at_bone_ = true;
  } else if (at_bone_ && bone_force_ == 0.0) {
    at_bone_ = false;
  }
  if (at_bone_ && !bone_seen_) {
    happen(t, ToolEvent::bone, path_.interval_at(path_.bone()));
    bone_seen_ = true;
  }
}

/// Changes the modes of tip and shaft; `held` is the contact at the end of the step.
template <class Real> void ToolContact<Real>::change_modes(double t, const Contact& held) noexcept {
  contact_.tip_held = held.tip_held;
  if (tip_ == TipMode::cutting) { enter(path_.interval_at(cut_), t); }
  change_tip(t);
  weigh();
  contact_.tip_held = held.tip_held;
  contact_.shaft_held = held.shaft_held;
  change_shaft();
  contact_.tip_held = tip_ == TipMode::stuck && contact_.tip_tip > 0.0;
  contact_.shaft_held = shaft_ == ShaftMode::stick && may_hold_shaft();
  stopped_ = tip_ == TipMode::stuck ? velocity_ - velocity_at(at_) : 0.0;
}

/// Returns the velocity of the tip through the undeformed tissue [m/s], for schemes that predict
/// the depth.
template <class Real> double ToolContact<Real>::depth_rate() const noexcept {
  const bool moves = tip_ == TipMode::cutting || tip_ == TipMode::in_track;
  if (!moves || at_.knot + 1 >= knots_.size()) { return 0.0; }
  const Knot& low = knots_[at_.knot];
  const Knot& high = knots_[at_.knot + 1];
  const double stretch = 1.0 + (high.displacement - low.displacement) / (high.depth - low.depth);
  return stretch > 0.0 ? (velocity_ - velocity_at(at_)) / stretch : 0.0;
}

template <class Real> void ToolContact<Real>::change_tip(double t) noexcept {
  const double here = depth_at(place_);
  switch (tip_) {
    case TipMode::outside: change_outside(here, t); break;
    case TipMode::in_track: change_in_track(here, t); break;
    case TipMode::stuck: change_stuck(t); break;
    case TipMode::cutting: change_cutting(here, t); break;
  }
}

template <class Real> void ToolContact<Real>::change_outside(double here, double t) noexcept {
  const double skin = knots_.front().depth;
  if (here >= skin) {
    tip_ = cut_ > skin ? TipMode::in_track : TipMode::stuck;
    depth_ = cut_ > skin ? std::min(here, cut_) : cut_;
    tip_force_ = 0.0;
    if (clear_) { happen(t, ToolEvent::contact, path_.interval_at(skin)); }
    present_ = present_ || clear_;
    clear_ = false;
  } else if (here < skin - clear_of_skin) {
    leave(t);
    clear_ = true;
  }
}

template <class Real> void ToolContact<Real>::change_in_track(double here, double t) noexcept {
  const double skin = knots_.front().depth;
  depth_ = here;
  if (here >= cut_) {
    tip_ = TipMode::stuck;
    tip_force_ = 0.0;
    depth_ = cut_;
  } else if (here < skin) {
    tip_ = TipMode::outside;
    depth_ = skin;
    leave(t);
  }
}

template <class Real> void ToolContact<Real>::change_stuck(double t) noexcept {
  depth_ = cut_;
  if (contact_.tip_held || (contact_.tip_tip <= 0.0 && velocity_ == 0.0)) { return; }
  if (tip_force_ > 0.0 || (cutting_force() == 0.0 && velocity_ > velocity_at(at_))) {
    tip_ = TipMode::cutting;
    enter(path_.interval_at(cut_), t);
  } else {
    tip_ = cut_ > knots_.front().depth ? TipMode::in_track : TipMode::outside;
  }
}

template <class Real> void ToolContact<Real>::change_cutting(double here, double t) noexcept {
  const std::size_t before = path_.interval_at(cut_);
  cut_ = depth_ =
      std::max(here, knots_.front().depth);  // a step can end slightly behind the deepest point
  const std::size_t after = path_.interval_at(cut_);
  if (after <= before) {
    if (!(velocity_ > velocity_at(path_.place(cut_)))) { tip_ = TipMode::stuck; }
    return;
  }
  const auto& intervals = path_.intervals();
  if (intervals[after].cutting_force > intervals[before].cutting_force) {
    tip_ = TipMode::stuck;
    if (after > before + 1) { enter(after - 1, t); }
  } else {
    enter(after, t);
  }
}

template <class Real> void ToolContact<Real>::change_shaft() noexcept {
  if (!(limit_ > 0.0)) {
    shaft_ = ShaftMode::stick;
    shaft_force_ = 0.0;
    slip_ = 0.0;
    return;
  }
  slip_ = slip_now();
  const bool turned = (shaft_ == ShaftMode::forward && slip_ <= 0.0) ||
                      (shaft_ == ShaftMode::backward && slip_ >= 0.0);
  if (turned) {
    shaft_ = ShaftMode::stick;
  } else if (shaft_ == ShaftMode::stick && !contact_.shaft_held) {
    // The slip follows the force that exceeded the limit, because its own value is still rounding
    // error. A shaft that has just reached tissue was not sticking.
    const double sense = may_hold_shaft() && shaft_force_ != 0.0 ? shaft_force_ : slip_;
    shaft_ = sense > 0.0 ? ShaftMode::forward : ShaftMode::backward;
  }
}

// Velocity and position corrections between two steps: sticking parts of tissue and tool get a
// common velocity.

template <class Real> void ToolContact<Real>::match_positions(State<Real>& state) noexcept {
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

template <class Real> void ToolContact<Real>::match_velocities(State<Real>& state) noexcept {
  double tip = velocity_;
  double shaft = velocity_;
  for (std::size_t k = 0; k < knots_.size(); ++k) {
    tip -= tip_share(k) * knots_[k].velocity;
    if (limit_ > 0.0) { shaft -= shaft_share_[k] * knots_[k].velocity; }
  }
  const Eigen::Vector2d impulse =
      solve_contact_forces(tip, shaft, contact_.tip_held, contact_.shaft_held);
  losses_.impact += 0.5 * (impulse.x() * tip + impulse.y() * shaft);
  losses_.impulse += impulse.sum();
  if (!is_coordinate()) { losses_.jerk += impulse.sum() * velocity_; }
  for (std::size_t k = 0; k < knots_.size(); ++k) {
    Knot& knot = knots_[k];
    const double along =
        tip_share(k) * impulse.x() + (limit_ > 0.0 ? shaft_share_[k] * impulse.y() : 0.0);
    const bool locked = is_locked(knot);
    if (along == 0.0 && !locked) { continue; }
    Eigen::Vector3d change = along * n_;
    if (locked) {
      Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
      for (std::size_t i = knot.first; i < knot.first + knot.count; ++i) {
        velocity +=
            supports_[i].weight *
            at_node(state.velocity, supports_[i].coordinate, stride_).template cast<double>();
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

// Active contact constraints of tip, shaft and bone for the linear solver (model/EQUATIONS.md,
// "Held constraints").

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
  const Eigen::Vector2d force =
      solve_contact_forces(tip, shaft, contact_.tip_held, contact_.shaft_held);
  for (std::size_t k = 0; k < knots_.size(); ++k) {
    push(k, tip_share(k) * force.x() + (limit_ > 0.0 ? shaft_share_[k] * force.y() : 0.0), product);
  }
  if (is_coordinate() && !at_bone_) { product(tool_) -= static_cast<Real>(force.sum()); }
}

template <class Real>
void ToolContact<Real>::learn_compliance(Eigen::Index dof,
                                         const typename ConstraintCompliance<Real>::Solve& solve) {
  std::vector<std::size_t> begin;
  for (const Knot& knot : knots_) { begin.push_back(knot.first); }
  begin.push_back(supports_.size());
  held_.learn(supports_, begin, tool_, mass_, dof, solve);
}

/// Adds the constraint rows of hold(): tip, shaft, two directions across the needle for each locked
/// contact point, and a tool stopped by bone.
template <class Real> void ToolContact<Real>::begin_linear_solve() noexcept {
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

// Implicit steps use the active contact constraints predicted at their beginning. These functions
// predict and update them (model/EQUATIONS.md, "Held constraints").

/// Predicts whether the tip cuts in an implicit step. The force of a sticking tip is extrapolated
/// from the last step. A tip that begins to stick must accelerate the tissue to its own velocity,
/// with the known compliance. If the predicted force exceeds F_c, the step begins with a cutting
/// tip, which avoids a second solve; update_active_set() corrects a wrong prediction.
template <class Real> void ToolContact<Real>::predict_cutting() noexcept {
  if (tip_ != TipMode::stuck || !held_.learned() || !(contact_.tip_tip > 0.0)) { return; }
  const double response = held_.response_at(at_.knot, at_.share, n_) + tool_mobility();
  const double more = stuck_before_ ? step_tip_change_ : stopped_ / (step_length_ * response);
  if (step_tip_force_ + more > cutting_force()) { tip_ = TipMode::cutting; }
}

template <class Real> bool ToolContact<Real>::update_active_set(const State<Real>& state) noexcept {
  if (!in_tissue()) { return false; }
  gather(state.position, state.velocity);
  if (is_coordinate()) { velocity_ = static_cast<double>(state.velocity(tool_)); }
  const Slack allowed = slack();
  const bool tip = update_tip(velocity_ - velocity_at(at_), allowed);
  const bool shaft = update_shaft(slip_now(), allowed);
  first_evaluation_ = true;
  return tip || shaft;
}

/// Returns the tolerances on the contact laws: the solver's tolerance on velocities, the rounding
/// of positions, and the forces that change the constrained velocities by these amounts. A smaller
/// violation is solver error, and another solve would give the opposite violation. The remainder is
/// corrected at the end of the step.
template <class Real> typename ToolContact<Real>::Slack ToolContact<Real>::slack() const noexcept {
  constexpr double roundings = 8.0 * static_cast<double>(std::numeric_limits<Real>::epsilon());
  double fastest = std::abs(velocity_);
  for (const Knot& knot : knots_) { fastest = std::max(fastest, std::abs(knot.velocity)); }
  const double velocity =
      tolerance_ * fastest +
      roundings * std::max(std::abs(place_), knots_.back().depth) / step_length_;
  Slack allowed{.velocity = velocity};
  const auto force = [&](std::size_t row) {
    return velocity / (step_length_ * held_.response_of(row));
  };
  if (contact_.tip_held) { allowed.tip = force(0); }
  if (contact_.shaft_held) { allowed.shaft = force(contact_.tip_held ? 1 : 0); }
  return allowed;
}

/// Updates the constraint of the tip; `rate` is its velocity relative to the tissue at the end of
/// the step [m/s].
template <class Real> bool ToolContact<Real>::update_tip(double rate, const Slack& slack) noexcept {
  const TipMode before = tip_;
  switch (tip_) {
    case TipMode::outside: break;
    case TipMode::stuck:
      if (!contact_.tip_held) { break; }
      if (tip_force_ > cutting_force() + slack.tip) { tip_ = TipMode::cutting; }
      if (tip_force_ < -slack.tip) { tip_ = TipMode::in_track; }
      break;
    case TipMode::cutting:
    case TipMode::in_track:
      if (tip_ == TipMode::cutting ? rate < -slack.velocity
                                   : rate > slack.velocity && depth_begin_ >= cut_) {
        tip_ = contact_.tip_tip > 0.0 ? TipMode::stuck : tip_;
      }
      break;
  }
  return tip_ != before;
}

template <class Real>
bool ToolContact<Real>::update_shaft(double slip, const Slack& slack) noexcept {
  if (!may_hold_shaft()) { return false; }
  const ShaftMode before = shaft_;
  if (shaft_ == ShaftMode::stick) {
    if (contact_.shaft_held && std::abs(shaft_force_) > limit_ + slack.shaft) {
      shaft_ = shaft_force_ > 0.0 ? ShaftMode::forward : ShaftMode::backward;
    }
  } else if (shaft_ == ShaftMode::forward ? slip < -slack.velocity : slip > slack.velocity) {
    shaft_ = ShaftMode::stick;
  }
  return shaft_ != before;
}

// Events of a tool, and their reports.

std::string_view name_of(ToolEvent event) {
  switch (event) {
    case ToolEvent::contact: return "contact";
    case ToolEvent::puncture: return "puncture";
    case ToolEvent::loss_of_resistance: return "loss-of-resistance";
    case ToolEvent::bone: return "bone";
    case ToolEvent::dural_puncture: return "dural-puncture";
    case ToolEvent::withdrawn: break;
  }
  return "withdrawn";
}

ToolState::ToolState(const Scene& scene, const SpringNetwork& network)
    : path_(tool_path(scene, network)) {
  if (scene.syringe) { syringe_.emplace(*scene.syringe); }
}

std::vector<Column> ToolState::columns() const {
  std::vector<Column> columns;
  const auto add = [&](const char* name, const char* unit) { columns.push_back({name, unit, {}}); };
  add("tool.depth_m", "m");
  for (const char* name : {"tool.force_n", "tool.cutting_n", "tool.friction_n", "tool.stiffness_n",
                           "tool.applied_n"}) {
    add(name, "N");
  }
  if (syringe_) {
    add("syringe.pressure_pa", "Pa");
    add("syringe.thumb_n", "N");
  }
  add("tool.insertion_m", "m");
  add("tool.cut_m", "m");
  add("tool.lateral_n", "N");
  return columns;
}

void ToolState::sample(std::span<double> row) const noexcept {
  const ToolForces& f = forces_;
  std::size_t column = 0;
  for (const double value :
       {place_ * path_.direction().z(), f.total, f.cutting, f.friction, f.stiffness, f.applied}) {
    row[column++] = value;
  }
  if (syringe_) {
    row[column++] = syringe_->pressure();
    row[column++] = syringe_->thumb();
  }
  for (const double value : {place_, in_tissue() ? cut_ : 0.0, f.lateral}) {
    row[column++] = value;
  }
}

void ToolState::sample_text(std::span<std::string> row, std::vector<Event>& events) {
  row[0] = in_tissue() ? interval().label : "";
  row[1].clear();
  for (const ToolHappening& happening : happenings()) {
    const std::string name(name_of(happening.event));
    row[1] += (row[1].empty() ? "" : ";") + name;
    events.push_back({happening.time, name, path_.intervals()[happening.interval].label});
  }
  clear_happenings();
}

void ToolState::happen(double t, ToolEvent event, std::size_t interval) noexcept {
  if (happening_count_ < happenings_.size()) {
    happenings_[happening_count_++] = {t, event, interval};
  }
}

/// Reports that the tip begins to cut an interval, once for each interval and in order.
template <class Real> void ToolContact<Real>::enter(std::size_t interval, double t) noexcept {
  for (std::size_t next = entered_ ? deepest_ + 1 : 0; next <= interval; ++next) {
    const TissueRole role = path_.intervals()[next].role;
    happen(t,
           role == TissueRole::epidural_space ? ToolEvent::loss_of_resistance
           : role == TissueRole::dura         ? ToolEvent::dural_puncture
                                              : ToolEvent::puncture,
           next);
    deepest_ = next;
    entered_ = true;
  }
}

template <class Real> void ToolContact<Real>::leave(double t) noexcept {
  if (present_) { happen(t, ToolEvent::withdrawn, 0); }
  present_ = false;
}

template class ToolContact<double>;
template class ToolContact<float>;

}  // namespace palpate
