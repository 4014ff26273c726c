// SPDX-License-Identifier: MIT
/// The command `falcon`.

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <optional>
#include <unistd.h>

#include "device/falcon/emulator.hpp"
#include "device/falcon/kinematics.hpp"
#include "device/falcon/motors_encoders.hpp"
#include "device/falcon/packet.hpp"
#include "device/falcon/plant.hpp"
#include "fixtures/io/csv_file.hpp"
#include "fixtures/io/csv_tables.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "model/problem/input_error.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/falcon_script.hpp"

namespace palpate::cli {
namespace {

using namespace device;
using namespace device::falcon;

/// Exactly one of the modes `pty`, `stdio` and `solve` is given.
struct FalconOptions : CommonOptions {
  bool pty = false;
  bool stdio = false;
  std::filesystem::path script{};  ///< empty: no faults, and a hand at rest that homes on request
  std::filesystem::path solve{};   ///< poses to solve
};

/// Writer of log.csv: one row per request and per event (docs/formats.md). Rows are kept in
/// reserved memory until flush(), so that nothing is written between a request and its reply. The
/// file has a temporary name until finish().
class FalconLog final : public EmulatorObserver {
 public:
  /// Throws InputError if the file cannot be written.
  FalconLog(const std::filesystem::path& path, const Firmware& firmware)
      : path_(path), temporary_(io::temporary_name(path)), file_(temporary_), firmware_(firmware) {
    if (!file_) { fail(); }
    rows_.reserve(most_rows);
    file_ << "time_s,word_1,word_2,word_3,homing,leds,count_1,count_2,count_3,buttons,homed,event,"
             "state\n"
          << std::fixed << std::setprecision(6);
  }
  FalconLog(const FalconLog&) = delete;
  FalconLog& operator=(const FalconLog&) = delete;
  ~FalconLog() override { std::remove(temporary_.c_str()); }

  void served(double time_s, const HostPacket& request,
              const DevicePacket& reply) noexcept override {
    add({.time = time_s, .state = firmware_.state(), .request = request, .reply = reply});
  }
  void happened(double time_s, FirmwareEvent event) noexcept override {
    add({.time = time_s, .event = event, .state = firmware_.state()});
  }
  /// Writes the kept rows if there are at least `many`.
  void flush(std::size_t many) {
    if (rows_.size() < many) { return; }
    for (const Row& row : rows_) { write(row); }
    rows_.clear();
  }
  /// Writes the remaining rows and renames the file. Throws InputError.
  void finish() {
    flush(0);
    file_.close();
    if (!file_ || std::rename(temporary_.c_str(), path_.c_str()) != 0) { fail(); }
  }
  [[nodiscard]] std::int64_t left_out() const noexcept { return left_out_; }

 private:
  struct Row {
    double time = 0.0;
    std::optional<FirmwareEvent> event{};  ///< empty: a request
    FirmwareState state{};
    HostPacket request{};
    DevicePacket reply{};
  };
  static constexpr std::size_t most_rows = 1U << 16U;  // a minute at 1 kHz

  [[noreturn]] void fail() const {
    throw InputError(path_.string() + ": cannot be written: " + std::strerror(errno));
  }
  void add(const Row& row) noexcept {
    if (rows_.size() < most_rows) {
      rows_.push_back(row);
    } else {
      ++left_out_;
    }
  }
  void write(const Row& row) {
    file_ << row.time << ',';
    if (row.event) {
      file_ << ",,,,,,,,,," << name_of(*row.event);
    } else {
      constexpr unsigned button_bits = 0x0F;
      constexpr unsigned homed_shift = 4;
      const unsigned asked = info_bits(row.request);
      const unsigned told = info_bits(row.reply);
      for (const auto word : row.request.words) { file_ << word << ','; }
      file_ << (asked & 1U) << ',' << (asked >> 1U) << ',';
      for (const auto count : row.reply.counts) { file_ << count << ','; }
      file_ << (told & button_bits) << ',' << (told >> homed_shift) << ",request";
    }
    file_ << ',' << name_of(row.state) << '\n';
  }

