// SPDX-License-Identifier: MIT

#include "validation/subject/capabilities.hpp"

#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate;

TEST("other simulators under test get probes with a rigid and flat face only") {
  Scene scene;
  scene.probe = Probe{};
  CHECK(needs_of(scene, {}) == PALPATE_CAN_PROBE);
  scene.probe->tip_radius = 0.01;
  CHECK_THROWS(needs_of(scene, {}), "only the model has");
  scene.probe = Probe{.face = Probe::FaceKind::uniform};
  CHECK_THROWS(needs_of(scene, {}), "only the model has");
}

}  // namespace PALPATE_FILE
