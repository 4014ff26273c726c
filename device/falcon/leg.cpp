// SPDX-License-Identifier: MIT
#include "device/falcon/leg.hpp"

#include <cmath>

namespace palpate::device::falcon {

Reach solve_leg(const Geometry& geometry, const LegFrame& frame, const Eigen::Vector3d& position,
                Leg& leg) noexcept {
  const double a = geometry.thigh;
  const double b = geometry.shin;
  const double X = frame.outward.dot(position) - geometry.radial_offset();
  const double w = position.z();
  leg.sideways = frame.sideways.dot(position) + geometry.lateral_offset();
  if (!(w > 0.0) || !(std::abs(leg.sideways) < widest_swing * b)) { return Reach::beyond; }
  leg.height = std::sqrt((b - leg.sideways) * (b + leg.sideways));
  leg.reach = geometry.link_offset() + leg.height;
  const double L = leg.reach;
  const double R = std::sqrt(X * X + w * w);
  // Of the triangle a, L, R; factored, since it straightens at the edge of reach.
  const double area_squared = (a + L - R) * (a - L + R) * (L - a + R) * (a + L + R);
  if (!(area_squared > 0.0) || !std::isfinite(area_squared)) { return Reach::beyond; }
  const double twice = 2.0 * a * R;
  const double cosine_at_base = (R * R + (a - L) * (a + L)) / twice;
  const double sine_at_base = std::sqrt(area_squared) / twice;
  leg.cosine = (X * cosine_at_base + w * sine_at_base) / R;
  leg.sine = (w * cosine_at_base - X * sine_at_base) / R;
  leg.outward = X - a * leg.cosine;
  leg.away = w - a * leg.sine;
  leg.lever = a * R * sine_at_base;
  leg.closure = leg.outward * frame.outward + L * leg.sideways / leg.height * frame.sideways +
                Eigen::Vector3d(0.0, 0.0, leg.away);
  return Reach::within;
}

double curvature_acceleration(const Geometry& geometry, const LegFrame& frame, const Leg& leg,
                              const Eigen::Vector3d& velocity) noexcept {
  const double a = geometry.thigh;
  const double b = geometry.shin;
  const double rate = leg.rate().dot(velocity);
  const double across = frame.sideways.dot(velocity);
  const double outward_rate = frame.outward.dot(velocity) + a * leg.sine * rate;
  const double away_rate = velocity.z() - a * leg.cosine * rate;
  const double slope = leg.sideways / leg.height;                       // -dL/dv
  const double bend = -b * b / (leg.height * leg.height * leg.height);  // d2L/dv2
  const double pull = a * (leg.outward * leg.cosine + leg.away * leg.sine) * rate * rate;
  return (outward_rate * outward_rate + away_rate * away_rate + pull -
          (slope * slope + leg.reach * bend) * across * across) /
         leg.lever;
}

}  // namespace palpate::device::falcon
