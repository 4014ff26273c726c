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

template <class Real>
void ToolContact<Real>::happen(double t, ToolEvent event, std::size_t interval) noexcept {
  if (happening_count_ < happenings_.size()) {
    happenings_[happening_count_++] = {t, event, interval};
  }
}

/// The tip begins to cut an interval: reported once each, in order.
template <class Real>
void ToolContact<Real>::enter(std::size_t interval, double t) noexcept {
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

/// A tip that stuck goes on pushing by as much more as in the last step; one that begins to stick has to
/// bring the tissue to its own velocity, whose response to that is known. Where that is more than F_c the step
/// is begun cutting, so that it need not be solved twice; revise() has the last word.
template <class Real>
void ToolContact<Real>::foresee_cutting() noexcept {
  if (tip_ != TipMode::stuck || !held_.learned() || !(contact_.tip_tip > 0.0)) { return; }
  const double response = held_.response_at(at_.knot, at_.share, n_) + tool_mobility();
  const double more = stuck_before_ ? step_tip_change_ : stopped_ / (step_length_ * response);
  if (step_tip_force_ + more > cutting_force()) { tip_ = TipMode::cutting; }
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

template <class Real>
bool ToolContact<Real>::revise(const State<Real>& state) noexcept {
  if (!in_tissue()) { return false; }
  gather(state.position, state.velocity);
  if (is_coordinate()) { velocity_ = static_cast<double>(state.velocity(tool_)); }
  const Slack allowed = slack();
  const bool tip = revise_tip(velocity_ - velocity_at(at_), allowed);
  const bool shaft = revise_shaft(slip_now(), allowed);
  first_evaluation_ = true;
  return tip || shaft;
}

/// The solver's tolerance on velocities and the rounding of places, and the forces over a step that change
/// what is held by as much. A law that is broken by less is the solver's doing: solving again finds it broken
/// the other way. What is left of it is settled when the step ends.
template <class Real>
typename ToolContact<Real>::Slack ToolContact<Real>::slack() const noexcept {
  constexpr double roundings = 8.0 * static_cast<double>(std::numeric_limits<Real>::epsilon());
  double fastest = std::abs(velocity_);
  for (const Knot& knot : knots_) { fastest = std::max(fastest, std::abs(knot.velocity)); }
  const double velocity =
      tolerance_ * fastest + roundings * std::max(std::abs(place_), knots_.back().depth) / step_length_;
  Slack allowed{.velocity = velocity};
  const auto force = [&](std::size_t row) { return velocity / (step_length_ * held_.response_of(row)); };
  if (contact_.tip_held) { allowed.tip = force(0); }
  if (contact_.shaft_held) { allowed.shaft = force(contact_.tip_held ? 1 : 0); }
  return allowed;
}

/// `rate`: of the tip against the tissue when the step ended [m/s].
template <class Real>
bool ToolContact<Real>::revise_tip(double rate, const Slack& slack) noexcept {
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
bool ToolContact<Real>::revise_shaft(double slip, const Slack& slack) noexcept {
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
  losses_.hand += 0.5 * (t - step_begin_) * (hand_power_begin_ + hand_power_end_);
  const bool tip_held = contact_.tip_held;
  const bool shaft_held = contact_.shaft_held;
  if (in_tissue()) {
    weigh();
    const Eigen::Vector2d lost = 0.5 * (t - step_begin_) * (losing_begin_ + losing());
    losses_.cutting += lost.x();
    losses_.friction += lost.y();
  }
  if (is_coordinate()) {
    if (!at_bone_ && place_ >= path_.bone() && velocity_ > 0.0) {
      place_ = path_.bone();
      losses_.impact += 0.5 * mass_ * velocity_ * velocity_;
      velocity_ = 0.0;
      state.position(tool_) = static_cast<Real>(place_);
      state.velocity(tool_) = Real(0);
      at_bone_ = true;
    } else if (at_bone_ && bone_force_ == 0.0) {
      at_bone_ = false;
    }
  } else {
    at_bone_ = trajectory_.place(t) >= path_.bone();
  }
  if (at_bone_ && !bone_seen_) {
    happen(t, ToolEvent::bone, path_.interval_at(path_.bone()));
    bone_seen_ = true;
  }
  contact_.tip_held = tip_held;
  if (tip_ == TipMode::cutting) { enter(path_.interval_at(cut_), t); }
  change_tip(t);
  weigh();
  contact_.tip_held = tip_held;
  contact_.shaft_held = shaft_held;
  change_shaft();
  contact_.tip_held = tip_ == TipMode::stuck && contact_.tip_tip > 0.0;
  contact_.shaft_held = shaft_ == ShaftMode::stick && may_hold_shaft();
  stopped_ = tip_ == TipMode::stuck ? velocity_ - velocity_at(at_) : 0.0;
  if (in_tissue()) {
    match_positions(state);
    match_velocities(state);
  }
  losing_begin_ = losing();
  // How fast the tip moves on through the undeformed tissue, for schemes that predict it.
  depth_rate_ = 0.0;
  if ((tip_ == TipMode::cutting || tip_ == TipMode::in_track) && at_.knot + 1 < knots_.size()) {
    const Knot& low = knots_[at_.knot];
    const Knot& high = knots_[at_.knot + 1];
    const double stretch = 1.0 + (high.displacement - low.displacement) / (high.depth - low.depth);
    if (stretch > 0.0) { depth_rate_ = (velocity_ - velocity_at(at_)) / stretch; }
  }
}

template <class Real>
void ToolContact<Real>::change_tip(double t) noexcept {
  const double skin = knots_.front().depth;
  const double here = depth_at(place_);
  switch (tip_) {
    case TipMode::outside:
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
      break;
    case TipMode::in_track:
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
      break;
    case TipMode::stuck:
      depth_ = cut_;
      if (contact_.tip_held || (contact_.tip_tip <= 0.0 && velocity_ == 0.0)) { break; }
      if (tip_force_ > 0.0 || (cutting_force() == 0.0 && velocity_ > velocity_at(at_))) {
        tip_ = TipMode::cutting;
        enter(path_.interval_at(cut_), t);
      } else {
        tip_ = cut_ > skin ? TipMode::in_track : TipMode::outside;
      }
      break;
    case TipMode::cutting: {
      const std::size_t before = path_.interval_at(cut_);
      cut_ = depth_ = std::max(here, skin);  // a step may end a little behind the deepest point
      const std::size_t after = path_.interval_at(cut_);
      const auto& intervals = path_.intervals();
      if (after > before) {
        if (intervals[after].cutting_force > intervals[before].cutting_force) {
          tip_ = TipMode::stuck;
          if (after > before + 1) { enter(after - 1, t); }
        } else {
          enter(after, t);
        }
      } else if (!(velocity_ > velocity_at(path_.place(cut_)))) {
        tip_ = TipMode::stuck;
      }
      break;
    }
  }
}

template <class Real>
void ToolContact<Real>::leave(double t) noexcept {
  if (present_) { happen(t, ToolEvent::withdrawn, 0); }
  present_ = false;
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

template void ToolContact<double>::begin(const State<double>&) noexcept;
template void ToolContact<float>::begin(const State<float>&) noexcept;
template bool ToolContact<double>::begin_step(double, double, State<double>&, bool) noexcept;
template bool ToolContact<float>::begin_step(double, double, State<float>&, bool) noexcept;
template bool ToolContact<double>::revise(const State<double>&) noexcept;
template bool ToolContact<float>::revise(const State<float>&) noexcept;
template void ToolContact<double>::end_step(double, State<double>&) noexcept;
template void ToolContact<float>::end_step(double, State<float>&) noexcept;

}  // namespace palpate
