// SPDX-License-Identifier: MIT
// Client and emulator at the two ends of a pseudo-terminal, in wall-clock time.

#include "device/byte_link.hpp"

#include <atomic>
#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <thread>
#include <unistd.h>

#include "device/falcon/driver.hpp"
#include "tests/check.hpp"
#include "tests/device/falcon/samples.hpp"

namespace PALPATE_FILE {

using namespace palpate::device;
using namespace palpate::device::falcon;

// The machine may be busy: a deadline here only decides how long a failure takes.
constexpr DriverOptions patient{.reply_deadline = 5.0, .hail_patience = 5.0};

/// Serves on its own thread until it is destroyed.
class Service {
 public:
  Service() : emulator_(body_), thread_([this] { run(); }) {}
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;
  ~Service() { stop(); }
  void stop() {
    stop_ = true;
    if (thread_.joinable()) { thread_.join(); }
  }
  [[nodiscard]] const std::string& path() const { return link_.path(); }
  [[nodiscard]] const Emulator& emulator() const { return emulator_; }  ///< after stop()
  [[nodiscard]] double now() const { return link_.now(); }
  [[nodiscard]] std::int64_t replies() const { return replies_.load(); }
  /// Returns true if all motor words were zero after the last call of replies().
  [[nodiscard]] bool motors_off() const { return motors_off_.load(); }

