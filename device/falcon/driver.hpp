// SPDX-License-Identifier: MIT
#pragma once
/// The host's side of the Falcon link, for a simulator. Driver exchanges raw words and counts;
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
  double reply_deadline = 4e-3;  ///< [s] after which a reply is treated as lost
  /// Accept the reply to an earlier request, for loops that never wait.
  bool keep_late = false;
  int hails = 20;                ///< tries to find a boot loader (libnifalcon: up to 100)
  int probes = 20;               ///< tries to find firmware that runs
  double hail_patience = 20e-3;  ///< [s] for the answer to one hail, and for the echo of a block
};

enum class OpenResult {
  loaded,       ///< the image was echoed correctly, and packets are answered
  was_running,  ///< no boot loader answered, but packets are
  no_answer,
  echo_differs,  ///< the upload was damaged; retry after the device has abandoned it
};

struct DriverCounts {
  std::int64_t requests = 0;
  std::int64_t replies = 0;      ///< in time
  std::int64_t lost = 0;         ///< requests whose deadline passed
  std::int64_t late = 0;         ///< replies that came after it, found before the next request
  std::int64_t superfluous = 0;  ///< further replies within one exchange; the newest one counts
  bool operator==(const DriverCounts&) const = default;
};

class Driver {
 public:
  explicit Driver(ByteLink& link, const DriverOptions& options = {}) noexcept
      : link_(link), options_(options) {}

  /// Hails the boot loader first: a probe by packet is said to spoil the upload that follows
  /// (M. Goerner's driver, 2025). Uploads `image` when it answers.
  OpenResult open(std::span<const std::uint8_t> image) noexcept;
  /// Whether packets are answered; leaves the motors off.
  bool probe() noexcept;

  /// One request and its reply; nothing when none came in time. Replies bear no number, so one
  /// that arrives after the next request is treated as the reply to that request. One that waits
  /// already is discarded first, unless keep_late is set.
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

/// Conversion of counts and forces by a driver. `CorrectProfile` is exact; `StockProfile`
/// reproduces the errors of libnifalcon (f7c727a), so that results can be given for both.
class DriverProfile {
 public:
  virtual ~DriverProfile() = default;
  /// Position [m] that the driver reports for these counts; the last one when it finds none.
  virtual Eigen::Vector3d position(const Counts& counts) noexcept = 0;
  /// Words for a force on the hand [N] at the reported position of the grip [m].
  virtual Command words(const Eigen::Vector3d& position,
                        const Eigen::Vector3d& force_on_hand) noexcept = 0;
};

/// Exact forward solution, true Jacobian, words clamped.
class CorrectProfile final : public DriverProfile {
 public:
  explicit CorrectProfile(const Kinematics& kinematics = Kinematics(),
                          const MotorOptions& motors = {})
      : kinematics_(kinematics), motors_(motors) {}
  Eigen::Vector3d position(const Counts& counts) noexcept override;
  Command words(const Eigen::Vector3d& position,
                const Eigen::Vector3d& force_on_hand) noexcept override;

 private:
  Kinematics kinematics_;
  MotorOptions motors_;
  Eigen::Vector3d position_ = Kinematics::cold_start();
};

/// libnifalcon's three defects. (1) In the row of each leg the rate along z has sin(theta2) squared
/// where sin(theta2) sin(theta3) belongs (its issue 66), in forces and read-out alike. (2) Words
/// are neither clamped nor calibrated: 10,000 per N m, low 16 bits sent. (3) The read-out takes
/// half steps of Newton's method and stops with the first that began within 0.01 rad: at loop rate
/// a one-pole filter.
class StockProfile final : public DriverProfile {
 public:
  explicit StockProfile(const Geometry& geometry = libnifalcon()) : kinematics_(geometry) {}
  Eigen::Vector3d position(const Counts& counts) noexcept override;
  Command words(const Eigen::Vector3d& position,
                const Eigen::Vector3d& force_on_hand) noexcept override;

 private:
  Kinematics kinematics_;
  Eigen::Vector3d position_{0.0, 0.0, 0.080};  ///< where its first read-out starts
};

/// The Jacobian that libnifalcon uses [m/rad], wrong in z; nothing beyond reach.
std::optional<Eigen::Matrix3d> stock_jacobian(const Kinematics& kinematics,
                                              const Eigen::Vector3d& position) noexcept;

}  // namespace palpate::device::falcon
