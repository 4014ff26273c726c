// SPDX-License-Identifier: MIT
#pragma once
/// Streams of the operating system, in wall-clock time. What is made here is closed here.

#include <chrono>
#include <string>

#include "device/byte_link.hpp"

namespace palpate::device {

/// An open file descriptor, closed with its owner.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) noexcept : number_(number) {}
  Descriptor(Descriptor&& other) noexcept;
  Descriptor& operator=(Descriptor&& other) noexcept;
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor();
  [[nodiscard]] int number() const noexcept { return number_; }

 private:
  int number_;
};

/// Reads from one descriptor and writes to another or the same, neither of which it owns. What the
/// other end does not take within 50 ms is lost, as on a serial line.
class DescriptorLink : public ByteLink {
 public:
  DescriptorLink(int in, int out) noexcept : in_(in), out_(out) {}
  [[nodiscard]] double now() const noexcept override;
  std::size_t read(std::span<std::uint8_t> into) noexcept override;
  bool wait_until(double deadline_s) noexcept override;
  bool write(std::span<const std::uint8_t> bytes) noexcept override;
  [[nodiscard]] bool ended() const noexcept override { return ended_; }

 private:
  int in_;
  int out_;
  bool ended_ = false;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// The device's end of a new pseudo-terminal, raw and 8-bit clean. A client that closes its end
/// leaves the terminal open for the next one. Throws std::system_error.
class PtyLink final : public DescriptorLink {
 public:
  PtyLink();
  [[nodiscard]] const std::string& path() const noexcept { return path_; }  ///< of the client's end
  /// Written here and not yet read by any client.
  [[nodiscard]] std::size_t unread_bytes() const noexcept;

 private:
  struct Ends {
    Descriptor master;
    Descriptor slave;  ///< held open, so that reading survives a client's leaving
    std::string path;
  };
  explicit PtyLink(Ends ends) noexcept;
  static Ends open_ends();

  Descriptor master_;
  Descriptor slave_;
  std::string path_;
};

/// The host's end: opens a serial line or pseudo-terminal, raw and 8-bit clean. Throws
/// std::system_error that names the path.
class TerminalLink final : public DescriptorLink {
 public:
  explicit TerminalLink(const std::string& path);

 private:
  explicit TerminalLink(Descriptor terminal) noexcept;
  Descriptor terminal_;
};

}  // namespace palpate::device
