// SPDX-License-Identifier: MIT

#include "device/pressure_link/transducer.hpp"

#include <array>
#include <cstdio>
#include <iostream>
#include <poll.h>
#include <unistd.h>

#include "model/problem/input_error.hpp"
#include "reports/cli/commands.hpp"
#include "reports/recording_input.hpp"
#include "validation/comparison/link_recording.hpp"

namespace palpate::cli {
namespace {

/// Exactly one of the modes `pty` and `stdio` is given.
struct TransducerCommandOptions : CommonOptions {
  std::filesystem::path recording{};
  bool pty = false;
  bool stdio = false;
  bool fast = false;         ///< if true, --stdio writes at the reader's pace
  bool repeat = false;       ///< restart after the last sample
  bool battery_low = false;  ///< flag of every frame
  double drop = 0.0, duplicate = 0.0, corrupt = 0.0, burst = 0.0;  ///< probability per byte
  int burst_bytes = 20;
  std::uint64_t seed = 1;
};

using device::falcon::FaultScript;
using device::falcon::LinkFault;
using device::pressure_link::Transducer;

constexpr double longest_wait = 0.1;   // [s] until an interrupt is noticed
constexpr double last_patience = 5.0;  // [s] for a client to read the rest of a terminal
constexpr double settling = 0.2;       // [s] for written bytes to reach the client's end

/// Standard output at the pace of its reader. A wait advances the virtual time at once.
class HastyOutput final : public device::ByteLink {
 public:
  [[nodiscard]] double now() const noexcept override { return time_; }
  std::size_t read(std::span<std::uint8_t>) noexcept override { return 0; }
  bool wait_until(double deadline_s) noexcept override {
    time_ = std::max(time_, deadline_s);
    return false;
  }
  bool write(std::span<const std::uint8_t> bytes) noexcept override {
    return std::fwrite(bytes.data(), 1, bytes.size(), stdout) == bytes.size();
  }

