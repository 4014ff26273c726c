// SPDX-License-Identifier: MIT
#pragma once
/// Recording of every packet of a session with its time, for inspection and replay.

#include <cstdint>
#include <iosfwd>
#include <stdexcept>
#include <vector>

#include "device/falcon/emulator.hpp"

namespace palpate::device::falcon {

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
