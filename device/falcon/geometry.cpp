// SPDX-License-Identifier: MIT
#include "device/falcon/geometry.hpp"

namespace palpate::device::falcon {
namespace {

constexpr double degree = std::numbers::pi / 180.0;

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

}  // namespace palpate::device::falcon
