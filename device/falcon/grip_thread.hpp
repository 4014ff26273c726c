// SPDX-License-Identifier: MIT
#pragma once
/// Thread that exchanges packets with a Falcon on a line, so that a loop with deadlines never waits
/// for the line. Loop and thread pass the newest reading and the newest force through triple
/// buffers.

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

#include "device/byte_link.hpp"
#include "device/falcon/driver.hpp"
#include "device/latest_value.hpp"

namespace palpate::device::falcon {

enum class GripState : int {
  none,     ///< no device
  opening,  ///< looks for the device, or loads its firmware
  homing,   ///< a person must pull the grip out and push it in; no force
  ramp,     ///< the force rises from zero to its whole size
  ready,
  silent,   ///< no replies: no force
  stopped,  ///< emergency stop: no force
  ended     ///< the line is closed
};

struct GripReading {
  double place = 0.0;     ///< travel of the grip along the axis of insertion [m]
  double velocity = 0.0;  ///< [m/s]
  GripState state = GripState::none;

  /// True if the place is that of a grip that a person holds.
  [[nodiscard]] bool valid() const { return state == GripState::ramp || state == GripState::ready; }
};

struct ForceOrder {
  double push = 0.0;  ///< force on the hand against the insertion [N]
  long count = 0;     ///< rises with every order
  bool stopped = false;
};

struct GripThreadOptions {
  std::vector<std::uint8_t>
      firmware{};           ///< file for the boot loader; empty: the device runs already
  double most_force = 8.0;  ///< [N]; larger orders are reduced to it
  double ramp = 1.0;        ///< time in which the force rises after homing or a gap [s]
  double watchdog = 0.02;  ///< without a reply, or without a new order, for this time: no force [s]
  double period = 1e-3;    ///< [s]
};

struct GripThreadCounts {
  std::int64_t exchanges = 0;
  std::int64_t lost = 0;         ///< exchanges without a reply
  std::int64_t implausible = 0;  ///< replies with a position that no hand reaches; ignored
  std::int64_t watchdog = 0;     ///< times at which the force was switched off
  std::int64_t limited = 0;      ///< orders above the limit
};

class GripThread {
 public:
  /// Starts the thread. The link must outlive the object.
  GripThread(ByteLink& link, const GripThreadOptions& options);
  /// Sends zero torque and ends the thread.
  ~GripThread();
  GripThread(const GripThread&) = delete;
  GripThread& operator=(const GripThread&) = delete;

  /// Newest reading; called by the loop only. Neither waits nor makes a system call.
  const GripReading& reading() noexcept { return reading_.get(); }
  /// Sets the force from now on; called by the loop only.
  void order(const ForceOrder& order) noexcept { order_.set(order); }
  /// Sends zero torque and ends the thread. The counts no longer change.
  void stop();
  [[nodiscard]] const GripThreadCounts& counts() const { return counts_; }

 private:
  void run() noexcept;
  [[nodiscard]] bool open() noexcept;
  void exchange(double time) noexcept;
  [[nodiscard]] double force(double time) noexcept;
  void read(const DevicePacket& reply) noexcept;
  void tell(GripState state) noexcept;
  void let_go() noexcept;

  ByteLink& link_;
  GripThreadOptions options_;
  Driver driver_;
  DriverProfile profile_{DriverProfile::Kind::correct};
  LatestValue<GripReading> reading_{};
  LatestValue<ForceOrder> order_{};
  GripThreadCounts counts_{};
  Eigen::Vector3d position_{0.0, 0.0, 0.0};
  double velocity_ = 0.0;  ///< along z [m/s]
  int jumps_ = 0;          ///< implausible positions in a row
  bool placed_ = false;    ///< position_ is of the exchange before
  GripState state_ = GripState::opening;
  double answered_ = 0.0;  ///< time of the last reply [s]
  double ordered_ = 0.0;   ///< time of the last new order [s]
  long order_count_ = 0;
  double scale_ = 0.0;  ///< of the force, rises during the ramp
  bool off_ = true;     ///< the force was switched off
  std::atomic<bool> stop_{false};
  std::thread thread_{};
};

}  // namespace palpate::device::falcon
