// SPDX-License-Identifier: MIT
#include "validation/falcon_setting.hpp"

namespace palpate {

namespace {

FalconDrive settings_of(const Scene& scene) { return scene.falcon.value_or(FalconDrive{}); }
Drive drive_of(const Scene& scene) { return scene.drive.value_or(Drive{}); }

/// Further than any duration takes it where the drive names no depth.
double way_in(const Scene& scene, const Drive& drive) {
  if (drive.depth) { return *drive.depth - drive.from; }
  return drive.speed * (scene.simulation.duration + 1.0);
}

void add_advance(const Scene& scene, const Drive& drive, device::IntentScript& script) {
  const double distance = way_in(scene, drive);
  if (drive.technique == Drive::Technique::continuous) {
    script.actions.emplace_back(device::Advance{.distance = distance, .speed = drive.speed});
    return;
  }
  script.actions.emplace_back(device::Intermittent{.distance = distance,
                                                   .step = {drive.advance, drive.advance},
                                                   .rest = {drive.pause, drive.pause},
                                                   .duration = 1.875 * drive.advance / drive.speed});
}

}  // namespace

Eigen::Vector3d grip_start(const Scene& scene) {
  return {0.0, 0.0, settings_of(scene).start_height - drive_of(scene).from};
}

device::falcon::EmulatedFalconOptions falcon_options(const Scene& scene) {
  const FalconDrive settings = settings_of(scene);
  device::falcon::EmulatedFalconOptions options;
  options.body.geometry = settings.geometry == FalconDrive::Geometry::martin_hillier
                              ? device::falcon::martin_hillier()
                              : device::falcon::libnifalcon();
  options.body.start = grip_start(scene);
  options.body.seed = static_cast<std::uint64_t>(settings.seed);
  options.body.plant.gravity = 0.0;  // the person bears it, see docs/falcon.md
  if (!settings.friction) {
    options.body.plant.coulomb = 0.0;
    options.body.plant.viscosity = 0.0;
  }
  options.stock_profile = settings.profile == FalconDrive::Profile::stock;
  options.wire = settings.quantised;
  return options;
}

device::Hand hand_of(const Scene& scene) {
  const FalconDrive settings = settings_of(scene);
  const Drive drive = drive_of(scene);
  device::Hand hand;
  switch (settings.hand) {
    case FalconDrive::Hand::light:
      hand.impedance = device::light_hand;
      break;
    case FalconDrive::Hand::medium:
      break;
    case FalconDrive::Hand::firm:
      hand.impedance = device::firm_hand;
      break;
    case FalconDrive::Hand::two_stage:
      hand.arm = device::arm_stage;
      break;
  }
  device::IntentScript script{.start = grip_start(scene),
                              .reaction = {settings.reaction_delay, settings.reaction_delay},
                              .tremor = settings.tremor,
                              .seed = static_cast<std::uint64_t>(settings.seed)};
  if (drive.start > 0.0) { script.actions.emplace_back(device::Hold{drive.start}); }
  add_advance(scene, drive, script);
  if (drive.withdraw_speed > 0.0) {
    if (drive.hold > 0.0) { script.actions.emplace_back(device::Hold{drive.hold}); }
    script.actions.emplace_back(
        device::Withdraw{.distance = way_in(scene, drive), .speed = drive.withdraw_speed});
  }
  hand.intent = device::Intent(script);
  return hand;
}

}  // namespace palpate
