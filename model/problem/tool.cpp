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

void SyringePressure::advance(double h, bool in_tissue, TissueRole role) noexcept {
  const double resistance = !in_tissue                           ? syringe_.open_resistance
                            : role == TissueRole::epidural_space ? syringe_.epidural_resistance
                                                                 : syringe_.tissue_resistance;
  const double limit = syringe_.thumb_force / syringe_.plunger_area;
  const double reached = syringe_.thumb_flow * resistance;  // pressure limit of the thumb's flow
  const double after =
      reached + (pressure_ - reached) * std::exp(-h / (resistance * syringe_.compliance));
  pressure_ = std::min(after, limit);
}

}  // namespace palpate
