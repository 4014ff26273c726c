// SPDX-License-Identifier: MIT
#pragma once
/// What a scene says about its Falcon, in the device's own words.

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

/// Where the grip begins, the tip at `drive.from` on its line [m, frame of the device].
Eigen::Vector3d grip_start(const Scene& scene);

device::falcon::EmulatedFalconOptions falcon_options(const Scene& scene);

/// The hand with the intent that the drive describes.
device::Hand hand_of(const Scene& scene);

// A scene's tool in a hand, through an emulated Falcon: hand and device, driver and wire, coupling,
// tool and tissue, in lock step and virtual time (model/EQUATIONS.md, "Haptic loop").

/// Over a whole run.
struct FalconFacts {
  long ticks = 0;                  ///< of the haptic loop
  long saturated = 0;              ///< of them, with a motor at its limit
  double largest_requested = 0.0;  ///< [N]
  double largest_delivered = 0.0;  ///< [N]
  double weakest_force = 0.0;      ///< that every direction can have at the start [N]
  double axial_force = 0.0;        ///< against the insertion, at the start [N]
  /// Of what the motors can pull with at the start, frame of the device [N].
  std::array<Eigen::Vector3d, 8> force_corners{};
  double least_energy = 0.0;                   ///< of the observer at the port, never above 0 [J]
  double least_energy_at = 0.0;                ///< [s]
  double taken_by_controller = 0.0;            ///< [J]
  std::optional<double> lost_resistance_at{};  ///< [s]
  double overshoot = 0.0;                      ///< of the tip beyond where resistance was lost [m]
  double reaction = 0.0;                       ///< of the hand after it [s]
  long unanswered = 0;                         ///< requests without a reply
  long unhomed = 0;  ///< ticks without a place: the device had lost it; no force was asked for
};

struct FalconLoopOptions {
  int extra_delay = 0;                   ///< further ticks, for tests of the harness
  device::falcon::FaultScript faults{};  ///< on the line, times from the start of the run
  device::falcon::EmulatorObserver* observer = nullptr;  ///< receives every packet
};

class FalconLoop {
 public:
  /// Of a scene whose drive is the Falcon; scene and subject outlive the loop. Throws
  /// std::invalid_argument where the grip would start beyond reach.
  FalconLoop(const Scene& scene, Subject& subject, const FalconLoopOptions& options = {});

  /// Every tick of the device waits for the wall clock from now on; nothing else changes.
  void follow(device::DeadlineClock* clock) { clock_ = clock; }
  /// One tick of the simulation, with all ticks of the device in it.
  StepStatus tick() noexcept;
  /// The next tick of the device alone; with the last one of a step the simulation's. Time is the
  /// caller's.
  StepStatus device_tick() noexcept;
  /// In place of a device_tick(): nothing is read, computed or sent in it, so the device goes on
  /// with the force that it has; the tissue is stepped as ever.
  StepStatus missed_device_tick() noexcept;

  /// Names and units of what sample() writes: "device.x_m", ...
  [[nodiscard]] static std::vector<Column> columns();
  void sample(std::span<double> row) const noexcept;
  [[nodiscard]] FalconFacts facts() const noexcept;
  [[nodiscard]] const device::falcon::EmulatedFalcon& falcon() const { return falcon_; }
  /// Who is told of every packet; outlives the loop.
  void observe(device::falcon::EmulatorObserver* observer) noexcept { falcon_.observe(observer); }
  /// What the device was asked for last, on the hand [N], frame of the device.
  [[nodiscard]] const Eigen::Vector3d& force_sent() const { return servo_.sent(); }

 private:
  [[nodiscard]] Eigen::Vector3d render(const device::DeviceSample& sample, double time) noexcept;
  [[nodiscard]] double guide(int axis, double velocity) const noexcept;
  void estimate_velocity(const Eigen::Vector3d& place) noexcept;
  void watch_tool() noexcept;
  /// Device and hand to the end of this tick; with the last one of a step, the tissue.
  StepStatus finish_device_tick() noexcept;
  [[nodiscard]] double device_time() const noexcept {
    return subject_.time() + ticks_of_step_ * period_;
  }

  FalconDrive settings_;
  Subject& subject_;
  std::optional<ToolInput> input_{};  ///< of the next step
  double period_;                     ///< of the haptic loop [s]
  int ticks_per_step_;                ///< of the tissue
  int ticks_of_step_ = 0;             ///< of the present step, done
  device::DeadlineClock* clock_ = nullptr;
  device::falcon::EmulatedFalcon falcon_;
  device::ServoLoop servo_;
  device::PassivityObserver observer_{};
  device::PassivityController controller_;
  Eigen::Vector3d start_;
  double start_place_;  ///< s of the tip there [m]
  Eigen::Vector3d place_;
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();
  double velocity_share_;  ///< of a new difference in the estimate
  bool in_tissue_ = false;
  Eigen::Vector2d entry_{0.0, 0.0};  ///< of the grip when the tip went in [m]
  double deepest_ = 0.0;
  FalconFacts facts_{};
};

}  // namespace palpate
