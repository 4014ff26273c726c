// SPDX-License-Identifier: MIT
#pragma once

#include <boost/lockfree/spsc_queue.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

namespace palpate::device {

/// First-in first-out queue of at most `capacity` items, lock-free between one producer and one
/// consumer. It never allocates, and causes no page fault after its construction.
template <class Item, std::size_t capacity>
class Queue : public boost::lockfree::spsc_queue<Item, boost::lockfree::capacity<capacity>> {
 public:
  Queue() {
    while (this->push(Item{})) {}
    this->reset();
  }
};

/// Interface of one end of an 8-bit clean byte stream, with the clock that both ends share.
class ByteLink {
 public:
  ByteLink() = default;
  ByteLink(const ByteLink&) = delete;
  ByteLink& operator=(const ByteLink&) = delete;
  virtual ~ByteLink() = default;

  /// Returns the time since the link was created [s], in wall-clock or virtual time.
  [[nodiscard]] virtual double now() const noexcept = 0;
  /// Reads the bytes that have arrived, as many as fit, without waiting; returns their number.
  virtual std::size_t read(std::span<std::uint8_t> into) noexcept = 0;
  /// Waits until bytes can be read or until the deadline [s]; returns true if bytes can be read. It
  /// can return false early, for example after a signal.
  virtual bool wait_until(double deadline_s) noexcept = 0;
  /// Writes all bytes. Returns false if some were lost, because the other end is full or closed.
  virtual bool write(std::span<const std::uint8_t> bytes) noexcept = 0;
  /// True if no byte can arrive any more.
  [[nodiscard]] virtual bool ended() const noexcept { return false; }
  /// Baud rate that the other end has set; 0 if the link does not carry it.
  [[nodiscard]] virtual unsigned baud() const noexcept { return 0; }
  /// Sets the baud rate of this end; ignored by links that carry none.
  virtual void set_baud(unsigned /*baud*/) noexcept {}
  /// Sets the line DTR and clears RTS; ignored by links without lines.
  virtual void set_dtr(bool /*on*/) noexcept {}
};

/// File descriptor that is closed by its destructor.
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

/// Byte link over two file descriptors in wall-clock time. Bytes that the other end does not accept
/// within 50 ms are lost, as on a serial line; further bytes are lost at once until it accepts
/// some.
class DescriptorLink : public ByteLink {
 public:
  /// Does not own the descriptors.
  DescriptorLink(int in, int out) noexcept : in_(in), out_(out) {}
  /// Reads and writes one descriptor, which it closes.
  explicit DescriptorLink(Descriptor both) noexcept
      : owned_(std::move(both)), in_(owned_.number()), out_(in_) {}
  [[nodiscard]] double now() const noexcept override;
  std::size_t read(std::span<std::uint8_t> into) noexcept override;
  bool wait_until(double deadline_s) noexcept override;
  bool write(std::span<const std::uint8_t> bytes) noexcept override;
  [[nodiscard]] bool ended() const noexcept override { return ended_; }

 protected:
  [[nodiscard]] int in() const noexcept { return in_; }

 private:
  Descriptor owned_{};
  int in_;
  int out_;
  bool ended_ = false;
  bool full_ = false;  ///< the last write waited in vain; the next does not wait
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// Device end of a new pseudo-terminal, raw and 8-bit clean. It stays open when a client closes its
/// end. Throws std::system_error.
class PtyLink final : public DescriptorLink {
 public:
  PtyLink();
  [[nodiscard]] const std::string& path() const noexcept { return path_; }  ///< client's end
  /// Returns the number of bytes that were written here and not yet read by a client.
  [[nodiscard]] std::size_t unread_bytes() const noexcept;
  [[nodiscard]] unsigned baud() const noexcept override;

 private:
  std::string path_;
  Descriptor slave_;  ///< held open, so that reads still work after a client disconnects
};

/// Host end of a serial line or pseudo-terminal, raw and 8-bit clean. Throws std::system_error that
/// names the path.
class TerminalLink final : public DescriptorLink {
 public:
  explicit TerminalLink(const std::string& path);
  void set_baud(unsigned baud) noexcept override;
  void set_dtr(bool on) noexcept override;
};

}  // namespace palpate::device

namespace palpate::device::falcon {

// In-process link in virtual time, for runs in lock step that control the clock.

/// Interface of a device that is served while the host waits.
class Served {
 public:
  virtual ~Served() = default;
  virtual void serve(ByteLink& link) noexcept = 0;
};

class MemoryLink {
 public:
  /// While the host waits, the clock advances by `step_s` [s] at a time and the device is served
  /// after each step.
  explicit MemoryLink(double step_s = 50e-6) noexcept : step_(step_s) {}
  MemoryLink(const MemoryLink&) = delete;
  MemoryLink& operator=(const MemoryLink&) = delete;

  [[nodiscard]] ByteLink& host() noexcept { return host_; }
  [[nodiscard]] ByteLink& device() noexcept { return device_; }
  /// Sets the device that is served while the host waits.
  void attach(Served& device) noexcept { served_ = &device; }

  [[nodiscard]] double now() const noexcept { return now_; }
  /// Advances the clock to `time_s` [s] and serves the device at each step.
  void run_until(double time_s) noexcept;

 private:
  using Bytes = Queue<std::uint8_t, 4096>;

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
  bool serving_ = false;  ///< true while the device waits on its own end, to prevent recursion
  Served* served_ = nullptr;
  Bytes to_device_{};
  Bytes to_host_{};
  End host_{*this, to_host_, to_device_};
  End device_{*this, to_device_, to_host_};
};

}  // namespace palpate::device::falcon
