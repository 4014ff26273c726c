// SPDX-License-Identifier: MIT

#include "device/frames.hpp"

#include <Eigen/LU>

#include "tests/check.hpp"

namespace {

using namespace palpate::device;
using Vector = Eigen::Vector3d;

const Vector grip(0.01, 0.02, 0.135);
const Vector force(1.0, 2.0, 3.0);

TEST("each consumer sees the grip where its documentation says") {
  constexpr double rounding = 1e-16;
  CHECK_NEAR(libnifalcon_frame().point(grip), grip, 0.0);
  CHECK_NEAR(hapi_frame().point(grip), Vector(0.01, 0.02, -0.015), rounding);
  CHECK_NEAR(vrpn_frame().point(grip), Vector(0.01, 0.02, 0.010), rounding);
  CHECK_NEAR(barrow_frame().point(grip), Vector(0.01, 0.02, 0.025), rounding);
  CHECK_NEAR(hdal_frame().point(grip), Vector(0.01, 0.02, 0.010), rounding);
  CHECK_NEAR(chai3d_frame().point(grip), Vector(0.020, 0.01, 0.02), rounding);
  CHECK_NEAR(glove_pie_frame().point(grip), Vector(0.01, 0.02, -0.010), rounding);
}

TEST("each consumer sees forces turned and not shifted") {
  for (const Frame& frame :
       {libnifalcon_frame(), hapi_frame(), vrpn_frame(), barrow_frame(), hdal_frame()}) {
    CHECK_NEAR(frame.vector(force), force, 0.0);
  }
  CHECK_NEAR(chai3d_frame().vector(force), Vector(3.0, 1.0, 2.0), 0.0);
  CHECK_NEAR(glove_pie_frame().vector(force), Vector(1.0, 2.0, -3.0), 0.0);
}

TEST("every frame goes both ways, and only GlovePIE's is left-handed") {
  for (const Frame& frame : {libnifalcon_frame(), hapi_frame(), vrpn_frame(), barrow_frame(),
                             hdal_frame(), chai3d_frame(), glove_pie_frame()}) {
    CHECK_NEAR(frame.point_back(frame.point(grip)), grip, 1e-16);
    CHECK_NEAR(frame.vector_back(frame.vector(force)), force, 0.0);
    CHECK_NEAR(std::abs(frame.rotation.determinant()), 1.0, 0.0);
  }
  CHECK_NEAR(chai3d_frame().rotation.determinant(), 1.0, 0.0);
  CHECK_NEAR(glove_pie_frame().rotation.determinant(), -1.0, 0.0);
}

TEST("pushing away from the user drives the needle along its direction from its entry") {
  const Vector entry_device(0.0, 0.01, 0.14);
  const Vector entry_model(0.005, -0.003, 0.0);
  for (const Vector& direction :
       {Vector(0.0, 0.0, 1.0), Vector(0.3, -0.2, 0.9), Vector(1.0, 0.0, 0.0),
        Vector(-1.0, 1e-3, 0.0), Vector(0.0, 1.0, 0.0)}) {
    const ModelFrame frame = model_frame(entry_device, entry_model, direction);
    const Eigen::Matrix3d& turn = frame.frame.rotation;
    CHECK_NEAR(turn * turn.transpose(), Eigen::Matrix3d::Identity(), 1e-15);
    CHECK_NEAR(turn.determinant(), 1.0, 1e-15);  // both frames are right-handed
    CHECK_NEAR(frame.point(entry_device), entry_model, 1e-17);
    const Vector pushed = entry_device + Vector(0.0, 0.0, -0.02);
    CHECK_NEAR(frame.point(pushed), entry_model + 0.02 * direction.normalized(), 1e-16);
    CHECK_NEAR(frame.point_back(frame.point(grip)), grip, 1e-16);
    CHECK_NEAR(frame.vector_back(frame.vector(force)), force, 1e-15);
  }
}

TEST("straight into the tissue, right stays right and up becomes -y") {
  const ModelFrame frame = model_frame(Vector::Zero(), Vector::Zero(), {0.0, 0.0, 2.0});
  CHECK_NEAR(frame.vector(Vector::UnitX()), Vector::UnitX(), 0.0);
  CHECK_NEAR(frame.vector(Vector::UnitY()), -Vector::UnitY(), 0.0);
  CHECK_NEAR(frame.vector(Vector::UnitZ()), -Vector::UnitZ(), 0.0);
}

TEST("a mounted needle keeps its offset and reports the torque that cannot be rendered") {
  const SyringeMount mount{.grip_to_tip = {0.0, -0.02, -0.1}};
  CHECK_NEAR(mount.tip(grip), Vector(0.01, 0.0, 0.035), 1e-16);
  CHECK_NEAR(mount.grip(mount.tip(grip)), grip, 1e-16);
  CHECK_NEAR(mount.unrendered_torque({1.0, 0.0, 0.0}), Vector(0.0, -0.1, 0.02), 1e-16);
  CHECK_NEAR(mount.unrendered_torque(mount.grip_to_tip), Vector::Zero(), 0.0);
}

}  // namespace
