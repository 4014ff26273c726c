// SPDX-License-Identifier: MIT
#pragma once
/// The host's side: what a simulator uses to talk to a Falcon through a link. Raw words and counts;
/// what they mean in space is the kinematics' business.

#include <cstdint>
#include <optional>
#include <span>

#include "device/byte_link.hpp"
#include "device/falcon/packet.hpp"
#include "device/falcon/packet_reader.hpp"

namespace palpate::device::falcon {

struct DriverOptions {
  double reply_deadline = 4e-3;  ///< [s] after which a reply counts as lost
  /// A reply to an earlier request is better than none: for loops that never wait.
  bool keep_late = false;
  int hails = 20;                ///< tries to find a boot loader (libnifalcon: up to 100)
  int probes = 20;               ///< tries to find firmware that runs
  double hail_patience = 20e-3;  ///< [s] for the answer to one hail, and for the echo of a block
};

enum class OpenResult {
  loaded,       ///< the image was echoed rightly, and packets are answered
  was_running,  ///< no boot loader answered, but packets are
  no_answer,
  echo_differs,  ///< the upload was damaged; try again after the device has given it up
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
  /// that comes after the next request was sent is taken for that request's; one that waits already
  /// is thrown away first, unless keep_late says that an old place is better than none.
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

}  // namespace palpate::device::falcon
