// SPDX-License-Identifier: MIT
#pragma once
/// What a scene says about its Falcon, in the device's own words.

#include "device/falcon/emulated_falcon.hpp"
#include "model/dynamics/scene.hpp"

namespace palpate {

/// Where the grip begins, the tip at `drive.from` on its line [m, frame of the device].
Eigen::Vector3d grip_start(const Scene& scene);

device::falcon::EmulatedFalconOptions falcon_options(const Scene& scene);

/// The hand with the intent that the drive describes.
device::Hand hand_of(const Scene& scene);

}  // namespace palpate
