// SPDX-License-Identifier: MIT
#pragma once
/// Falcon options and grip position of a scene, and the lock-step loop that runs it.

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "device/falcon/emulated_falcon.hpp"
#include "device/real_time.hpp"
#include "device/servo_loop.hpp"
#include "model/problem/scene.hpp"
#include "validation/subject/subject.hpp"

namespace palpate {

/// Returns the initial grip position, with the tip at `drive.from` on its line [m, frame of the
/// device].
Eigen::Vector3d grip_start(const Scene& scene);

device::falcon::EmulatedFalconOptions falcon_options(const Scene& scene);

/// Returns the hand with the intent that the drive describes.
device::Hand hand_of(const Scene& scene);

// Loop of a hand-held tool through an emulated Falcon: hand and device, driver and line, coupling,
// tool and tissue, in lock step and virtual time (model/EQUATIONS.md, "Haptic loop").

/// Facts of the Falcon loop over a whole run.
struct FalconFacts {
  long ticks = 0;                  ///< ticks of the haptic loop
  long saturated = 0;              ///< ticks with a motor at its limit
  double largest_requested = 0.0;  ///< [N]
  double largest_delivered = 0.0;  ///< [N]
  double weakest_force = 0.0;      ///< force available in every direction at the start [N]
  double axial_force = 0.0;        ///< available force against the insertion at the start [N]
  /// Largest forces at the start in directions all round, frame of the device [N].
  std::vector<Eigen::Vector3d> force_reach{};
  double least_energy = 0.0;  ///< least energy of the passivity observer at the port, at most 0 [J]
  double least_energy_at = 0.0;                ///< [s]
  double taken_by_controller = 0.0;            ///< [J]
  std::optional<double> lost_resistance_at{};  ///< [s]
  double overshoot = 0.0;  ///< travel of the tip beyond the loss of resistance [m]
  double reaction = 0.0;   ///< reaction time of the hand after the loss of resistance [s]
  long unanswered = 0;     ///< requests without reply
  long unhomed = 0;  ///< ticks in which the device had lost its position; no force was requested
};

struct FalconLoopOptions {
  int extra_delay = 0;                   ///< additional delay [ticks], for tests of the harness
  device::falcon::FaultScript faults{};  ///< faults on the line, times from the start of the run
  device::falcon::EmulatorObserver* observer = nullptr;  ///< receives every packet
};

class FalconLoop {
 public:
  /// Prepares the loop of a scene driven by a Falcon. Scene and subject must outlive it. Throws
  /// std::invalid_argument if the grip would start out of reach.
  FalconLoop(const Scene& scene, Subject& subject, const FalconLoopOptions& options = {});

  /// Paces every device tick by the wall clock from now on; the computation is unchanged.
  void follow(device::DeadlineClock* clock) { clock_ = clock; }
  /// Advances by one tick of the simulation, including all its device ticks.
  StepStatus tick() noexcept;
  /// Advances by one device tick; the last one of a step also advances the simulation. The caller
  /// controls the time.
  StepStatus device_tick() noexcept;
  /// Replaces a device_tick() that was missed: nothing is read, computed or sent, so the device
  /// keeps its force. The tissue is stepped as usual.
  StepStatus missed_device_tick() noexcept;

  /// Returns the names and units of the values that sample() writes.
  [[nodiscard]] static std::vector<Column> columns();
  void sample(std::span<double> row) const noexcept;
  [[nodiscard]] FalconFacts facts() const noexcept;
  [[nodiscard]] const device::falcon::EmulatedFalcon& falcon() const { return falcon_; }
  /// Sets the observer that receives every packet; it must outlive the loop.
  void observe(device::falcon::EmulatorObserver* observer) noexcept { falcon_.observe(observer); }
  /// Returns the last requested force on the hand [N], frame of the device.
  [[nodiscard]] const Eigen::Vector3d& force_sent() const { return servo_.sent(); }

 private:
  [[nodiscard]] Eigen::Vector3d render(const device::DeviceSample& sample, double time) noexcept;
  [[nodiscard]] double guide(int axis, double velocity) const noexcept;
  void estimate_velocity(const Eigen::Vector3d& place) noexcept;
  void watch_tool() noexcept;
  /// Advances device and hand to the end of this tick, and the tissue with the last one of a step.
  StepStatus finish_device_tick() noexcept;
  [[nodiscard]] double device_time() const noexcept {
    return subject_.time() + ticks_of_step_ * period_;
  }

  FalconDrive settings_;
  Subject& subject_;
  std::optional<ToolInput> input_{};  ///< input of the next step
  double period_;                     ///< period of the haptic loop [s]
  int ticks_per_step_;                ///< ticks per tissue step
  int ticks_of_step_ = 0;             ///< ticks done in the current step
  device::DeadlineClock* clock_ = nullptr;
  device::falcon::EmulatedFalcon falcon_;
  device::ServoLoop servo_;
  device::PassivityObserver observer_{};
  device::PassivityController controller_;
  Eigen::Vector3d start_;
  double start_place_;  ///< path coordinate of the tip at the start [m]
  Eigen::Vector3d place_;
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();
  double velocity_share_;  ///< weight of a new difference in the velocity estimate [1]
  bool in_tissue_ = false;
  Eigen::Vector2d entry_{0.0, 0.0};  ///< grip position when the tip entered the tissue [m]
  double deepest_ = 0.0;
  FalconFacts facts_{};
};

}  // namespace palpate
