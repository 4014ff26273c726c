// SPDX-License-Identifier: MIT

#include "device/byte_link.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <system_error>
#include <termios.h>
#include <time.h>
#include <unistd.h>
#include <utility>

namespace palpate::device {
namespace {

constexpr int write_patience_ms = 50;
constexpr std::size_t most_at_once = 512;  // a pipe that polls writable takes so much whole

/// struct termios2 of the kernel, whose header cannot be included beside <termios.h>. It has the
/// baud rate as a number, also one without a name such as the 1456312 of a Falcon.
struct KernelTermios {
  std::array<tcflag_t, 4> flags;
  cc_t line;
  std::array<cc_t, 19> characters;
  unsigned input_speed;
  unsigned output_speed;
};
constexpr unsigned long get_termios2 = _IOR('T', 0x2A, KernelTermios);
constexpr unsigned long set_termios2 = _IOW('T', 0x2B, KernelTermios);

[[noreturn]] void fail(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

void make_raw(int terminal, const std::string& path) {
  termios settings{};
  if (tcgetattr(terminal, &settings) != 0) { fail(path); }
  cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  if (tcsetattr(terminal, TCSANOW, &settings) != 0) { fail(path); }
}

Descriptor open_terminal(const std::string& path) {
  Descriptor terminal(::open(path.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  if (terminal.number() < 0) { fail(path); }
  make_raw(terminal.number(), path);
  return terminal;
}

Descriptor open_master() {
  Descriptor master(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK));
  const bool made =
      master.number() >= 0 && ::grantpt(master.number()) == 0 && ::unlockpt(master.number()) == 0;
  if (!made) { fail("a pseudo-terminal"); }
  return master;
}

std::string path_of_slave(int master) {
  std::array<char, 128> path{};
  if (::ptsname_r(master, path.data(), path.size()) != 0) { fail("a pseudo-terminal"); }
  return path.data();
}

}  // namespace

Descriptor::Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  std::swap(number_, other.number_);
  return *this;
}

Descriptor::~Descriptor() {
  if (number_ >= 0) { ::close(number_); }
}

double DescriptorLink::now() const noexcept {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
}

std::size_t DescriptorLink::read(std::span<std::uint8_t> into) noexcept {
  pollfd waiting{.fd = in_, .events = POLLIN, .revents = 0};
  if (into.empty() || ::poll(&waiting, 1, 0) <= 0) { return 0; }
  const ssize_t count = ::read(in_, into.data(), into.size());
  if (count > 0) { return static_cast<std::size_t>(count); }
  ended_ = count == 0 || (errno != EINTR && errno != EAGAIN);
  return 0;
}

bool DescriptorLink::wait_until(double deadline_s) noexcept {
  pollfd waiting{.fd = in_, .events = POLLIN, .revents = 0};
  const double seconds = std::clamp(deadline_s - now(), 0.0, 3600.0);
  const double whole = std::floor(seconds);
  const timespec timeout{.tv_sec = static_cast<time_t>(whole),
                         .tv_nsec = static_cast<long>((seconds - whole) * 1e9)};
  return ::ppoll(&waiting, 1, &timeout, nullptr) > 0;
}

bool DescriptorLink::write(std::span<const std::uint8_t> bytes) noexcept {
  while (!bytes.empty()) {
    pollfd room{.fd = out_, .events = POLLOUT, .revents = 0};
    const int ready = ::poll(&room, 1, full_ ? 0 : write_patience_ms);
    if (ready < 0 && errno == EINTR) { continue; }
    full_ = ready == 0;
    if (ready <= 0) { return false; }
    const ssize_t count = ::write(out_, bytes.data(), std::min(bytes.size(), most_at_once));
    if (count < 0 && errno == EINTR) { continue; }
    if (count <= 0) { return false; }
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return true;
}

PtyLink::PtyLink()
    : DescriptorLink(open_master()), path_(path_of_slave(in())), slave_(open_terminal(path_)) {}

std::size_t PtyLink::unread_bytes() const noexcept {
  int count = 0;
  return ::ioctl(slave_.number(), FIONREAD, &count) == 0 ? static_cast<std::size_t>(count) : 0;
}

unsigned PtyLink::baud() const noexcept {
  KernelTermios settings{};
  return ::ioctl(slave_.number(), get_termios2, &settings) == 0 ? settings.output_speed : 0;
}

void TerminalLink::set_baud(unsigned baud) noexcept {
  constexpr tcflag_t any_number = 0010000;  // BOTHER
  constexpr tcflag_t speed_bits = 0010017;  // CBAUD
  KernelTermios settings{};
  if (::ioctl(in(), get_termios2, &settings) != 0) { return; }
  settings.flags[2] = (settings.flags[2] & ~speed_bits) | any_number;
  settings.input_speed = settings.output_speed = baud;
  (void)::ioctl(in(), set_termios2, &settings);
}

void TerminalLink::set_dtr(bool on) noexcept {
  const int rts = TIOCM_RTS;
  const int dtr = TIOCM_DTR;
  (void)::ioctl(in(), TIOCMBIC, &rts);
  (void)::ioctl(in(), on ? TIOCMBIS : TIOCMBIC, &dtr);
}

TerminalLink::TerminalLink(const std::string& path) : DescriptorLink(open_terminal(path)) {}

}  // namespace palpate::device

namespace palpate::device::falcon {

void MemoryLink::serve() noexcept {
  if (served_ == nullptr || serving_) { return; }
  serving_ = true;
  served_->serve(device_);
  serving_ = false;
}

void MemoryLink::run_until(double time_s) noexcept {
  serve();
  while (now_ < time_s) {
    now_ = std::min(now_ + step_, time_s);
    serve();
  }
}

std::size_t MemoryLink::End::read(std::span<std::uint8_t> into) noexcept {
  return in_.pop(into.data(), into.size());
}

bool MemoryLink::End::wait_until(double deadline_s) noexcept {
  cable_.serve();
  while (in_.read_available() == 0 && cable_.now_ < deadline_s) {
    cable_.run_until(std::min(cable_.now_ + cable_.step_, deadline_s));
  }
  return in_.read_available() > 0;
}

bool MemoryLink::End::write(std::span<const std::uint8_t> bytes) noexcept {
  return out_.push(bytes.data(), bytes.size()) == bytes.size();
}

}  // namespace palpate::device::falcon
