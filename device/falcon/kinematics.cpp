// SPDX-License-Identifier: MIT

#include "device/falcon/kinematics.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace palpate::device::falcon {
namespace {

constexpr double degree = std::numbers::pi / 180.0;

/// Largest |v + f| / b that is within the reach of a leg. At 1 the parallelogram is folded flat and
/// the derivatives are infinite.
constexpr double widest_swing = 1.0 - 1e-4;

/// Computes `leg` with the knee outside, the only branch of the mechanism. Returns false beyond the
/// reach or behind the base plane; then `leg` is unspecified.
bool solve_leg(const Geometry& geometry, const LegFrame& frame, const Eigen::Vector3d& position,
               Leg& leg) noexcept {
  const double a = geometry.thigh;
  const double b = geometry.shin;
  const double X = frame.outward.dot(position) - geometry.radial_offset();
  const double w = position.z();
  leg.sideways = frame.sideways.dot(position) + geometry.lateral_offset();
  if (!(w > 0.0) || !(std::abs(leg.sideways) < widest_swing * b)) { return false; }
  leg.height = std::sqrt((b - leg.sideways) * (b + leg.sideways));
  leg.reach = geometry.link_offset() + leg.height;
  const double L = leg.reach;
  const double R = std::sqrt(X * X + w * w);
  // Area of the triangle a, L, R. The factored form is accurate where the triangle degenerates at
  // the edge of the reach.
  const double area_squared = (a + L - R) * (a - L + R) * (L - a + R) * (a + L + R);
  if (!(area_squared > 0.0) || !std::isfinite(area_squared)) { return false; }
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
  return true;
}

constexpr double longest_step = 0.030;  // [m]
constexpr double last_step = 1e-9;      // [m]; the error after it is its square times 1/m
constexpr int most_steps = 40;
constexpr double ring_radius = 0.075;  // of further initial guesses, near the edge of the lens [m]
constexpr int ring_starts = 12;
constexpr double angle_tolerance = 1e-9;  // between the requested angles and those found [rad]

/// Returns six times the volume spanned by the gradients of the closures: negative from the centre
/// outward until the mechanism collapses, where it is zero.
double handedness(const std::array<Leg, 3>& legs) noexcept {
  return legs[0].closure.cross(legs[1].closure).dot(legs[2].closure);
}

/// Returns true if the arms of `legs` have these angles.
bool stands_at(const std::array<Leg, 3>& legs, const Eigen::Vector3d& cosine,
               const Eigen::Vector3d& sine) noexcept {
  for (int i = 0; i < 3; ++i) {
    const Leg& leg = legs[static_cast<std::size_t>(i)];
    const double sine_of_error = leg.sine * cosine[i] - leg.cosine * sine[i];
    const double cosine_of_error = leg.cosine * cosine[i] + leg.sine * sine[i];
    // At the edge of the reach theta1 is dominated by rounding, so the closure is compared.
    const double rounding = 1e-15 / leg.lever;
    if (!(std::abs(sine_of_error) < angle_tolerance + rounding)) { return false; }
    if (cosine_of_error < 0.0) { return false; }
  }
  return true;
}

}  // namespace

Geometry libnifalcon() {
  Geometry geometry;
  geometry.azimuth = {105.0 * degree, -15.0 * degree, -135.0 * degree};
  geometry.zero_angle = 35.0 * degree;
  return geometry;
}

