// SPDX-License-Identifier: MIT

#include "device/frames.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace palpate::device {
namespace {

Frame shifted(double z) { return {.origin = {0.0, 0.0, z}}; }

}  // namespace

Frame libnifalcon_frame() { return {}; }
Frame hapi_frame() { return shifted(0.150); }
Frame vrpn_frame() { return shifted(0.125); }
Frame barrow_frame() { return shifted(0.110); }
Frame hdal_frame() { return shifted(0.125); }

Frame chai3d_frame() {
  Frame frame = shifted(0.125 - 0.010);
  frame.rotation << 0.0, 0.0, 1.0,  //
      1.0, 0.0, 0.0,                //
      0.0, 1.0, 0.0;
  return frame;
}

Frame glove_pie_frame() {
  Frame frame = shifted(0.125);
  frame.rotation(2, 2) = -1.0;
  return frame;
}

ModelFrame model_frame(const Eigen::Vector3d& entry_device, const Eigen::Vector3d& entry_model,
                       const Eigen::Vector3d& direction) {
  constexpr double nearly_x = 0.999;
  const Eigen::Vector3d along = direction.normalized();
  const bool aside = std::abs(along.x()) > nearly_x;
  const Eigen::Vector3d near = aside ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX();
  const Eigen::Vector3d right = (near - along * along.dot(near)).normalized();
  ModelFrame result{.entry_model = entry_model};
  result.frame.origin = entry_device;
  result.frame.rotation.col(0) = right;
  result.frame.rotation.col(1) = (-along).cross(right);
  result.frame.rotation.col(2) = -along;
  return result;
}

}  // namespace palpate::device
