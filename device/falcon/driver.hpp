// SPDX-License-Identifier: MIT
#pragma once
/// Host side of the Falcon link, for a simulator. Driver exchanges raw words and counts;
/// DriverProfile converts them to positions and forces.

#include <cstdint>
#include <optional>
#include <span>

#include "device/byte_link.hpp"
#include "device/falcon/kinematics.hpp"
#include "device/falcon/motors_encoders.hpp"
#include "device/falcon/packet.hpp"

namespace palpate::device::falcon {

struct DriverOptions {
  double reply_deadline = 4e-3;  ///< time after which a reply is treated as lost [s]
  /// Accepts the reply to an earlier request, for loops that do not wait.
  bool keep_late = false;
  int hails = 20;                ///< attempts to find a boot loader (libnifalcon: up to 100)
  int probes = 20;               ///< attempts to find running firmware
  double hail_patience = 20e-3;  ///< timeout of a hail and of the echo of a block [s]
};

enum class OpenResult {
  loaded,       ///< the image was echoed correctly, and the device replies to packets
  was_running,  ///< no boot loader answered, but the device replies to packets
  no_answer,
  echo_differs,  ///< the upload was damaged; retry after the device has abandoned it
};

struct DriverCounts {
  std::int64_t requests = 0;
  std::int64_t replies = 0;      ///< replies before the deadline
  std::int64_t lost = 0;         ///< requests whose deadline passed
  std::int64_t late = 0;         ///< replies after the deadline, read before the next request
  std::int64_t superfluous = 0;  ///< additional replies within one exchange; the newest one is used
  bool operator==(const DriverCounts&) const = default;
};

class Driver {
 public:
  explicit Driver(ByteLink& link, const DriverOptions& options = {}) noexcept
      : link_(link), options_(options) {}

  /// Connects to the device and uploads `image` if the boot loader answers. The boot loader is
  /// hailed before any probe, because a probe packet can damage the following upload (M. Goerner's
  /// driver, 2025).
  OpenResult open(std::span<const std::uint8_t> image) noexcept;
  /// Returns true if the device replies to packets. Leaves the motors off.
  bool probe() noexcept;

  /// Sends one request and returns its reply, or nothing if no reply arrives in time. Replies are
  /// not numbered: one that arrives after the next request is treated as the reply to that request.
  /// A reply that is already in the buffer is discarded first, unless keep_late is set.
  std::optional<DevicePacket> exchange(const HostPacket& request) noexcept;

  [[nodiscard]] const DriverCounts& counts() const noexcept { return counts_; }
  [[nodiscard]] const ReaderCounts& reader_counts() const noexcept { return reader_.counts(); }

 private:
  bool await(std::span<const std::uint8_t> expected, double patience_s) noexcept;
  bool hail() noexcept;
  bool upload(std::span<const std::uint8_t> image) noexcept;
  std::optional<DevicePacket> read_newest(std::int64_t& count) noexcept;
  void discard() noexcept;

  ByteLink& link_;
  DriverOptions options_;
  PacketReader<DevicePacket> reader_{};
  DriverCounts counts_{};
};

/// Conversion of counts and forces by a driver.
class DriverProfile {
 public:
  /// `correct` has the exact forward solution, the true Jacobian and clamped words. `stock`
  /// reproduces three defects of libnifalcon (f7c727a). (1) The row of each leg uses sin(theta2)
  /// squared for the rate along z instead of sin(theta2) sin(theta3) (issue 66), in forces and in
  /// position. (2) Words are neither clamped nor calibrated: 10,000 per N m, the low 16 bits are
  /// sent. (3) The position uses half Newton steps and stops after the first step that began within
  /// 0.01 rad, which acts as a one-pole filter at loop rate.
  enum class Kind { correct, stock };

  /// `motors` is ignored by a stock profile.
  explicit DriverProfile(Kind kind, const Kinematics& kinematics = Kinematics(),
                         const MotorOptions& motors = {});
  /// Returns the position [m] that the driver reports for these counts, or the previous position if
  /// there is no solution.
  Eigen::Vector3d position(const Counts& counts) noexcept;
  /// Returns the motor words for a force on the hand [N] at the reported position of the grip [m].
  [[nodiscard]] Command words(const Eigen::Vector3d& position,
                              const Eigen::Vector3d& force_on_hand) const noexcept;

 private:
  void stock_steps(const Eigen::Vector3d& theta1) noexcept;

  Kind kind_;
  Kinematics kinematics_;
  MotorOptions motors_;
  Eigen::Vector3d position_;  ///< the last one, and the initial guess of the next [m]
};

/// Returns the Jacobian that libnifalcon uses [m/rad], wrong in z, or nothing beyond the reach.
std::optional<Eigen::Matrix3d> stock_jacobian(const Kinematics& kinematics,
                                              const Eigen::Vector3d& position) noexcept;

}  // namespace palpate::device::falcon
