// SPDX-License-Identifier: MIT
#pragma once
/// Firmware, body and faults behind one end of a link.

#include <array>
#include <cstdint>

#include "device/falcon/body.hpp"
#include "device/falcon/firmware.hpp"
#include "device/falcon/link_faults.hpp"
#include "device/falcon/memory_link.hpp"

namespace palpate::device::falcon {

/// What somebody who watches an emulator is told, in the order of time. Times in s, the link's own.
class EmulatorObserver {
 public:
  virtual ~EmulatorObserver() = default;
  virtual void served(double /*time_s*/, const HostPacket& /*request*/,
                      const DevicePacket& /*reply*/) noexcept {}
  virtual void happened(double /*time_s*/, FirmwareEvent /*event*/) noexcept {}
};

/// The body always moves in whole steps of `body_step`, each with the words that arrived before its
/// end. What it does therefore depends on when requests arrive and on nothing else: not on how
/// often serve() is called between them, nor on the speed of the machine.
class Emulator final : public Served, private FirmwareSink {
 public:
  static constexpr double body_step = 50e-6;  ///< [s]

  explicit Emulator(Body& body, const FirmwareOptions& options = {},
                    const FaultScript& faults = {});

  /// Takes what has arrived, moves the body to the link's time, and replies at once. Call whenever
  /// bytes arrive, and now and then without. Allocates nothing.
  void serve(ByteLink& link) noexcept override;
  /// When serve() should be called next though nothing arrives, at the latest [s].
  [[nodiscard]] double next_call(double now_s) const noexcept;

  /// Whether bytes are still on their way, in either direction.
  [[nodiscard]] bool busy() const noexcept { return in_.next_arrival() || out_.next_arrival(); }

  void observe(EmulatorObserver* observer) noexcept { observer_ = observer; }
  [[nodiscard]] const Firmware& firmware() const noexcept { return firmware_; }
  [[nodiscard]] const FaultCounts& faults_to_device() const noexcept { return in_.counts(); }
  [[nodiscard]] const FaultCounts& faults_to_host() const noexcept { return out_.counts(); }
  /// Bytes that the link did not take.
  [[nodiscard]] std::int64_t lost_replies() const noexcept { return lost_writes_; }

 private:
  void send(std::span<const std::uint8_t> bytes) noexcept override;
  void served(const HostPacket& request, const DevicePacket& reply) noexcept override;
  void happened(FirmwareEvent event) noexcept override;

  void move_body(double now_s) noexcept;
  void receive_all(double now_s) noexcept;
  void deliver(ByteLink& link) noexcept;

  Body& body_;
  Firmware firmware_;
  FaultChannel in_;
  FaultChannel out_;
  DeviceFaults device_faults_;
  EmulatorObserver* observer_ = nullptr;
  bool powered_ = true;
  std::int64_t steps_ = 0;  ///< of the body since time 0
  double now_ = 0.0;
  std::int64_t lost_writes_ = 0;
};

}  // namespace palpate::device::falcon
