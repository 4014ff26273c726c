// SPDX-License-Identifier: MIT

#include <numeric>

#include "device/falcon/emulator.hpp"
#include "tests/check.hpp"
#include "tests/device/falcon/samples.hpp"

namespace PALPATE_FILE {

using namespace palpate::device::falcon;
using Bytes = std::vector<std::uint8_t>;
using sample::Kept;

constexpr DevicePacket present{.counts = {10, -20, 30}, .homed = {true, true, true}};

/// Replies of the firmware to these bytes at this time.
Bytes answer(Firmware& firmware, const Bytes& bytes, double now = 0.0) {
  Kept kept;
  firmware.receive(bytes, now, present, kept);
  return kept.sent;
}

Bytes bytes_of(const PacketBytes& packet) { return {packet.begin(), packet.end()}; }

const Bytes hail{0x0A, 0x43, 0x0D};
const Bytes hail_answer{0x0A, 0x44, 0x2C, 0x0D};
const Bytes reply = bytes_of(encode(present));

constexpr std::array<std::int16_t, 3> off{};

Firmware running(double watchdog = FirmwareOptions{}.watchdog) {
  return Firmware({.watchdog = watchdog, .loaded = true});
}

TEST("the boot loader answers 0A 43 0D with 0A 44 2C 0D, also in pieces and after strays") {
  Firmware firmware;
  CHECK(firmware.state() == FirmwareState::boot);
  CHECK(answer(firmware, {0x00, 0x0A, 0x0A}).empty());
  CHECK(answer(firmware, {0x43}).empty());
  CHECK(answer(firmware, {0x0D}) == hail_answer);
  CHECK(firmware.state() == FirmwareState::ready);
  CHECK(answer(firmware, hail) == hail_answer);  // a host that lost the reply repeats the request
  CHECK(firmware.count(FirmwareEvent::hail) == 2);
}

TEST("after 41 every byte of any image is echoed") {
  Firmware firmware;
  (void)answer(firmware, hail);
  CHECK(answer(firmware, {0x41}) == Bytes{0x41});
  CHECK(firmware.state() == FirmwareState::load);
  Bytes image(8492);  // the length of the image that most drivers load
  std::iota(image.begin(), image.end(), std::uint8_t{0});
  CHECK(answer(firmware, image) == image);
  CHECK(answer(firmware, hail) == hail);  // no exception for what was special before
  CHECK(answer(firmware, {'<', 'A', '<', '>'}) == (Bytes{'<', 'A', '<', '>'}));
  CHECK(firmware.state() == FirmwareState::load);
  CHECK(firmware.echoed_bytes() == 1 + 8492 + 3 + 4);
  CHECK(firmware.count(FirmwareEvent::bad_frame) == 0);
}

TEST("bytes before a hail are not answered but counted as a violation, once a run") {
  Firmware firmware;
  CHECK(answer(firmware, {0x41, 0x55, 0x41}).empty());
  CHECK(firmware.count(FirmwareEvent::stray_bytes) == 1);
  CHECK(firmware.state() == FirmwareState::boot);
}

TEST("the change of baud rate ends the upload") {
  Firmware firmware;
  Kept kept;
  firmware.begin_run(0.0, kept);
  CHECK(firmware.state() == FirmwareState::boot);
  CHECK(firmware.count(FirmwareEvent::early_run) == 1);
  (void)answer(firmware, hail);
  (void)answer(firmware, {0x41, 1, 2, 3});
  firmware.begin_run(0.0, kept);
  CHECK(firmware.state() == FirmwareState::run);
  CHECK(answer(firmware, {1, 2, 3}).empty());
  CHECK(answer(firmware, bytes_of(encode(HostPacket{}))) == reply);
}

TEST("the first well-formed packet starts run from every state and is answered") {
  const Bytes request = bytes_of(encode(HostPacket{.words = {5, 6, 7}}));
  Firmware from_boot;
  CHECK(answer(from_boot, request) == reply);
  CHECK(from_boot.count(FirmwareEvent::skipped_load) == 1);
  Firmware from_ready;
  (void)answer(from_ready, hail);
  CHECK(answer(from_ready, request) == reply);
  CHECK(from_ready.count(FirmwareEvent::skipped_load) == 1);
  Firmware from_load;
  (void)answer(from_load, hail);
  (void)answer(from_load, {0x41, 9, 9});
  Bytes expected(request.begin(), request.end() - 1);  // echoed before it could be known
  expected.insert(expected.end(), reply.begin(), reply.end());
  CHECK(answer(from_load, request) == expected);
  CHECK(from_load.count(FirmwareEvent::skipped_load) == 0);
  for (const Firmware* each : {&from_boot, &from_ready, &from_load}) {
    CHECK(each->state() == FirmwareState::run);
    CHECK(each->words(0.0)[1] == 6);
  }
}

TEST("in run each well-formed request gets one reply and nothing else gets any") {
  Firmware firmware = running();
  Bytes three;
  for (int n = 0; n < 3; ++n) {
    const PacketBytes request = encode(HostPacket{});
    three.insert(three.end(), request.begin(), request.end());
  }
  CHECK(answer(firmware, three).size() == 3 * packet_bytes);
  CHECK(firmware.replies() == 3);
  CHECK(answer(firmware, {}).empty());
  CHECK(answer(firmware, hail).empty());
  CHECK(answer(firmware, {0x41, 0x42, '>', '>'}).empty());
  CHECK(answer(firmware, {'<', 'A', 'Z'}).empty());
  CHECK(firmware.count(FirmwareEvent::bad_frame) == 1);
  CHECK(firmware.count(FirmwareEvent::stray_bytes) == 1);
  CHECK(firmware.replies() == 3);
}

TEST("torque and homing drop when no request came for the watchdog's time") {
  for (const double watchdog : {0.020, 0.1}) {
    Firmware firmware = running(watchdog);
    // Words act as received, beyond the range of the motors too.
    const HostPacket request{
        .words = {26554, -32768, 4097}, .homing = true, .leds = {.blue = true}};
    (void)answer(firmware, bytes_of(encode(request)), 1.0);
    CHECK(firmware.words(1.0) == request.words);
    CHECK(firmware.words(1.0 + 0.999 * watchdog) == request.words);
    CHECK(firmware.homing(1.0 + 0.999 * watchdog));
    CHECK(firmware.words(1.0 + 1.001 * watchdog) == off);
    CHECK(!firmware.homing(1.0 + 1.001 * watchdog));
    CHECK(firmware.leds() == request.leds);
    CHECK(firmware.count(FirmwareEvent::watchdog) == 0);  // no time was set yet
    (void)answer(firmware, {}, 1.0 + 2.0 * watchdog);
    (void)answer(firmware, {}, 1.0 + 3.0 * watchdog);
    CHECK(firmware.count(FirmwareEvent::watchdog) == 1);
    (void)answer(firmware, bytes_of(encode(request)), 2.0);
    CHECK(firmware.words(2.0) == request.words);
  }
}

TEST("without a request there is no torque, and other bytes do not reset the watchdog") {
  Firmware firmware = running();
  CHECK(firmware.words(0.0) == off);
  (void)answer(firmware, bytes_of(encode(HostPacket{.words = {1, 1, 1}})), 0.0);
  for (int n = 1; n <= 30; ++n) { (void)answer(firmware, {'<', 'A', 'x'}, 1e-3 * n); }
  CHECK(firmware.words(0.030) == off);
  Firmware silent = running();
  (void)answer(silent, {}, 100.0);
  CHECK(silent.count(FirmwareEvent::watchdog) == 0);
}

TEST("homing is on exactly while the latest packet asks for it") {
  Firmware firmware = running();
  CHECK(!firmware.homing(0.0));
  for (const bool homing : {true, false, true, true, false}) {
    (void)answer(firmware, bytes_of(encode(HostPacket{.homing = homing})), 0.0);
    CHECK(firmware.homing(0.0) == homing);
  }
}

TEST("a silent upload is abandoned, one that continues is not") {
  Firmware firmware({.load_silence = 0.5});
  (void)answer(firmware, hail, 0.0);
  (void)answer(firmware, {0x41}, 0.4);
  CHECK(answer(firmware, {0x42}, 0.8) == Bytes{0x42});
  CHECK(answer(firmware, {0x42}, 1.4).empty());
  CHECK(firmware.state() == FirmwareState::boot);
  CHECK(firmware.count(FirmwareEvent::load_abandoned) == 1);
  CHECK(answer(firmware, hail, 1.5) == hail_answer);
}

TEST("power loss leads to boot without torque, and forgets half a packet") {
  Firmware firmware = running();
  const Bytes request = bytes_of(encode(HostPacket{.words = {7, 7, 7}}));
  (void)answer(firmware, request, 0.0);
  (void)answer(firmware, {request.begin(), request.begin() + 8}, 0.0);
  Kept kept;
  firmware.lose_power(0.001, kept);
  CHECK(firmware.state() == FirmwareState::boot);
  CHECK(firmware.words(0.001) == off);
  CHECK(answer(firmware, {request.begin() + 8, request.end()}, 0.002).empty());
  CHECK(answer(firmware, hail, 0.003) == hail_answer);
  CHECK(answer(firmware, {}, 0.1).empty());
  CHECK(firmware.count(FirmwareEvent::watchdog) == 0);  // there was no torque left to drop
}

TEST("the sink receives every event and every request, in order") {
  Firmware firmware;
  Kept kept;
  const PacketBytes request = encode(HostPacket{.words = {3, 2, 1}});
  firmware.receive(hail, 0.0, present, kept);
  firmware.receive(std::array<std::uint8_t, 1>{0x41}, 0.0, present, kept);
  firmware.receive(request, 0.0, present, kept);
  CHECK((kept.events ==
         std::vector{FirmwareEvent::hail, FirmwareEvent::load_begun, FirmwareEvent::run_begun}));
  CHECK((kept.requests == std::vector{HostPacket{.words = {3, 2, 1}}}));
}

}  // namespace PALPATE_FILE
