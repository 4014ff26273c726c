// SPDX-License-Identifier: MIT
#pragma once
/// The device's side of the conversation (libnifalcon's FalconComm and FalconFirmware, its old C
/// driver, and K. Machulis' posts of 2008):
///
///   boot   0A 43 0D        is answered by 0A 44 2C 0D      -> ready
///   ready  41              is echoed                       -> load
///   load   any byte        is echoed: that is the whole checksum of an upload
///          begin_run(), the change of baud rate that a byte stream does not carry  -> run
///   run    well-formed packet    exactly one reply; anything else: none
///
/// A well-formed packet puts every state into run and is answered: a driver may skip loading. In
/// load its first 15 bytes have been echoed by then. Bytes in, bytes out; no I/O, no clock.

#include <array>
#include <cstdint>
#include <span>

#include "device/byte_link.hpp"
#include "device/falcon/body.hpp"
#include "device/falcon/link_faults.hpp"
#include "device/falcon/packet.hpp"

namespace palpate::device::falcon {

enum class FirmwareState { boot, ready, load, run };

/// What a log should know beside requests. Each is counted, too.
enum class FirmwareEvent {
  hail,        ///< answered 0A 43 0D
  load_begun,  ///< echoed 41
  run_begun,
  skipped_load,    ///< violation: a packet came before any firmware
  stray_bytes,     ///< violation: bytes that say nothing in this state
  bad_frame,       ///< violation: a packet was begun and not finished rightly
  early_run,       ///< violation: change of baud rate with nothing loaded
  watchdog,        ///< torque dropped, requests having stopped
  load_abandoned,  ///< ready or load fell back to boot, the host being silent
  power_loss,
};
inline constexpr std::size_t firmware_event_count = 10;

struct FirmwareOptions {
  /// Words read as zero from so long after the last request on [s]. A word acts "only for a very
  /// short time" (Machulis 2008); the duration was never measured: an assumption.
  double watchdog = 0.020;
  /// Silence after which an upload counts as abandoned [s]. Assumed, as a byte stream does not
  /// carry the DTR line with which a driver starts anew.
  double load_silence = 1.0;
  bool loaded = false;  ///< begins in run, as a device that another program has loaded
};

/// Where the firmware's output goes while it receives.
class FirmwareSink {
 public:
  virtual ~FirmwareSink() = default;
  virtual void send(std::span<const std::uint8_t> bytes) noexcept = 0;
  virtual void served(const HostPacket& /*request*/, const DevicePacket& /*reply*/) noexcept {}
  virtual void happened(FirmwareEvent /*event*/) noexcept {}
};

class Firmware {
 public:
  explicit Firmware(const FirmwareOptions& options = {}) noexcept;

  /// Takes bytes that arrived at now_s [s], which never goes back; replies hold `present`. No bytes
  /// are allowed: time goes on.
  void receive(std::span<const std::uint8_t> bytes, double now_s, const DevicePacket& present,
               FirmwareSink& sink) noexcept;
  /// The host changed to the baud rate of the run phase.
  void begin_run(double now_s, FirmwareSink& sink) noexcept;
  void lose_power(double now_s, FirmwareSink& sink) noexcept;

  [[nodiscard]] FirmwareState state() const noexcept { return state_; }
  /// Motor words as received, zero when requests stopped.
  [[nodiscard]] std::array<std::int16_t, 3> words(double now_s) const noexcept;
  [[nodiscard]] bool homing(double now_s) const noexcept;
  [[nodiscard]] Leds leds() const noexcept { return last_.leds; }  ///< as last commanded

  [[nodiscard]] const ReaderCounts& reader_counts() const noexcept { return reader_.counts(); }
  [[nodiscard]] std::int64_t replies() const noexcept { return replies_; }
  [[nodiscard]] std::int64_t echoed_bytes() const noexcept { return echoed_bytes_; }
  [[nodiscard]] std::int64_t count(FirmwareEvent event) const noexcept {
    return events_[static_cast<std::size_t>(event)];
  }

 private:
  void note(FirmwareEvent event, FirmwareSink& sink) noexcept;
  void pass_time(double now_s, FirmwareSink& sink) noexcept;
  void take(std::uint8_t byte, FirmwareSink& sink) noexcept;
  void answer(const HostPacket& request, double now_s, const DevicePacket& present,
              FirmwareSink& sink) noexcept;
  [[nodiscard]] bool asked_lately(double now_s) const noexcept;

  FirmwareOptions options_;
  FirmwareState state_;
  PacketReader<HostPacket> reader_{};
  std::size_t hail_matched_ = 0;  ///< bytes of 0A 43 0D
  HostPacket last_{};
  bool asked_ = false;           ///< there was a request since power came
  bool watchdog_noted_ = false;  ///< since the last request
  double torque_end_ = 0.0;      ///< unless a request comes before [s]
  double byte_time_ = 0.0;       ///< of the last byte of any kind [s]
  bool stray_noted_ = false;     ///< one event for a run of stray bytes
  std::int64_t replies_ = 0;
  std::int64_t echoed_bytes_ = 0;
  std::array<std::int64_t, firmware_event_count> events_{};
};

const char* name_of(FirmwareState state) noexcept;
const char* name_of(FirmwareEvent event) noexcept;

// Firmware, body and faults behind one end of a link.

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
