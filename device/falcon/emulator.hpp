// SPDX-License-Identifier: MIT
#pragma once
/// Emulated firmware of the Falcon (sources: libnifalcon's FalconComm and FalconFirmware, its old C
/// driver, and K. Machulis' posts of 2008):
///
///   boot   0A 43 0D        is answered by 0A 44 2C 0D      -> ready
///   ready  41              is echoed                       -> load
///   load   any byte        is echoed; a host checks its upload by the echo alone
///          begin_run(): the host changed the baud rate (ByteLink::baud(); pipes have none)  -> run
///   run    well-formed packet    exactly one reply; anything else: none
///
/// A well-formed packet switches any state to run and gets a reply. In boot and ready this also
/// counts as `skipped_load`. In load, its first 15 bytes have been echoed by then. The class does
/// no I/O and reads no clock.

#include <array>
#include <cstdint>
#include <iosfwd>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "device/byte_link.hpp"
#include "device/falcon/body.hpp"
#include "device/falcon/link_faults.hpp"
#include "device/falcon/packet.hpp"

namespace palpate::device::falcon {

enum class FirmwareState { boot, ready, load, run };

/// Firmware event that is logged and counted, in addition to requests.
enum class FirmwareEvent {
  hail,        ///< 0A 43 0D was answered
  load_begun,  ///< 41 was echoed
  run_begun,
  skipped_load,    ///< violation: a packet arrived before any firmware
  stray_bytes,     ///< violation: bytes without a meaning in this state
  bad_frame,       ///< violation: a packet was begun but not completed correctly
  early_run,       ///< violation: change of baud rate with nothing loaded
  watchdog,        ///< torque was switched off because requests stopped
  load_abandoned,  ///< ready or load returned to boot because the host was silent
  power_loss,
};
inline constexpr std::size_t firmware_event_count = 10;

struct FirmwareOptions {
  /// Time after the last request at which motor words become zero [s]. This is an assumption: a
  /// word acts "only for a very short time" (Machulis 2008), and no measurement is published.
  double watchdog = 0.020;
  /// Silence after which an upload is abandoned [s]. This is an assumption: a byte stream does not
  /// carry the DTR line that a driver uses to restart.
  double load_silence = 1.0;
  bool loaded = false;  ///< initial state is run, as after loading by another program
};

/// Interface that receives the output of the firmware.
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

  /// Processes bytes that arrived at `now_s` [s]; `now_s` must not decrease. Every
  /// reply is `present`, the current state of the device. An empty span only advances the time.
  void receive(std::span<const std::uint8_t> bytes, double now_s, const DevicePacket& present,
               FirmwareSink& sink) noexcept;
  /// Reports that the host changed to the baud rate of the run phase.
  void begin_run(double now_s, FirmwareSink& sink) noexcept;
  void lose_power(double now_s, FirmwareSink& sink) noexcept;

  [[nodiscard]] FirmwareState state() const noexcept { return state_; }
  /// Returns the motor words as received, or zero if requests have stopped.
  [[nodiscard]] std::array<std::int16_t, 3> words(double now_s) const noexcept;
  [[nodiscard]] bool homing(double now_s) const noexcept;
  [[nodiscard]] Leds leds() const noexcept { return last_.leds; }  ///< last commanded LEDs

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
  std::size_t hail_matched_ = 0;  ///< matched bytes of 0A 43 0D
  HostPacket last_{};
  bool asked_ = false;           ///< a request arrived since power-on
  bool watchdog_noted_ = false;  ///< reported since the last request
  double torque_end_ = 0.0;      ///< time at which torque ends without a further request [s]
  double byte_time_ = 0.0;       ///< arrival time of the last byte [s]
  bool stray_noted_ = false;     ///< one event per run of stray bytes
  std::int64_t replies_ = 0;
  std::int64_t echoed_bytes_ = 0;
  std::array<std::int64_t, firmware_event_count> events_{};
};

const char* name_of(FirmwareState state) noexcept;
const char* name_of(FirmwareEvent event) noexcept;

// Firmware, body and faults at one end of a link.

