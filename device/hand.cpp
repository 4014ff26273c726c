// SPDX-License-Identifier: MIT

#include "device/hand.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "device/seeded.hpp"

namespace palpate::device {
namespace {

/// Minimum-jerk blend from 0 to 1 (Flash and Hogan 1985), followed by its derivative and its
/// integral.
double blend(double t) noexcept { return t * t * t * (10.0 + t * (-15.0 + 6.0 * t)); }
double blend_slope(double t) noexcept { return 30.0 * t * t * (1.0 - t) * (1.0 - t); }
double blend_integral(double t) noexcept { return t * t * t * t * (2.5 + t * (-3.0 + t)); }

void demand(bool holds, const char* rule) {
  if (!holds) { throw std::invalid_argument(rule); }
}

Eigen::Vector3d pull(const HandImpedance& impedance, const Eigen::Vector3d& stretch,
                     const Eigen::Vector3d& stretch_rate) noexcept {
  return impedance.stiffness * stretch + impedance.viscosity * stretch_rate;
}

/// Returns the force of the last stage toward the intent [N]; a push replaces its spring along the
/// axis.
Eigen::Vector3d toward_intent(const HandImpedance& impedance, const Eigen::Vector3d& axis,
                              const IntentPoint& intent, const Eigen::Vector3d& position,
                              const Eigen::Vector3d& velocity) noexcept {
  Eigen::Vector3d stretch = intent.position - position;
  if (intent.pushing) { stretch -= axis * axis.dot(stretch); }
  return pull(impedance, stretch, intent.velocity - velocity) + intent.push * axis;
}

}  // namespace

Intent::Intent(const IntentScript& script)
    : start_(script.start), direction_(script.direction.normalized()), braking_(script.braking) {
  demand(direction_.allFinite() && direction_.norm() > 0.5, "intent.direction must not be zero");
  demand(script.braking > 0.0, "intent.braking must be > 0");
  demand(script.reaction[0] >= 0.0 && script.reaction[1] >= script.reaction[0],
         "intent.reaction must be a range from 0 upward");
  demand(script.tremor >= 0.0, "intent.tremor must be >= 0");
  demand(script.speed_variation >= 0.0 && script.speed_variation < 1.0,
         "intent.speed_variation must be in [0, 1)");
  Seeded seeded(script.seed);
  reaction_ = seeded.uniform(script.reaction[0], script.reaction[1]);
  tremor_ = script.tremor / std::sqrt(static_cast<double>(tremor_sines));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t n = 0; n < tremor_sines; ++n) {
      pulsation_[axis][n] = 2.0 * std::numbers::pi * seeded.uniform(8.0, 12.0);
      phase_[axis][n] = seeded.uniform(0.0, 2.0 * std::numbers::pi);
    }
  }
  const double spread = script.speed_variation;
  for (const Action& action : script.actions) {
    const double pace = 1.0 + seeded.uniform(-spread, spread);
    add(action, pace, seeded);
  }
}

void Intent::append(Segment segment) {
  demand(segments_.empty() || segments_.back().shape != Shape::push,
         "a push must be the last action of its script");
  if (!segments_.empty()) {
    const Segment& last = segments_.back();
    segment.begin = last.begin + last.duration;
    segment.from = last.from + last.distance;
  }
  segments_.push_back(segment);
}

void Intent::add(const Action& action, double pace, Seeded& seeded) {
  const auto cruise = [&](double distance, double speed, double ramp, bool back) {
    demand(distance > 0.0 && speed > 0.0 && ramp > 0.0,
           "distance, speed and ramp of a motion must be > 0");
    const double travel = distance / (speed * pace);
    const double eased = std::min(ramp, travel);
    append({.shape = Shape::cruise,
            .duration = travel + eased,
            .distance = back ? -distance : distance,
            .ramp = eased,
            .withdrawal = back});
  };
  if (const auto* hold = std::get_if<Hold>(&action)) {
    demand(hold->duration > 0.0, "duration of a hold must be > 0");
    append({.shape = Shape::rest, .duration = hold->duration});
  } else if (const auto* advance = std::get_if<Advance>(&action)) {
    cruise(advance->distance, advance->speed, advance->ramp, false);
  } else if (const auto* withdraw = std::get_if<Withdraw>(&action)) {
    cruise(withdraw->distance, withdraw->speed, withdraw->ramp, true);
  } else if (const auto* push = std::get_if<Push>(&action)) {
    demand(push->rise > 0.0 && push->duration >= push->rise, "a push must last its rise or longer");
    append({.shape = Shape::push,
            .duration = push->duration,
            .ramp = push->rise / pace,
            .force = push->force});
  } else if (const auto* steps = std::get_if<Intermittent>(&action)) {
    add_steps(*steps, pace, seeded);
  }
}

void Intent::add_steps(const Intermittent& steps, double pace, Seeded& seeded) {
  demand(steps.distance > 0.0 && steps.step[0] > 0.0 && steps.step[1] >= steps.step[0] &&
             steps.rest[0] > 0.0 && steps.rest[1] >= steps.rest[0] && steps.duration > 0.0,
         "distance, step, rest and duration of intermittent motion must be > 0, ranges ordered");
  for (double left = steps.distance; left > 1e-12;) {
    const double step = std::min(left, seeded.uniform(steps.step[0], steps.step[1]));
    append({.shape = Shape::minimum_jerk, .duration = steps.duration / pace, .distance = step});
    append({.shape = Shape::rest, .duration = seeded.uniform(steps.rest[0], steps.rest[1])});
    left -= step;
  }
}

