// SPDX-License-Identifier: MIT
#pragma once
/// Faults between host and device, scripted in time and drawn from a seeded generator. The same
/// seed and bytes give the same faults on every machine.

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "device/byte_link.hpp"
#include "device/falcon/packet.hpp"
#include "device/seeded.hpp"

namespace palpate::device::falcon {

/// Fault of one kind during [start, end).
struct LinkFault {
  enum class Kind {
    latency,        ///< bytes arrive late, those of one write together, never out of order
    drop,           ///< a byte is lost
    duplicate,      ///< a byte is received twice
    corrupt,        ///< a byte is changed
    unplug,         ///< every byte is lost; the device keeps its power
    power_loss,     ///< the device is off, and in boot state afterwards
    stuck_encoder,  ///< the count of the leg keeps its value at the start
    stuck_button,   ///< the button is reported as pressed
  } kind = Kind::drop;
  enum class Direction { both, to_device, to_host } direction = Direction::both;
  /// Probability per write (latency), per byte (drop, duplicate, corrupt) or of the whole fault
  /// (other kinds).
  double probability = 1.0;
  double start = 0.0;                                    ///< [s]
  double end = std::numeric_limits<double>::infinity();  ///< [s]
  double latency = 0.0;                                  ///< Kind::latency: minimum delay [s]
  double jitter = 0.0;  ///< largest additional delay, uniformly distributed [s]
  int run = 1;          ///< drop, duplicate, corrupt: number of consecutive bytes affected
  int leg = 1;          ///< stuck encoder: 1, 2 or 3
  Buttons buttons{};    ///< stuck button: affected buttons
};

struct FaultScript {
  std::uint64_t seed = 1;
  std::vector<LinkFault> faults{};
};

struct FaultCounts {
  std::int64_t bytes = 0;  ///< number of bytes sent into the channel
  std::int64_t delayed_writes = 0;
  std::int64_t dropped = 0;
  std::int64_t duplicated = 0;
  std::int64_t corrupted = 0;
  std::int64_t unplugged = 0;   ///< bytes lost while unplugged
  std::int64_t overflowed = 0;  ///< bytes lost because too many were in transit
  bool operator==(const FaultCounts&) const = default;
};

/// One direction of a faulty link. It does not allocate after construction.
class FaultChannel {
 public:
  /// `direction` is to_device or to_host and selects the faults and the random sequence.
  FaultChannel(const FaultScript& script, LinkFault::Direction direction);

  void send(std::span<const std::uint8_t> bytes, double now_s) noexcept;
  /// Reads the bytes that have arrived until `now_s` [s], as many as fit; returns their number.
  std::size_t receive(std::span<std::uint8_t> into, double now_s) noexcept;
  /// Returns the arrival time of the next byte [s], or nothing if no byte is in transit.
  [[nodiscard]] std::optional<double> next_arrival() const noexcept;
  [[nodiscard]] const FaultCounts& counts() const noexcept { return counts_; }

 private:
  struct Travelling {
    std::uint8_t byte = 0;
    double arrival = 0.0;
  };
  double delay(double now_s) noexcept;
  bool hit(LinkFault::Kind kind, double now_s, Seeded& random) noexcept;
  void put(std::uint8_t byte, double arrival) noexcept;

  std::vector<LinkFault> faults_;
  std::vector<int> runs_;  ///< remaining bytes of the present run of each fault
  Seeded for_writes_;
  Seeded for_bytes_;
  Queue<Travelling, 8192> under_way_{};
  FaultCounts counts_{};
};

/// Faults of the device itself. The active windows of the script are drawn at construction.
class DeviceFaults {
 public:
  explicit DeviceFaults(const FaultScript& script);
  [[nodiscard]] bool powered(double now_s) const noexcept;
  /// Returns true if an encoder starts to stick now; then hold() must be called with its count.
  [[nodiscard]] bool begins_to_stick(double now_s) const noexcept;
  void hold(const DevicePacket& present, double now_s) noexcept;
  /// Overwrites the stuck counts and buttons at this time in `packet`.
  void apply(DevicePacket& packet, double now_s) const noexcept;

 private:
  struct Stuck {
    LinkFault fault{};
    std::optional<std::int16_t> count{};
  };
  std::vector<LinkFault> outages_{};
  std::vector<Stuck> stuck_{};
};

}  // namespace palpate::device::falcon