  std::filesystem::path path_;
  std::filesystem::path temporary_;
  std::ofstream file_;
  const Firmware& firmware_;
  std::vector<Row> rows_{};
  std::int64_t left_out_ = 0;
};

constexpr std::string_view header =
    "theta1_1_rad,theta1_2_rad,theta1_3_rad,count_1,count_2,count_3,forward_x_m,forward_y_m,"
    "forward_z_m,torque_1_nm,torque_2_nm,torque_3_nm,word_1,word_2,word_3,packet\n";

/// Kinematics of one pose: angles and torques at the exact pose, the position of its rounded
/// counts, and the motor words of the torques.
struct Solution {
  Eigen::Vector3d theta1{};
  Counts counts{};
  Eigen::Vector3d forward{};
  Eigen::Vector3d torque{};
  Words words{};
};

std::optional<Solution> solve(const Kinematics& kinematics, const io::Pose& pose) {
  const auto angles = kinematics.inverse(pose.position);
  const auto jacobian = kinematics.jacobian(pose.position);
  if (!angles || !jacobian) { return std::nullopt; }
  Solution solution{.theta1 = angles->theta1};
  solution.counts = counts_of_angles(kinematics.geometry(), angles->theta1);
  const Eigen::Vector3d rounded = angles_of_counts(kinematics.geometry(), solution.counts);
  const auto forward = kinematics.forward(rounded);
  if (!forward) { return std::nullopt; }
  solution.forward = *forward;
  const Eigen::Vector3d torque = torque_of_force(*jacobian, pose.force);
  solution.torque = torque.array() + 0.0;  // no negative zero
  solution.words = words_of_torque({}, solution.torque).sent;
  return solution;
}

template <class Values> void append(std::string& text, const Values& values) {
  for (const auto value : values) {
    io::append_number(text, static_cast<double>(value));
    text += ',';
  }
}

std::string row(const Solution& solution) {
  std::string text;
  append(text, solution.theta1);
  append(text, solution.counts);
  append(text, solution.forward);
  append(text, solution.torque);
  append(text, solution.words);
  for (const std::uint8_t byte : encode(HostPacket{.words = solution.words})) {
    text += static_cast<char>(byte);  // printable: markers and nibbles alone
  }
  return text + '\n';
}

int falcon_solve(const FalconOptions& options) {
  const Kinematics kinematics;
  io::Problems problems;
  std::string text(header);
  const auto within_reach = [&](const Eigen::Vector3d& position) -> std::string_view {
    const bool reached = solve(kinematics, {.position = position}).has_value();
    return reached ? "" : "must be within the reach of all three legs";
  };
  const std::vector<io::Pose> poses = io::read_pose_csv(options.solve, within_reach, problems);
  problems.throw_if_any();
  for (const io::Pose& pose : poses) { text += row(*solve(kinematics, pose)); }
  const std::filesystem::path folder = options.make_folder({"solution.csv"});
  io::replace_file(folder / "solution.csv", text);
  std::printf("%zu poses: %s\n", poses.size(),
              io::printable((folder / "solution.csv").string()).c_str());
  return done;
}

/// Serves until the input ends or an interrupt. Bytes in transit at the end of the input are still
/// delivered.
void serve(ByteLink& link, Emulator& emulator, FalconLog& log) {
  constexpr std::size_t many_rows = 256;
  while (!interrupted && (!link.ended() || emulator.busy())) {
    (void)link.wait_until(emulator.next_call(link.now()));
    emulator.serve(link);
    log.flush(many_rows);
  }
}

void tell_faults(const char* direction, const FaultCounts& counts) {
  std::cerr << direction << ": " << counts.bytes << " bytes; dropped " << counts.dropped
            << ", doubled " << counts.duplicated << ", corrupted " << counts.corrupted
            << ", unplugged " << counts.unplugged << ", overflowed " << counts.overflowed
            << "; writes delayed " << counts.delayed_writes << '\n';
}

void tell(const Emulator& emulator, const FalconLog& log) {
  const Firmware& firmware = emulator.firmware();
  const ReaderCounts& reader = firmware.reader_counts();
  std::cerr << name_of(firmware.state()) << ": " << reader.frames << " requests, "
            << firmware.replies() << " replies; bad frames " << reader.bad_frames
            << ", bytes skipped " << reader.skipped_bytes << '\n';
  for (std::size_t n = 0; n < firmware_event_count; ++n) {
    const auto event = static_cast<FirmwareEvent>(n);
    if (firmware.count(event) == 0) { continue; }
    std::cerr << name_of(event) << ": " << firmware.count(event) << '\n';
  }
  tell_faults("to device", emulator.faults_to_device());
  tell_faults("to host", emulator.faults_to_host());
  if (log.left_out() + emulator.lost_writes() > 0) {
    std::cerr << "rows left out of the log: " << log.left_out()
              << "; writes that were not taken: " << emulator.lost_writes() << '\n';
  }
}

/// A grip moved by the script, or else a hand that holds the mechanism and homes it on request.
std::unique_ptr<Body> make_body(const FalconScript& script) {
  if (script.moves_grip) { return std::make_unique<ScriptedGrip>(script.grip); }
  const PlantBodyOptions options{.homed = false, .homes = true, .seed = script.faults.seed};
  Hand hand;
  hand.intent = Intent({.start = options.start});
  return std::make_unique<PlantBody>(options, hand);
}

int run_falcon(const FalconOptions& options) {
  keep_results_of_interrupted();
  const int modes = int(options.pty) + int(options.stdio) + int(!options.solve.empty());
  if (modes != 1) {
    throw InputError("falcon needs a mode; exactly one of --pty, --stdio and --solve");
  }
  if (!options.solve.empty()) {
    if (!options.script.empty() || !options.overrides.empty()) {
      throw InputError("falcon --solve takes no --script and no --set: it has kinematics alone");
    }
    return falcon_solve(options);
  }
  const FalconScript script = read_falcon_script(options.script, options.overrides);
  const std::filesystem::path folder = options.make_folder({"log.csv"});
  const std::unique_ptr<Body> body = make_body(script);
  Emulator emulator(*body, script.firmware, script.faults);
  FalconLog log(folder / "log.csv", emulator.firmware());
  emulator.observe(&log);
  return serve_device([&] {
    if (options.pty) {
      serve(*open_terminal(), emulator, log);
    } else {
      DescriptorLink link(STDIN_FILENO, STDOUT_FILENO);
      serve(link, emulator, log);
    }
    log.finish();
    if (!options.quiet) { tell(emulator, log); }
  });
}

}  // namespace

void add_falcon(Program& program) {
  const auto [command, options] = add_command(
      program, "falcon", "the emulated Novint Falcon: on its wire protocol, or its kinematics",
      run_falcon);
  add_terminal(command, options.pty);
  command.add_flag("--stdio", options.stdio, "on standard input and output, until the input ends");
  add_value(command, "--solve", options.solve, "FILE",
            "kinematics of the poses in a CSV file with x_m,y_m,z_m and optionally fx_n,fy_n,fz_n");
  add_value(command, "--script", options.script, "FILE",
            "faults, grip and buttons by time (TOML, docs/falcon.md)");
  add_overrides(command, options, "script");
  command.footer(
      "One of --pty, --stdio and --solve is needed. Ctrl-C ends the service; log.csv in DIR has "
      "every\nrequest. --solve writes solution.csv.\ndocs/falcon.md shows how to connect.");
}

}  // namespace palpate::cli