 private:
  double time_ = 0.0;
};

FaultScript faults_of(const TransducerCommandOptions& options) {
  using Kind = LinkFault::Kind;
  FaultScript script{.seed = options.seed};
  const auto add = [&](Kind kind, double probability, int run) {
    if (probability > 0.0) {
      script.faults.push_back({.kind = kind, .probability = probability, .run = run});
    }
  };
  add(Kind::drop, options.drop, 1);
  add(Kind::duplicate, options.duplicate, 1);
  add(Kind::corrupt, options.corrupt, 1);
  add(Kind::corrupt, options.burst, options.burst_bytes);
  return script;
}

/// True if the reader of this output has closed it.
bool reader_left(int output) {
  pollfd state{.fd = output, .events = 0, .revents = 0};
  return ::poll(&state, 1, 0) > 0 && (state.revents & (POLLERR | POLLNVAL)) != 0;
}

void serve(device::ByteLink& link, Transducer& transducer, bool stdio) {
  std::array<std::uint8_t, 256> ignored;
  while (!interrupted && !transducer.finished()) {
    (void)link.wait_until(std::min(transducer.next_call(), link.now() + longest_wait));
    while (link.read(ignored) > 0) {}  // the transducer takes no requests
    transducer.serve(link);
    if (!stdio || transducer.lost_writes() == 0) { continue; }
    if (reader_left(STDOUT_FILENO) || std::ferror(stdout) != 0) { return; }
  }
}

void serve_output(Transducer& transducer, bool fast) {
  if (fast) {
    HastyOutput link;
    serve(link, transducer, true);
    const bool failed = std::fflush(stdout) != 0 || std::ferror(stdout) != 0;
    if (!failed || reader_left(STDOUT_FILENO)) { return; }
    throw InputError(
        "standard output: cannot be written; a place with room for all bytes is needed");
  }
  device::DescriptorLink link(-1, STDOUT_FILENO);  // nothing is read: poll ignores -1
  serve(link, transducer, true);
}

void tell(const Transducer& transducer) {
  const device::falcon::FaultCounts& faults = transducer.faults();
  std::cerr << transducer.frames_sent() << " frames, " << faults.bytes << " bytes; dropped "
            << faults.dropped << ", doubled " << faults.duplicated << ", corrupted "
            << faults.corrupted << "; writes that were not taken: " << transducer.lost_writes()
            << '\n';
}

/// Rejects a recording that is too long. Gaps also take frame periods.
void refuse_too_long(const Recording& recording, const std::filesystem::path& path) {
  constexpr double longest = double{io::most_samples} / device::pressure_link::frames_per_second;
  const double span = recording.time.back() - recording.time.front();
  if (span <= longest) { return; }
  throw InputError(path.string() + ": lasts " + std::to_string(span) + " s; at most " +
                   std::to_string(longest) + " s can be sent");
}

void tell_resampling(const Recording& recording) {
  constexpr double same_rate = 0.01;  // [Hz]
  if (std::abs(recording.sample_rate - device::pressure_link::frames_per_second) < same_rate) {
    return;
  }
  std::fprintf(stderr, "sampled at %.6g Hz, sent at %.6g Hz: interpolated between samples\n",
               recording.sample_rate, device::pressure_link::frames_per_second);
}

int run_transducer(const TransducerCommandOptions& options) {
  keep_results_of_interrupted();
  if (int(options.pty) + int(options.stdio) != 1 || (options.fast && !options.stdio)) {
    throw InputError(
        "transducer needs a mode; exactly one of --pty and --stdio (--fast: --stdio alone)");
  }
  const Recording recording = read_any_recording(options.recording).recording;
  if (recording.pressure.empty()) {
    throw InputError(options.recording.string() + ": has no pressure; only that can be sent");
  }
  refuse_too_long(recording, options.recording);
  if (!options.quiet) { tell_resampling(recording); }
  Transducer source(link_frames(recording), {.faults = faults_of(options),
                                             .battery_low = options.battery_low,
                                             .repeats = options.repeat});
  return serve_device([&] {
    if (options.pty) {
      const std::unique_ptr<device::PtyLink> link = open_terminal();
      serve(*link, source, false);
      // Closing the terminal would discard bytes that the client has not read yet.
      const double end = link->now();
      double empty_since = end;
      while (!interrupted && link->now() < end + last_patience &&
             link->now() < empty_since + settling) {
        ::poll(nullptr, 0, 10);
        if (link->unread_bytes() > 0) { empty_since = link->now(); }
      }
    } else {
      serve_output(source, options.fast);
    }
    if (!options.quiet) { tell(source); }
  });
}

}  // namespace

void add_transducer(Program& program) {
  const auto [command, options] = add_command(
      program, "transducer", "replay a recording as the 9600 baud pressure link", run_transducer);
  add_value(command, "recording", options.recording, "RECORDING",
            "recording in any format that import reads")
      ->required();
  add_terminal(command, options.pty);
  command.add_flag("--stdio", options.stdio, "on standard output");
  command.add_flag("--fast", options.fast,
                   "with --stdio: as fast as the reader takes them, not at 9600 baud");
  command.add_flag("--repeat", options.repeat, "begin again after the last sample, until Ctrl-C");
  const auto add_chance = [&command](const char* name, double& chance, const char* help) {
    command.add_option(name, chance, std::string("chance of each byte to ") + help + " [0]")
        ->check(number_range(0.0, 1.0));
  };
  add_chance("--drop", options.drop, "be lost");
  add_chance("--double", options.duplicate, "be doubled");
  add_chance("--corrupt", options.corrupt, "be replaced by another");
  add_chance("--burst", options.burst, "start a burst of corrupted bytes");
  command.add_option("--burst-bytes", options.burst_bytes, "number of bytes of a burst [20]")
      ->check(CLI::Range(1, 1000000));
  command.add_option("--seed", options.seed, "seed of the faults [1]")->check(seed_range());
  command.add_flag("--battery-low", options.battery_low, "set the low-battery flag in every frame");
  command.footer(
      "One of --pty and --stdio is needed. 8 bytes a sample, 120 samples/s (docs/formats.md).\n"
      "Ends with the recording, or at Ctrl-C. The same seed gives the same faults.");
}

}  // namespace palpate::cli