 private:
  void run() {
    while (!stop_) {
      (void)link_.wait_until(emulator_.next_call(link_.now()));
      emulator_.serve(link_);
      const Firmware& firmware = emulator_.firmware();
      motors_off_ = firmware.words(link_.now()) == std::array<std::int16_t, 3>{};
      replies_ = firmware.replies();
    }
  }
  sample::SummingBody body_{};
  PtyLink link_{};
  Emulator emulator_;
  std::atomic<bool> motors_off_{true};
  std::atomic<std::int64_t> replies_{0};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

TEST("a driver loads an image of every byte value over a pty, and every request gets its reply") {
  std::vector<std::uint8_t> image(8492);
  for (std::size_t n = 0; n < image.size(); ++n) { image[n] = static_cast<std::uint8_t>(n * 7); }
  Service service;
  TerminalLink link(service.path());
  Driver driver(link, patient);
  CHECK(driver.open(image) == OpenResult::loaded);
  for (int n = 0; n < 2000; ++n) {
    CHECK(driver.exchange({.words = {static_cast<std::int16_t>(n), -1, 0x0A0D}}).has_value());
  }
  CHECK(driver.counts().lost == 0);
  service.stop();
  CHECK(service.emulator().firmware().replies() == driver.counts().requests);
}

TEST("a client that never reads delays the first lost write alone") {
  std::array<int, 2> pipe{};
  CHECK(::pipe(pipe.data()) == 0);
  DescriptorLink link(pipe[0], pipe[1]);
  const std::vector<std::uint8_t> bytes(512);
  while (link.write(bytes)) {}  // until the pipe is full
  // 50 ms each would be 5000 s, more than the TIMEOUT of CTest.
  for (int n = 0; n < 100'000; ++n) { CHECK(!link.write(bytes)); }
  std::vector<std::uint8_t> taken(1 << 17);
  CHECK(link.read(taken) > 0);
  CHECK(link.write(bytes));
  ::close(pipe[0]);
  ::close(pipe[1]);
}

TEST("a change of baud rate after the upload ends it, so that the first packet is not echoed") {
  sample::SummingBody body;
  PtyLink device;
  Emulator emulator(body);
  const int client = ::open(device.path().c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  const auto baud = [client](speed_t speed) {
    termios settings{};
    (void)::tcgetattr(client, &settings);
    (void)::cfsetspeed(&settings, speed);
    (void)::tcsetattr(client, TCSANOW, &settings);
  };
  const auto exchange = [&](const std::vector<std::uint8_t>& bytes, std::size_t expected) {
    CHECK(::write(client, bytes.data(), bytes.size()) == std::ssize(bytes));
    std::vector<std::uint8_t> answer;
    while (answer.size() < expected) {
      emulator.serve(device);
      std::array<std::uint8_t, 64> part{};
      pollfd readable{.fd = client, .events = POLLIN, .revents = 0};
      if (::poll(&readable, 1, 1) <= 0) { continue; }
      const ssize_t count = ::read(client, part.data(), part.size());
      answer.insert(answer.end(), part.begin(), part.begin() + count);
    }
    return answer;
  };
  baud(B9600);
  CHECK(exchange({0x0A, 0x43, 0x0D}, 4) == (std::vector<std::uint8_t>{0x0A, 0x44, 0x2C, 0x0D}));
  baud(B115200);  // before the upload: no meaning
  CHECK(exchange({0x41, 1, 2, 3}, 4) == (std::vector<std::uint8_t>{0x41, 1, 2, 3}));
  baud(B460800);
  const PacketBytes packet = encode(HostPacket{});
  const std::vector<std::uint8_t> answer = exchange({packet.begin(), packet.end()}, packet_bytes);
  CHECK(answer.size() == packet_bytes);  // the reply alone
  CHECK(emulator.firmware().echoed_bytes() == 4);
  CHECK(emulator.firmware().count(FirmwareEvent::early_run) == 0);
  ::close(client);
}

TEST("after a client that leaves within a packet the next is served on the same path") {
  Service service;
  for (int client = 0; client < 3; ++client) {
    TerminalLink link(service.path());
    Driver driver(link, patient);
    CHECK(driver.probe());
    CHECK(driver.exchange({.words = {1, 2, 3}}).has_value());
    const PacketBytes half = encode(HostPacket{});
    (void)link.write({half.data(), 7});  // leaves in the middle of a packet
  }
  while (service.replies() < 6 || !service.motors_off()) { std::this_thread::yield(); }
  service.stop();
  const Firmware& firmware = service.emulator().firmware();
  CHECK((firmware.words(service.now()) == std::array<std::int16_t, 3>{}));
  CHECK(firmware.replies() == 6);
}

TEST("the terminal is raw even for a client that sets nothing") {
  PtyLink device;
  const int client = ::open(device.path().c_str(), O_RDWR | O_NOCTTY);
  CHECK(client >= 0);
  termios settings{};
  CHECK(tcgetattr(client, &settings) == 0);
  CHECK((settings.c_lflag & (ICANON | ECHO | ISIG)) == 0);
  std::array<std::uint8_t, 256> all{};
  for (std::size_t n = 0; n < all.size(); ++n) { all[n] = static_cast<std::uint8_t>(n); }
  CHECK(::write(client, all.data(), all.size()) == 256);
  std::vector<std::uint8_t> received;
  std::array<std::uint8_t, 256> buffer{};
  while (received.size() < 256 && device.wait_until(device.now() + 5.0)) {
    const std::size_t count = device.read(buffer);
    received.insert(received.end(), buffer.begin(), buffer.begin() + static_cast<long>(count));
  }
  CHECK(std::equal(received.begin(), received.end(), all.begin(), all.end()));
  ::close(client);
  CHECK(device.read(buffer) == 0);
  CHECK(!device.ended());
}

TEST("a reader that takes nothing costs bytes, not the service") {
  PtyLink device;
  const std::vector<std::uint8_t> many(1U << 20U, 0x41);
  CHECK(!device.write(many));
}

TEST("a pipe whose writer left has ended") {
  std::array<int, 2> ends{};
  CHECK(::pipe(ends.data()) == 0);
  const Descriptor reader(ends[0]);
  DescriptorLink link(reader.number(), ends[1]);
  CHECK(link.write(std::array<std::uint8_t, 2>{1, 2}));
  ::close(ends[1]);
  std::array<std::uint8_t, 8> buffer{};
  CHECK(link.read(buffer) == 2);
  CHECK(!link.ended());
  CHECK(link.read(buffer) == 0);
  CHECK(link.ended());
}

TEST("a path that is not a terminal is refused by name") {
  CHECK_THROWS(TerminalLink("/no/such/terminal"), "/no/such/terminal");
  CHECK_THROWS(TerminalLink("/dev/null"), "/dev/null");
}

}  // namespace PALPATE_FILE
