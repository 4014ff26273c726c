// SPDX-License-Identifier: MIT

#include "device/falcon/grip_thread.hpp"

#include <atomic>
#include <unistd.h>
#include <vector>

#include "device/real_time.hpp"
#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate::device;
using namespace palpate::device::falcon;

/// Device that answers every request at once with what the test sets. It is in its run phase.
class Answering final : public ByteLink {
 public:
  [[nodiscard]] double now() const noexcept override { return monotonic_now(); }
  bool wait_until(double deadline_s) noexcept override {
    if (waiting_.empty()) { monotonic_clock().sleep_until(deadline_s); }
    return !waiting_.empty();
  }
  std::size_t read(std::span<std::uint8_t> into) noexcept override {
    const std::size_t count = std::min(into.size(), waiting_.size());
    std::copy_n(waiting_.begin(), count, into.begin());
    waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count));
    return count;
  }
  bool write(std::span<const std::uint8_t> bytes) noexcept override {
    for (const std::uint8_t byte : bytes) {
      if (const std::optional<HostPacket> request = reader_.take(byte)) { answer(*request); }
    }
    return true;
  }

  std::atomic<bool> homed{false};
  std::atomic<bool> silent{false};
  std::atomic<int> counts{-100};  ///< of every leg
  std::atomic<int> spike{0};      ///< replies still to come whose counts are changed
  std::atomic<int> largest{0};    ///< largest word of a request
  std::atomic<int> last{0};       ///< largest word of the last request
  std::atomic<long> requests{0};

 private:
  void answer(const HostPacket& request) {
    int most = 0;
    for (const std::int16_t word : request.words) { most = std::max(most, std::abs(int{word})); }
    last = most;
    if (most > largest) { largest = most; }
    ++requests;
    if (silent) { return; }
    DevicePacket reply;
    const bool changed = spike > 0;
    if (changed) { --spike; }
    reply.counts.fill(static_cast<std::int16_t>(counts + (changed ? 512 : 0)));
    reply.homed.fill(homed);
    for (const std::uint8_t byte : encode(reply)) { waiting_.push_back(byte); }
  }

  PacketReader<HostPacket> reader_{};
  std::vector<std::uint8_t> waiting_{};
};

/// Orders `order` until `holds()`, as a loop would. Returns false after 20 s.
template <class Holds> bool order_until(GripThread& grip, ForceOrder& order, Holds holds) {
  for (int n = 0; n < 20000; ++n) {
    ++order.count;
    grip.order(order);
    if (holds()) { return true; }
    ::usleep(1000);
  }
  return false;
}

TEST("a device that is not homed gets no torque; then the force rises, up to the limit") {
  Answering device;
  GripThread grip(device, {.most_force = 2.0, .ramp = 0.2});
  ForceOrder order{.push = 100.0};
  CHECK(order_until(grip, order, [&] { return grip.reading().state == GripState::homing; }));
  const long before = device.requests;
  CHECK(order_until(grip, order, [&] { return device.requests > before + 50; }));
  CHECK(device.largest == 0);
  device.homed = true;
  CHECK(order_until(grip, order, [&] { return grip.reading().state == GripState::ramp; }));
  CHECK(order_until(grip, order, [&] { return grip.reading().state == GripState::ready; }));
  CHECK(order_until(grip, order, [&] { return device.last > 0; }));
  grip.stop();
  // 2 N along z at this pose: tau = J^T F has no entry above 0.04 m x 2 N, and 6616.3 words are a
  // newton metre (device/README.md).
  CHECK(device.largest <= 6616.3 * 0.04 * 2.0);
  CHECK(grip.counts().limited > 0);
  CHECK(device.last == 0);  // the farewell
}

TEST("torque ends with an emergency stop, with a loop that falls silent, and with the homing") {
  Answering device;
  device.homed = true;
  GripThread grip(device, {.ramp = 0.05});
  ForceOrder order{.push = 2.0};
  const auto pushes = [&] { return device.last > 0; };
  const auto rests = [&] { return device.last == 0; };
  CHECK(order_until(grip, order, pushes));
  order.stopped = true;
  CHECK(order_until(grip, order, [&] { return grip.reading().state == GripState::stopped; }));
  CHECK(order_until(grip, order, rests));
  order.stopped = false;
  CHECK(order_until(grip, order, pushes));
  for (int n = 0; n < 20000 && device.last > 0; ++n) { ::usleep(1000); }  // no new orders
  CHECK(device.last == 0);
  CHECK(order_until(grip, order, pushes));
  device.homed = false;
  CHECK(order_until(grip, order, [&] { return grip.reading().state == GripState::homing; }));
  CHECK(order_until(grip, order, rests));
}

TEST("without replies the reading is not valid, and with replies the force rises again") {
  Answering device;
  device.homed = true;
  GripThread grip(device, {.ramp = 0.05});
  ForceOrder order{.push = 2.0};
  CHECK(order_until(grip, order, [&] { return grip.reading().state == GripState::ready; }));
  device.silent = true;
  CHECK(order_until(grip, order, [&] { return grip.reading().state == GripState::silent; }));
  CHECK(!grip.reading().valid());
  device.silent = false;
  CHECK(order_until(grip, order, [&] { return grip.reading().state == GripState::ready; }));
}

TEST("one reply with changed counts moves nothing; a grip that stays there is believed") {
  Answering device;
  device.homed = true;
  GripThread grip(device, {.ramp = 0.05});
  ForceOrder order{};
  CHECK(order_until(grip, order, [&] { return grip.reading().state == GripState::ready; }));
  const double place = grip.reading().place;
  device.spike = 1;
  double furthest = 0.0;
  CHECK(order_until(grip, order, [&] {
    furthest = std::max(furthest, std::abs(grip.reading().place - place));
    return device.spike == 0;
  }));
  const long after = device.requests;
  CHECK(order_until(grip, order, [&] {
    furthest = std::max(furthest, std::abs(grip.reading().place - place));
    return device.requests > after + 20;
  }));
  CHECK(furthest <= 1e-12);  // two forward solutions, each within 5e-13 m (device/README.md)
  device.counts = 300;
  CHECK(order_until(grip, order, [&] { return std::abs(grip.reading().place - place) > 1e-3; }));
  grip.stop();
  CHECK(grip.counts().implausible >= 1);
}

}  // namespace PALPATE_FILE
