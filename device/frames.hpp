// SPDX-License-Identifier: MIT
#pragma once
/// Frames in which software around the Falcon speaks, against ours, which is libnifalcon's: x
/// right, y up, z toward the user, metres, workspace centred on (0, 0, 0.125). Right-handed.

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace palpate::device {

/// other = rotation (ours - origin): `origin` is where the other frame's origin lies in ours [m].
struct Frame {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< det -1: the other is left-handed
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();

  [[nodiscard]] Eigen::Vector3d point(const Eigen::Vector3d& ours) const noexcept {
    return rotation * (ours - origin);
  }
  [[nodiscard]] Eigen::Vector3d point_back(const Eigen::Vector3d& other) const noexcept {
    return rotation.transpose() * other + origin;
  }
  /// Velocities and forces, which have no origin.
  [[nodiscard]] Eigen::Vector3d vector(const Eigen::Vector3d& ours) const noexcept {
    return rotation * ours;
  }
  [[nodiscard]] Eigen::Vector3d vector_back(const Eigen::Vector3d& other) const noexcept {
    return rotation.transpose() * other;
  }
};

Frame libnifalcon_frame();  ///< ours itself
Frame hapi_frame();         ///< (x, y, z - 150 mm); H3D sees the same
Frame vrpn_frame();         ///< (x, y, z - 125 mm)
Frame barrow_frame();       ///< (x, y, z - 110 mm): A. Barrow's example in libnifalcon
Frame hdal_frame();         ///< centred on the workspace, right-handed, near is +z
Frame chai3d_frame();       ///< (z + 10 mm, x, y) of HDAL: X toward the user, Y right, Z up
Frame glove_pie_frame();  ///< z into the device, left-handed; its origin, undocumented, the centre

/// The model's frame: right-handed, +z into the tissue. The grip's way from `entry_device` on is
/// the needle's way from `entry_model` on; pushing away from the user, our -z, is `direction`. The
/// rest of the turn is the least surprising one: our x becomes the model's x, as far as that is
/// square to the direction (its y, should the direction be x). It is a rotation: for the direction
/// (0, 0, 1) our up, +y, is the model's -y.
struct ModelFrame {
  Frame frame{};
  Eigen::Vector3d entry_model = Eigen::Vector3d::Zero();

  [[nodiscard]] Eigen::Vector3d point(const Eigen::Vector3d& device) const noexcept {
    return frame.point(device) + entry_model;
  }
  [[nodiscard]] Eigen::Vector3d point_back(const Eigen::Vector3d& model) const noexcept {
    return frame.point_back(model - entry_model);
  }
  [[nodiscard]] Eigen::Vector3d vector(const Eigen::Vector3d& device) const noexcept {
    return frame.vector(device);
  }
  [[nodiscard]] Eigen::Vector3d vector_back(const Eigen::Vector3d& model) const noexcept {
    return frame.vector_back(model);
  }
};
ModelFrame model_frame(const Eigen::Vector3d& entry_device, const Eigen::Vector3d& entry_model,
                       const Eigen::Vector3d& direction);

// A syringe with its needle, fixed rigidly to the grip of a device that does not turn.

struct SyringeMount {
  Eigen::Vector3d grip_to_tip{0.0, 0.0, -0.10};  ///< device frame [m]
  double mass = 0.02;                            ///< goes into the plant's tool_mass [kg]

  [[nodiscard]] Eigen::Vector3d tip(const Eigen::Vector3d& grip) const noexcept {
    return grip + grip_to_tip;
  }
  [[nodiscard]] Eigen::Vector3d grip(const Eigen::Vector3d& tip) const noexcept {
    return tip - grip_to_tip;
  }
  /// Torque about the grip [N m] of a force at the tip [N]. A hand on a real syringe feels it; a
  /// device without rotation cannot render it: the force alone goes to the grip, unchanged.
  [[nodiscard]] Eigen::Vector3d unrendered_torque(const Eigen::Vector3d& force) const noexcept {
    return grip_to_tip.cross(force);
  }
};

}  // namespace palpate::device
