// SPDX-License-Identifier: MIT
#pragma once
/// Two ends in one process, in virtual time: for lock step, where a harness owns the clock.

#include <cstdint>
#include <span>

#include "device/byte_link.hpp"
#include "device/falcon/ring.hpp"

namespace palpate::device::falcon {

/// What does its work while somebody waits for it.
class Served {
 public:
  virtual ~Served() = default;
  virtual void serve(ByteLink& link) noexcept = 0;
};

class MemoryLink {
 public:
  /// Waiting moves the clock by `step_s` at a time, and serves the device after each.
  explicit MemoryLink(double step_s = 50e-6) noexcept : step_(step_s) {}
  MemoryLink(const MemoryLink&) = delete;
  MemoryLink& operator=(const MemoryLink&) = delete;

  [[nodiscard]] ByteLink& host() noexcept { return host_; }
  [[nodiscard]] ByteLink& device() noexcept { return device_; }
  /// Who answers at the device's end while the host waits.
  void attach(Served& device) noexcept { served_ = &device; }

  [[nodiscard]] double now() const noexcept { return now_; }
  /// Moves the clock there, serving the device on the way.
  void run_until(double time_s) noexcept;

 private:
  using Bytes = Ring<std::uint8_t, 4096>;

  class End final : public ByteLink {
   public:
    End(MemoryLink& cable, Bytes& in, Bytes& out) noexcept : cable_(cable), in_(in), out_(out) {}
    [[nodiscard]] double now() const noexcept override { return cable_.now_; }
    std::size_t read(std::span<std::uint8_t> into) noexcept override;
    bool wait_until(double deadline_s) noexcept override;
    bool write(std::span<const std::uint8_t> bytes) noexcept override;

   private:
    MemoryLink& cable_;
    Bytes& in_;
    Bytes& out_;
  };

  void serve() noexcept;

  double step_;
  double now_ = 0.0;
  bool serving_ = false;  ///< the device itself waits on its end: it is not served again
  Served* served_ = nullptr;
  Bytes to_device_{};
  Bytes to_host_{};
  End host_{*this, to_host_, to_device_};
  End device_{*this, to_device_, to_host_};
};

}  // namespace palpate::device::falcon
