// SPDX-License-Identifier: MIT
/// What changes between two steps: modes of tip and shaft, and the velocities of what begins to stick.
#include <algorithm>
#include <cmath>
#include <limits>

#include "model/stepping/tool_contact.hpp"

namespace palpate {

namespace {
/// A tip this far off the skin has left it; one that rests there is not told of every rebound [m].
constexpr double clear_of_skin = 1e-6;
}  // namespace

template <class Real>
void ToolContact<Real>::begin(const State<Real>& state) noexcept {
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
    foresee_cutting();
  }
  return changed;
}

template <class Real>
bool ToolContact<Real>::follow(double t, double h, State<Real>& state) noexcept {
  const double from = std::min(trajectory_.place(t), path_.bone());
  const double to = std::min(trajectory_.place(t + h), path_.bone());
  const double velocity = (to - from) / h;
  // Differences of places are rounded: that alone is no jump.
  const double rounding = 8.0 * std::numeric_limits<double>::epsilon() *
                          std::max(std::abs(from), std::abs(to)) / h;
  place_begin_ = from;
  if (std::abs(velocity - velocity_) <= rounding) { return false; }
  velocity_ = velocity;
  if (!in_tissue()) { return false; }
  gather(state.position, state.velocity);
  weigh();
  contact_.tip_held = tip_ == TipMode::stuck && contact_.tip_tip > 0.0 &&
                      velocity_ > velocity_at(at_);  // the tip pushes, it cannot pull
  turn_shaft(h);
  match_velocities(state);
  losing_begin_ = losing();
  return true;
}

template <class Real>
double ToolContact<Real>::slip_now() const noexcept {
  double slip = velocity_;
  for (std::size_t k = 0; k < knots_.size() && limit_ > 0.0; ++k) {
    slip -= shaft_share_[k] * knots_[k].velocity;
  }
  return slip;
}

/// After a jump of the drive the shaft slides the way it is moved; it rests where its friction, which
/// is bounded, can stop the slip within the step.
template <class Real>
void ToolContact<Real>::turn_shaft(double h) noexcept {
  slip_ = limit_ > 0.0 ? slip_now() : 0.0;
  const bool rests = may_hold_shaft() && std::abs(slip_) <= limit_ * contact_.shaft_shaft * h;
  contact_.shaft_held = rests;
  if (rests) {
    shaft_ = ShaftMode::stick;
  } else if (slip_ != 0.0) {
    shaft_ = slip_ > 0.0 ? ShaftMode::forward : ShaftMode::backward;
  }
}

template <class Real>
Eigen::Vector2d ToolContact<Real>::losing() const noexcept {
  const double slip = slip_now();
  const double cut = cutting_force() * (velocity_ - velocity_at(at_));
  return {tip_ == TipMode::cutting ? cut : 0.0,
          shaft_ == ShaftMode::stick ? 0.0 : limit_ * std::abs(slip)};
}

template <class Real>
void ToolContact<Real>::end_step(double t, State<Real>& state) noexcept {
  gather(state.position, state.velocity);
  lag_.setZero();
  const bool stuck = tip_ == TipMode::stuck;
  step_tip_change_ = stuck && stuck_before_ ? tip_force_ - step_tip_force_ : 0.0;
  step_tip_force_ = tip_force_;
  stuck_before_ = stuck;
  if (predict_) {  // where revising found no answer, the law has the last word
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
  losing_begin_ = losing();
  depth_rate_ = depth_rate();
}

/// What the hand gave and the tissue took in a step of h.
template <class Real>
void ToolContact<Real>::account(double h) noexcept {
  losses_.hand += 0.5 * h * (hand_power_begin_ + hand_power_end_);
  if (!in_tissue()) { return; }
  weigh();
  const Eigen::Vector2d lost = 0.5 * h * (losing_begin_ + losing());
  losses_.cutting += lost.x();
  losses_.friction += lost.y();
}

template <class Real>
void ToolContact<Real>::meet_bone(double t, State<Real>& state) noexcept {
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

/// `held`: what was when the step ended.
template <class Real>
void ToolContact<Real>::change_modes(double t, const Contact& held) noexcept {
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

/// How fast the tip moves on through the undeformed tissue [m/s], for schemes that predict it.
template <class Real>
double ToolContact<Real>::depth_rate() const noexcept {
  const bool moves = tip_ == TipMode::cutting || tip_ == TipMode::in_track;
  if (!moves || at_.knot + 1 >= knots_.size()) { return 0.0; }
  const Knot& low = knots_[at_.knot];
  const Knot& high = knots_[at_.knot + 1];
  const double stretch = 1.0 + (high.displacement - low.displacement) / (high.depth - low.depth);
  return stretch > 0.0 ? (velocity_ - velocity_at(at_)) / stretch : 0.0;
}

template <class Real>
void ToolContact<Real>::change_tip(double t) noexcept {
  const double here = depth_at(place_);
  switch (tip_) {
    case TipMode::outside: change_outside(here, t); break;
    case TipMode::in_track: change_in_track(here, t); break;
    case TipMode::stuck: change_stuck(t); break;
    case TipMode::cutting: change_cutting(here, t); break;
  }
}

template <class Real>
void ToolContact<Real>::change_outside(double here, double t) noexcept {
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

template <class Real>
void ToolContact<Real>::change_in_track(double here, double t) noexcept {
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

template <class Real>
void ToolContact<Real>::change_stuck(double t) noexcept {
  depth_ = cut_;
  if (contact_.tip_held || (contact_.tip_tip <= 0.0 && velocity_ == 0.0)) { return; }
  if (tip_force_ > 0.0 || (cutting_force() == 0.0 && velocity_ > velocity_at(at_))) {
    tip_ = TipMode::cutting;
    enter(path_.interval_at(cut_), t);
  } else {
    tip_ = cut_ > knots_.front().depth ? TipMode::in_track : TipMode::outside;
  }
}

template <class Real>
void ToolContact<Real>::change_cutting(double here, double t) noexcept {
  const std::size_t before = path_.interval_at(cut_);
  cut_ = depth_ = std::max(here, knots_.front().depth);  // a step may end a little behind the deepest point
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

template <class Real>
void ToolContact<Real>::change_shaft() noexcept {
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
    // What was held gives way to the force that was too much; the slip itself is rounding still. A shaft
    // that only now has tissue to rub against was not held.
    const double sense = may_hold_shaft() && shaft_force_ != 0.0 ? shaft_force_ : slip_;
    shaft_ = sense > 0.0 ? ShaftMode::forward : ShaftMode::backward;
  }
}

template void ToolContact<double>::begin(const State<double>&) noexcept;
template void ToolContact<float>::begin(const State<float>&) noexcept;
template bool ToolContact<double>::begin_step(double, double, State<double>&, bool) noexcept;
template bool ToolContact<float>::begin_step(double, double, State<float>&, bool) noexcept;
template double ToolContact<double>::slip_now() const noexcept;
template double ToolContact<float>::slip_now() const noexcept;
template void ToolContact<double>::end_step(double, State<double>&) noexcept;
template void ToolContact<float>::end_step(double, State<float>&) noexcept;

}  // namespace palpate
