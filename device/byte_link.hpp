// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace palpate::device {

/// One end of an 8-bit clean stream of bytes, and the clock that its two ends share.
class ByteLink {
 public:
  ByteLink() = default;
  ByteLink(const ByteLink&) = delete;
  ByteLink& operator=(const ByteLink&) = delete;
  virtual ~ByteLink() = default;

  /// Seconds since the link was made; wall clock, or the harness's own time.
  [[nodiscard]] virtual double now() const noexcept = 0;
  /// What has arrived, as much as fits, without waiting; 0: nothing.
  virtual std::size_t read(std::span<std::uint8_t> into) noexcept = 0;
  /// Waits until there is something to read or the time has come [s]; true when there is. May
  /// return early with false, as when a signal came.
  virtual bool wait_until(double deadline_s) noexcept = 0;
  /// All bytes, or false when some were lost: the other end takes none, or is gone.
  virtual bool write(std::span<const std::uint8_t> bytes) noexcept = 0;
  /// Nothing will ever arrive again.
  [[nodiscard]] virtual bool ended() const noexcept { return false; }
};

}  // namespace palpate::device
