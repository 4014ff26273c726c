// SPDX-License-Identifier: MIT
#pragma once
/// What may go wrong between host and device, scripted by time and seeded by chance. The same seed
/// and the same bytes meet the same faults on every machine.

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include "device/bounded_queue.hpp"
#include "device/falcon/packet.hpp"

namespace palpate::device::falcon {

/// One kind of trouble during [start, end).
struct LinkFault {
  enum class Kind {
    latency,        ///< bytes arrive late, those of one write together, never out of order
    drop,           ///< a byte is lost
    duplicate,      ///< a byte comes twice
    corrupt,        ///< a byte becomes another byte
    unplug,         ///< every byte is lost; the device keeps its power
    power_loss,     ///< the device is off, and at boot afterwards
    stuck_encoder,  ///< the leg's count stays as it was at the start
    stuck_button,   ///< the button reads as pressed
  } kind = Kind::drop;
  enum class Direction { both, to_device, to_host } direction = Direction::both;
  /// Of each write that it is delayed, of each byte that it is hit; of the last four kinds, that
  /// the fault happens at all.
  double probability = 1.0;
  double start = 0.0;                                    ///< [s]
  double end = std::numeric_limits<double>::infinity();  ///< [s]
  double latency = 0.0;                                  ///< Kind::latency: least delay [s]
  double jitter = 0.0;                                   ///< added at most, evenly spread [s]
  int run = 1;        ///< drop, duplicate, corrupt: bytes in a row that one hit takes
  int leg = 1;        ///< stuck encoder: 1, 2 or 3
  Buttons buttons{};  ///< stuck button: those that stick
};

struct FaultScript {
  std::uint64_t seed = 1;
  std::vector<LinkFault> faults{};
};

struct FaultCounts {
  std::int64_t bytes = 0;  ///< that were sent into the channel
  std::int64_t delayed_writes = 0;
  std::int64_t dropped = 0;
  std::int64_t duplicated = 0;
  std::int64_t corrupted = 0;
  std::int64_t unplugged = 0;   ///< bytes lost while unplugged
  std::int64_t overflowed = 0;  ///< bytes lost because too many were under way
  bool operator==(const FaultCounts&) const = default;
};

/// Evenly spread in [0, 1), 53 bits, the same everywhere: std::uniform_real_distribution is not.
double unit_number(std::mt19937_64& generator) noexcept;

/// One direction of a faulty link. After construction it allocates nothing.
class FaultChannel {
 public:
  /// `direction` is to_device or to_host: it picks the faults, and random numbers of its own.
  FaultChannel(const FaultScript& script, LinkFault::Direction direction);

  void send(std::span<const std::uint8_t> bytes, double now_s) noexcept;
  /// What has arrived by now, as much as fits.
  std::size_t receive(std::span<std::uint8_t> into, double now_s) noexcept;
  /// When the next byte arrives [s]; nothing when none is under way.
  [[nodiscard]] std::optional<double> next_arrival() const noexcept;
  [[nodiscard]] const FaultCounts& counts() const noexcept { return counts_; }

 private:
  struct Travelling {
    std::uint8_t byte = 0;
    double arrival = 0.0;
  };
  double delay(double now_s) noexcept;
  bool hit(LinkFault::Kind kind, double now_s, std::mt19937_64& generator) noexcept;
  void put(std::uint8_t byte, double arrival) noexcept;

  std::vector<LinkFault> faults_;
  std::vector<int> runs_;  ///< bytes that each fault's present run still takes
  std::mt19937_64 for_writes_;
  std::mt19937_64 for_bytes_;
  Ring<Travelling, 8192> under_way_{};
  FaultCounts counts_{};
};

/// Faults of the device itself. Which windows of the script happen is drawn when it is made.
class DeviceFaults {
 public:
  explicit DeviceFaults(const FaultScript& script);
  [[nodiscard]] bool powered(double now_s) const noexcept;
  /// Whether an encoder sticks from now on, whose count hold() must be told.
  [[nodiscard]] bool begins_to_stick(double now_s) const noexcept;
  void hold(const DevicePacket& present, double now_s) noexcept;
  /// Puts the stuck counts and buttons of this time into what the device would say.
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