double Intent::end() const noexcept {
  if (segments_.empty()) { return 0.0; }
  const double last = segments_.back().begin + segments_.back().duration;
  if (!stop_) { return last; }
  return stop_->resume < segments_.size() ? last + stop_->later : stop_->begin + braking_;
}

Intent::Along Intent::evaluate(const Segment& segment, double time) noexcept {
  const double t = std::clamp(time - segment.begin, 0.0, segment.duration);
  const double ramp = segment.ramp;
  Along along{.position = segment.from};
  if (segment.shape == Shape::minimum_jerk) {
    along.position += segment.distance * blend(t / segment.duration);
    along.velocity = segment.distance * blend_slope(t / segment.duration) / segment.duration;
  } else if (segment.shape == Shape::cruise) {
    const double speed = segment.distance / (segment.duration - ramp);
    const double left = segment.duration - t;
    if (t < ramp) {
      along.position += speed * ramp * blend_integral(t / ramp);
    } else if (left < ramp) {
      along.position += segment.distance - speed * ramp * blend_integral(left / ramp);
    } else {
      along.position += speed * (t - 0.5 * ramp);
    }
    along.velocity = speed * blend(std::min({1.0, t / ramp, left / ramp}));
  } else if (segment.shape == Shape::push) {
    along.push = segment.force * std::min(1.0, t / ramp);
    along.pushing = true;
  }
  return along;
}

const Intent::Segment* Intent::segment_at(double time) const noexcept {
  const auto after = std::ranges::upper_bound(segments_, time, {}, &Segment::begin);
  return after == segments_.begin() ? nullptr : &*(after - 1);
}

Intent::Along Intent::script_at(double time, std::size_t first) const noexcept {
  if (segments_.empty()) { return {}; }
  const Segment* segment = segment_at(time);
  if (segment == nullptr || segment < &segments_[first]) { segment = &segments_[first]; }
  Along along = evaluate(*segment, time);
  if (segment->shape != Shape::push && time >= segment->begin + segment->duration) {
    along.velocity = 0.0;
  }
  return along;
}

Intent::Along Intent::along(double time) const noexcept {
  if (!stop_ || time < stop_->begin) { return script_at(time, 0); }
  const double t = std::min(1.0, (time - stop_->begin) / braking_);
  if (t >= 1.0 && stop_->resume < segments_.size()) {
    Along along = script_at(time - stop_->later, stop_->resume);
    along.position += stop_->further;
    return along;
  }
  const Along& from = stop_->from;
  return {.position = from.position + from.velocity * braking_ * (t - blend_integral(t)),
          .velocity = from.velocity * (1.0 - blend(t)),
          .push = from.push * (1.0 - blend(t)),
          .pushing = from.pushing};
}

void Intent::loss_of_resistance(double time) noexcept {
  const Segment* now = segment_at(time);
  if (stop_ || now == nullptr || now->withdrawal) { return; }
  Stop stop{.begin = time + reaction_};
  stop.from = script_at(stop.begin, 0);
  const Segment* last = segment_at(stop.begin);
  if (last->withdrawal) { return; }  // the withdrawal started before the reaction
  stop.resume = static_cast<std::size_t>(last - segments_.data()) + 1;
  while (stop.resume < segments_.size() && !segments_[stop.resume].withdrawal) { ++stop.resume; }
  if (stop.resume < segments_.size()) {
    stop.later = stop.begin + braking_ - segments_[stop.resume].begin;
    stop.further =
        stop.from.position + 0.5 * stop.from.velocity * braking_ - segments_[stop.resume].from;
  }
  stop_ = stop;
}

IntentPoint Intent::at(double time) const noexcept {
  const Along where = along(time);
  IntentPoint point{.position = start_ + where.position * direction_,
                    .velocity = where.velocity * direction_,
                    .push = where.push,
                    .pushing = where.pushing};
  if (tremor_ == 0.0) { return point; }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t n = 0; n < tremor_sines; ++n) {
      const double angle = pulsation_[axis][n] * time + phase_[axis][n];
      point.position[static_cast<Eigen::Index>(axis)] += tremor_ * std::sin(angle);
      point.velocity[static_cast<Eigen::Index>(axis)] +=
          tremor_ * pulsation_[axis][n] * std::cos(angle);
    }
  }
  return point;
}

HandForces hand_forces(const Hand& hand, const IntentPoint& intent,
                       const Eigen::Vector3d& grip_position, const Eigen::Vector3d& grip_velocity,
                       const ArmMotion& arm) noexcept {
  const Eigen::Vector3d& axis = hand.intent.direction();
  if (!hand.arm) {
    return {.on_grip = toward_intent(hand.impedance, axis, intent, grip_position, grip_velocity),
            .on_arm = Eigen::Vector3d::Zero()};
  }
  const Eigen::Vector3d between =
      pull(hand.impedance, arm.position - grip_position, arm.velocity - grip_velocity);
  return {.on_grip = between,
          .on_arm = toward_intent(*hand.arm, axis, intent, arm.position, arm.velocity) - between};
}

}  // namespace palpate::device