/// Observer of an emulator. It receives events in order of time; times are in s, on the clock of
/// the link.
class EmulatorObserver {
 public:
  virtual ~EmulatorObserver() = default;
  virtual void served(double /*time_s*/, const HostPacket& /*request*/,
                      const DevicePacket& /*reply*/) noexcept {}
  virtual void happened(double /*time_s*/, FirmwareEvent /*event*/) noexcept {}
};

/// Emulated device: firmware, body and link faults. The body advances in whole steps of
/// `body_step`, each with the motor words that arrived before its end. Its motion therefore depends
/// only on the arrival times of requests, not on the frequency of serve() calls or the speed of the
/// machine.
class Emulator final : public Served, private FirmwareSink {
 public:
  static constexpr double body_step = 50e-6;  ///< [s]

  explicit Emulator(Body& body, const FirmwareOptions& options = {},
                    const FaultScript& faults = {});

  /// Processes received bytes, advances the body to the time of the link and replies at once. Call
  /// it when bytes arrive and periodically otherwise. Does not allocate.
  void serve(ByteLink& link) noexcept override;
  /// Returns the latest time of the next serve() call if no bytes arrive [s].
  [[nodiscard]] double next_call(double now_s) const noexcept;

  /// Returns true if bytes are in transit in either direction.
  [[nodiscard]] bool busy() const noexcept { return in_.next_arrival() || out_.next_arrival(); }

  void observe(EmulatorObserver* observer) noexcept { observer_ = observer; }
  [[nodiscard]] const Firmware& firmware() const noexcept { return firmware_; }
  [[nodiscard]] const FaultCounts& faults_to_device() const noexcept { return in_.counts(); }
  [[nodiscard]] const FaultCounts& faults_to_host() const noexcept { return out_.counts(); }
  /// Number of writes that lost bytes because the link was full or closed.
  [[nodiscard]] std::int64_t lost_writes() const noexcept { return lost_writes_; }

 private:
  void send(std::span<const std::uint8_t> bytes) noexcept override;
  void served(const HostPacket& request, const DevicePacket& reply) noexcept override;
  void happened(FirmwareEvent event) noexcept override;

  void follow_baud(const ByteLink& link) noexcept;
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
  unsigned baud_ = 0;       ///< of the link at the last call; 0: unknown
  std::int64_t steps_ = 0;  ///< number of body steps since time 0
  double now_ = 0.0;
  std::int64_t lost_writes_ = 0;
};

// Recording of every packet of a session with its time, for inspection and replay.

struct WireRecord {
  double time = 0.0;  ///< [s]
  enum class Direction { to_device, to_host } direction = Direction::to_device;
  PacketBytes bytes{};
  bool operator==(const WireRecord&) const = default;
};

/// Recorder of packets in memory reserved at construction. Further packets are counted but not
/// kept.
class WireRecording final : public EmulatorObserver {
 public:
  explicit WireRecording(std::size_t most_records) { records_.reserve(most_records); }
  explicit WireRecording(std::vector<WireRecord> records) : records_(std::move(records)) {}

  void served(double time_s, const HostPacket& request,
              const DevicePacket& reply) noexcept override;
  [[nodiscard]] const std::vector<WireRecord>& records() const noexcept { return records_; }
  [[nodiscard]] std::int64_t left_out() const noexcept { return left_out_; }

 private:
  void add(const WireRecord& record) noexcept;
  std::vector<WireRecord> records_;
  std::int64_t left_out_ = 0;
};

struct ReplayResult {
  std::int64_t requests = 0;
  std::int64_t different_replies = 0;
};

/// Sends the recorded requests at their recorded times to an emulator and compares its replies bit
/// for bit. The same body from the same start gives the same replies.
ReplayResult replay(const WireRecording& recording, Emulator& emulator);

/// Writes CSV: time_s (shortest digits that read back the same), direction, the 16 bytes in
/// hexadecimal.
void write_csv(std::ostream& out, const WireRecording& recording);

/// Error in a recording, with a message such as "line 3: ...; what is allowed".
struct RecordingError : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// Reads the output of write_csv(). Throws RecordingError at the first line in another form and for
/// packets that are not well-formed.
WireRecording read_csv(std::istream& in);

}  // namespace palpate::device::falcon
