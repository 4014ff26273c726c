// SPDX-License-Identifier: MIT

#include "model/problem/tool.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate {

Trajectory::Trajectory(const Drive& drive, double duration) {
  Vertex now{drive.start, drive.from};
  vertices_.push_back(now);
  const bool intermittent = drive.technique == Drive::Technique::intermittent;
  const double target = drive.depth.value_or(std::numeric_limits<double>::infinity());
  while (now.time < duration && now.place < target && drive.speed > 0.0) {
    const double until = intermittent ? now.place + drive.advance
                                      : now.place + drive.speed * (duration - now.time) * 2.0;
    const double next = std::min(until, target);
    if (!(next > now.place)) { break; }  // the advance is lost to rounding
    now = {now.time + (next - now.place) / drive.speed, next};
    vertices_.push_back(now);
    if (intermittent && next < target) {
      now.time += drive.pause;
      vertices_.push_back(now);
    }
  }
  if (now.place >= target && drive.withdraw_speed > 0.0) {
    now.time += drive.hold;
    vertices_.push_back(now);
    now = {now.time + (now.place - drive.from) / drive.withdraw_speed, drive.from};
    vertices_.push_back(now);
  }
}

double Trajectory::place(double t) const noexcept {
  const auto after = std::ranges::upper_bound(vertices_, t, {}, &Vertex::time);
  if (after == vertices_.begin()) { return vertices_.front().place; }
  if (after == vertices_.end()) { return vertices_.back().place; }
  const Vertex& a = *(after - 1);
  const Vertex& b = *after;
  return a.place + (b.place - a.place) * ((t - a.time) / (b.time - a.time));
}

double hand_force(const Drive& drive, double t) noexcept {
  const double since = t - drive.start;
  if (since < 0.0) { return 0.0; }
  if (since < drive.rise) { return drive.force * (since / drive.rise); }
  if (drive.withdraw_force > 0.0 && since >= drive.rise + drive.hold) {
    return -drive.withdraw_force;
  }
  if (drive.technique == Drive::Technique::intermittent) {
    const double phase = std::fmod(since - drive.rise, drive.push + drive.pause);
    return phase < drive.push ? drive.force : 0.0;
  }
  return drive.force;
}

void SyringePressure::advance(double h, double resistance, double thumb) noexcept {
  limit_ = thumb;
  const double friction = syringe_.plunger_friction;
  const double pressed = std::max(thumb - friction, 0.0) / syringe_.plunger_area;
  const double reached = syringe_.thumb_flow * resistance;  // pressure limit of the thumb's flow
  const double decay = std::exp(-h / (resistance * syringe_.compliance));
  if (pressure_ <= pressed) {
    pressure_ = std::min(reached + (pressure_ - reached) * decay, pressed);
    return;
  }
  // The thumb holds less than the pressure: the plunger sticks while fluid leaks, or is driven
  // back.
  const double held = (thumb + friction) / syringe_.plunger_area;
  pressure_ = std::min(std::max(pressure_ * decay, std::min(pressed, reached)), held);
}

double SyringePressure::thumb() const noexcept {
  const double force = pressure_ * syringe_.plunger_area;
  return syringe_.plunger_friction == 0.0 ? force
                                          : std::min(limit_, force + syringe_.plunger_friction);
}

double SyringePressure::thumb_limit(double reaction, bool at_rest) const noexcept {
  const double most = syringe_.thumb_force;
  switch (syringe_.thumb) {
    case Syringe::Thumb::full: return most;
    case Syringe::Thumb::drives:
      return std::clamp((1.0 - syringe_.hand_share) * reaction + syringe_.plunger_friction, 0.0,
                        most);
    case Syringe::Thumb::tests: break;
  }
  return at_rest ? most : 0.0;
}

double SyringePressure::resistance(bool in_tissue, TissueRole role,
                                   const std::optional<double>& own) const noexcept {
  if (!in_tissue) { return syringe_.open_resistance; }
  return own.value_or(role == TissueRole::epidural_space ? syringe_.epidural_resistance
                                                         : syringe_.tissue_resistance);
}

}  // namespace palpate
