// SPDX-License-Identifier: MIT
#include <csignal>
#include <cstdio>
#include <system_error>
#include <unistd.h>

#include "device/descriptor_link.hpp"
#include "device/falcon/emulator.hpp"
#include "device/falcon/plant_body.hpp"
#include "model/dynamics/scene_check.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/falcon_log.hpp"
#include "reports/cli/falcon_script.hpp"
#include "reports/cli/interrupt.hpp"
#include "reports/cli/loaded_scene.hpp"

namespace palpate::cli {
namespace {

using namespace device;
using namespace device::falcon;

/// Until the input ends or somebody interrupts; what is on its way when the input ends is
/// delivered.
void serve(ByteLink& link, Emulator& emulator, FalconLog& log) {
  while (!interrupted && (!link.ended() || emulator.busy())) {
    (void)link.wait_until(emulator.next_call(link.now()));
    emulator.serve(link);
    log.flush_if_many();
  }
}

void tell_faults(const char* direction, const FaultCounts& counts) {
  std::fprintf(stderr,
               "%s: %lld bytes; dropped %lld, doubled %lld, corrupted %lld, unplugged %lld, "
               "overflowed %lld; writes delayed %lld\n",
               direction, static_cast<long long>(counts.bytes),
               static_cast<long long>(counts.dropped), static_cast<long long>(counts.duplicated),
               static_cast<long long>(counts.corrupted), static_cast<long long>(counts.unplugged),
               static_cast<long long>(counts.overflowed),
               static_cast<long long>(counts.delayed_writes));
}

void tell(const Emulator& emulator, const FalconLog& log) {
  const Firmware& firmware = emulator.firmware();
  const ReaderCounts& reader = firmware.reader_counts();
  std::fprintf(stderr, "%s: %lld requests, %lld replies; bad frames %lld, bytes skipped %lld\n",
               name_of(firmware.state()), static_cast<long long>(reader.frames),
               static_cast<long long>(firmware.replies()),
               static_cast<long long>(reader.bad_frames),
               static_cast<long long>(reader.skipped_bytes));
  for (std::size_t n = 0; n < firmware_event_count; ++n) {
    const auto event = static_cast<FirmwareEvent>(n);
    if (firmware.count(event) == 0) { continue; }
    std::fprintf(stderr, "%s: %lld\n", name_of(event),
                 static_cast<long long>(firmware.count(event)));
  }
  tell_faults("to device", emulator.faults_to_device());
  tell_faults("to host", emulator.faults_to_host());
  if (log.left_out() + emulator.lost_replies() > 0) {
    std::fprintf(stderr, "rows left out of the log: %lld; writes that nobody took: %lld\n",
                 static_cast<long long>(log.left_out()),
                 static_cast<long long>(emulator.lost_replies()));
  }
}

/// A script may move the grip itself; else a hand holds the mechanism, and homes it when asked to.
std::unique_ptr<Body> make_body(const FalconScript& script) {
  if (script.moves_grip) { return std::make_unique<ScriptedGrip>(script.grip); }
  const PlantBodyOptions options{.homed = false, .homes = true, .seed = script.faults.seed};
  device::Hand hand;
  hand.intent = device::Intent({.start = options.start});
  return std::make_unique<PlantBody>(options, hand);
}

std::unique_ptr<ByteLink> make_link(bool pty) {
  if (!pty) { return std::make_unique<DescriptorLink>(STDIN_FILENO, STDOUT_FILENO); }
  auto link = std::make_unique<PtyLink>();
  std::printf("%s\n", link->path().c_str());
  std::fflush(stdout);
  return link;
}

}  // namespace

int falcon(const FalconOptions& options) {
  catch_interrupts();
  const int modes = int(options.pty) + int(options.stdio) + int(!options.solve.empty());
  if (modes != 1) {
    throw InputError("falcon needs a mode; exactly one of --pty, --stdio and --solve");
  }
  if (!options.solve.empty()) { return falcon_solve(options); }
  const FalconScript script = read_falcon_script(options.script, options.overrides);
  const std::filesystem::path folder = make_folder(options.folder("falcon"));
  std::signal(SIGPIPE, SIG_IGN);  // a reader that left is a write that fails, not an end
  const std::unique_ptr<Body> body = make_body(script);
  Emulator emulator(*body, script.firmware, script.faults);
  FalconLog log(folder / "log.csv", emulator.firmware());
  emulator.observe(&log);
  try {
    const std::unique_ptr<ByteLink> link = make_link(options.pty);
    serve(*link, emulator, log);
  } catch (const std::system_error& problem) {
    std::fprintf(stderr, "palpate: %s; this machine must offer it\n", problem.what());
    return machine_cannot;
  }
  log.finish();
  if (!options.quiet) { tell(emulator, log); }
  return interrupted ? interrupted_code : done;
}

}  // namespace palpate::cli