Geometry martin_hillier() {
  Geometry geometry = libnifalcon();
  geometry.knee_offset = 0.0115;
  geometry.foot_offset = 0.0115;
  geometry.effector_radius = 0.0157;
  geometry.effector_lateral = -0.0262;
  geometry.base_radius = 0.0366;
  geometry.base_lateral = -0.0272;
  geometry.reduction = 7.62;
  return geometry;
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

Kinematics::Kinematics(const Geometry& geometry) : geometry_(geometry) {
  for (std::size_t leg = 0; leg < 3; ++leg) {
    const double cosine = std::cos(geometry.azimuth[leg]);
    const double sine = std::sin(geometry.azimuth[leg]);
    frames_[leg] = {.outward = {cosine, sine, 0.0}, .sideways = {-sine, cosine, 0.0}};
  }
}

std::optional<std::array<Leg, 3>> Kinematics::legs(const Eigen::Vector3d& position) const noexcept {
  std::array<Leg, 3> legs;
  for (std::size_t leg = 0; leg < 3; ++leg) {
    if (!solve_leg(geometry_, frames_[leg], position, legs[leg])) { return std::nullopt; }
  }
  if (handedness(legs) >= 0.0) { return std::nullopt; }
  return legs;
}

std::optional<LegAngles> Kinematics::inverse(const Eigen::Vector3d& position) const noexcept {
  const auto shapes = legs(position);
  if (!shapes) { return std::nullopt; }
  LegAngles angles{.theta1 = angles_at_base(*shapes)};
  for (int i = 0; i < 3; ++i) {
    const Leg& leg = (*shapes)[static_cast<std::size_t>(i)];
    angles.theta2[i] = std::atan2(leg.away, leg.outward);
    angles.theta3[i] = std::atan2(leg.height, leg.sideways);
  }
  return angles;
}

void Kinematics::closures(const Eigen::Vector3d& cosine, const Eigen::Vector3d& sine,
                          const Eigen::Vector3d& position, Eigen::Matrix3d& slope,
                          Eigen::Vector3d& value) const noexcept {
  const double b = geometry_.shin;
  for (int i = 0; i < 3; ++i) {
    const LegFrame& leg = frame(i);
    // A guess may exceed the length of the shin, where L has no derivative.
    const double most = widest_swing * b;
    const double across =
        std::clamp(leg.sideways.dot(position) + geometry_.lateral_offset(), -most, most);
    const double height = std::sqrt((b - across) * (b + across));
    const double reach = geometry_.link_offset() + height;
    const double outward =
        leg.outward.dot(position) - geometry_.radial_offset() - geometry_.thigh * cosine[i];
    const double away = position.z() - geometry_.thigh * sine[i];
    value[i] = 0.5 * (outward * outward + away * away - reach * reach);
    slope.row(i) = (outward * leg.outward + reach * across / height * leg.sideways).transpose();
    slope(i, 2) += away;
  }
}

std::optional<Eigen::Vector3d> Kinematics::newton(const Eigen::Vector3d& theta1,
                                                  const Eigen::Vector3d& start) const noexcept {
  const Eigen::Vector3d cosine = theta1.array().cos();
  const Eigen::Vector3d sine = theta1.array().sin();
  Eigen::Vector3d position = start;
  Eigen::Matrix3d slope;
  Eigen::Vector3d value;
  bool converged = false;
  for (int n = 0; n < most_steps && !converged; ++n) {
    closures(cosine, sine, position, slope, value);
    Eigen::Vector3d step = -(slope.inverse() * value);
    const double length = step.norm();
    if (!std::isfinite(length)) { return std::nullopt; }
    if (length > longest_step) { step *= longest_step / length; }
    position += step;
    converged = length < last_step;
  }
  if (!converged) { return std::nullopt; }
  const auto found = legs(position);
  if (!found || !stands_at(*found, cosine, sine)) { return std::nullopt; }
  return position;
}

std::optional<Eigen::Vector3d> Kinematics::forward(const Eigen::Vector3d& theta1,
                                                   const Eigen::Vector3d& start) const noexcept {
  std::optional<Eigen::Vector3d> position = newton(theta1, start);
  for (const double z : {0.09, 0.13, 0.16}) {
    for (int n = 0; n < ring_starts && !position; ++n) {
      const double turn = 2.0 * std::numbers::pi * n / ring_starts;
      position = newton(theta1, {ring_radius * std::cos(turn), ring_radius * std::sin(turn), z});
    }
  }
  return position;
}

std::optional<Eigen::Matrix3d> Kinematics::jacobian(
    const Eigen::Vector3d& position) const noexcept {
  const auto shapes = legs(position);
  if (!shapes) { return std::nullopt; }
  return falcon::jacobian(*shapes);
}

Eigen::Vector3d angles_at_base(const std::array<Leg, 3>& legs) noexcept {
  Eigen::Vector3d theta1;
  for (int i = 0; i < 3; ++i) {
    const Leg& leg = legs[static_cast<std::size_t>(i)];
    theta1[i] = std::atan2(leg.sine, leg.cosine);
  }
  return theta1;
}

Eigen::Matrix3d inverse_jacobian(const std::array<Leg, 3>& legs) noexcept {
  Eigen::Matrix3d result;
  for (int i = 0; i < 3; ++i) { result.row(i) = legs[static_cast<std::size_t>(i)].rate(); }
  return result;
}

Eigen::Matrix3d jacobian(const std::array<Leg, 3>& legs) noexcept {
  Eigen::Matrix3d closure;
  Eigen::Vector3d lever;
  for (int i = 0; i < 3; ++i) {
    const Leg& leg = legs[static_cast<std::size_t>(i)];
    closure.row(i) = leg.closure;
    lever[i] = leg.lever;
  }
  return closure.inverse() * lever.asDiagonal();
}

Eigen::Vector3d force_of_torque(const Eigen::Matrix3d& jacobian,
                                const Eigen::Vector3d& torque) noexcept {
  return jacobian.transpose().inverse() * torque;
}

double largest_force(const Eigen::Matrix3d& jacobian, const Eigen::Vector3d& direction,
                     double largest_torque) noexcept {
  return largest_torque / (jacobian.transpose() * direction).cwiseAbs().maxCoeff();
}

WeakestDirection weakest_direction(const Eigen::Matrix3d& jacobian,
                                   double largest_torque) noexcept {
  Eigen::Index leg = 0;
  const double longest = jacobian.colwise().norm().maxCoeff(&leg);
  return {.direction = jacobian.col(leg) / longest, .force = largest_torque / longest};
}

}  // namespace palpate::device::falcon
