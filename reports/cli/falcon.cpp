// SPDX-License-Identifier: MIT
/// The command `falcon`.

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>
#include <unistd.h>
#include <vector>

#include "device/byte_link.hpp"
#include "device/falcon/emulator.hpp"
#include "device/falcon/kinematics.hpp"
#include "device/falcon/motors_encoders.hpp"
#include "device/falcon/packet.hpp"
#include "device/falcon/plant.hpp"
#include "fixtures/io/csv_file.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/pose_csv.hpp"
#include "model/problem/input_error.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/falcon_script.hpp"
#include "reports/cli/loaded_scene.hpp"

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
  FalconLog(const std::filesystem::path& path, const Firmware& firmware);
  FalconLog(const FalconLog&) = delete;
  FalconLog& operator=(const FalconLog&) = delete;
  ~FalconLog() override;

  void served(double time_s, const HostPacket& request,
              const DevicePacket& reply) noexcept override;
  void happened(double time_s, FirmwareEvent event) noexcept override;

  /// Writes the kept rows if there are many.
  void flush_if_many() noexcept;
  /// Writes the remaining rows and renames the file. Throws InputError.
  void finish();
  [[nodiscard]] std::int64_t left_out() const noexcept { return left_out_; }

 private:
  struct Row {
    double time = 0.0;
    std::optional<FirmwareEvent> event{};  ///< empty: a request
    FirmwareState state{};
    HostPacket request{};
    DevicePacket reply{};
  };
  void add(const Row& row) noexcept;
  void write(const Row& row) noexcept;
  void flush() noexcept;

  std::filesystem::path path_;
  std::filesystem::path temporary_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
  const Firmware& firmware_;
  std::vector<Row> rows_{};
  std::int64_t left_out_ = 0;
  bool failed_ = false;
};

constexpr std::size_t most_rows = 1U << 16U;  // a minute at 1 kHz
constexpr std::size_t many_rows = 256;
constexpr unsigned button_bits = 0x0F;
constexpr unsigned homed_shift = 4;

[[noreturn]] void fail(const std::filesystem::path& path) {
  throw InputError(path.string() + ": cannot be written: " + std::strerror(errno));
}

FalconLog::FalconLog(const std::filesystem::path& path, const Firmware& firmware)
    : path_(path),
      temporary_(io::temporary_name(path)),
      file_(std::fopen(temporary_.c_str(), "we"), &std::fclose),
      firmware_(firmware) {
  if (!file_) { fail(path_); }
  rows_.reserve(most_rows);
  std::fputs(
      "time_s,word_1,word_2,word_3,homing,leds,count_1,count_2,count_3,buttons,homed,event,state\n",
      file_.get());
}

FalconLog::~FalconLog() {
  if (file_) { std::remove(temporary_.c_str()); }
}

void FalconLog::served(double time_s, const HostPacket& request,
                       const DevicePacket& reply) noexcept {
  add({.time = time_s, .state = firmware_.state(), .request = request, .reply = reply});
}

void FalconLog::happened(double time_s, FirmwareEvent event) noexcept {
  add({.time = time_s, .event = event, .state = firmware_.state()});
}

void FalconLog::add(const Row& row) noexcept {
  if (rows_.size() < most_rows) {
    rows_.push_back(row);
  } else {
    ++left_out_;
  }
}

void FalconLog::flush_if_many() noexcept {
  if (rows_.size() >= many_rows) { flush(); }
}

void FalconLog::flush() noexcept {
  for (const Row& row : rows_) { write(row); }
  rows_.clear();
}

void FalconLog::write(const Row& row) noexcept {
  std::FILE* file = file_.get();
  if (row.event) {
    failed_ |= std::fprintf(file, "%.6f,,,,,,,,,,,%s,%s\n", row.time, name_of(*row.event),
                            name_of(row.state)) < 0;
    return;
  }
  const unsigned asked = info_bits(row.request);
  const unsigned told = info_bits(row.reply);
  failed_ |=
      std::fprintf(file, "%.6f,%d,%d,%d,%u,%u,%d,%d,%d,%u,%u,request,%s\n", row.time,
                   row.request.words[0], row.request.words[1], row.request.words[2], asked & 1U,
                   asked >> 1U, row.reply.counts[0], row.reply.counts[1], row.reply.counts[2],
                   told & button_bits, told >> homed_shift, name_of(row.state)) < 0;
}

void FalconLog::finish() {
  flush();
  failed_ |= std::fclose(file_.release()) != 0;
  const bool renamed = !failed_ && std::rename(temporary_.c_str(), path_.c_str()) == 0;
  if (renamed) { return; }
  std::remove(temporary_.c_str());
  fail(path_);
}

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
  const std::filesystem::path folder = make_folder(options.folder("falcon"));
  io::replace_file(folder / "solution.csv", text);
  if (!options.quiet) {
    std::printf("%zu poses: %s\n", poses.size(), (folder / "solution.csv").string().c_str());
  }
  return done;
}

/// Serves until the input ends or an interrupt. Bytes in transit at the end of the input are still
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
    std::fprintf(stderr, "rows left out of the log: %lld; writes that were not taken: %lld\n",
                 static_cast<long long>(log.left_out()),
                 static_cast<long long>(emulator.lost_replies()));
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

std::unique_ptr<ByteLink> make_link(bool pty) {
  if (!pty) { return std::make_unique<DescriptorLink>(STDIN_FILENO, STDOUT_FILENO); }
  auto link = std::make_unique<PtyLink>();
  std::printf("%s\n", link->path().c_str());
  std::fflush(stdout);
  return link;
}

int run_falcon(const FalconOptions& options) {
  catch_interrupts();
  const int modes = int(options.pty) + int(options.stdio) + int(!options.solve.empty());
  if (modes != 1) {
    throw InputError("falcon needs a mode; exactly one of --pty, --stdio and --solve");
  }
  if (!options.solve.empty()) { return falcon_solve(options); }
  const FalconScript script = read_falcon_script(options.script, options.overrides);
  const std::filesystem::path folder = make_folder(options.folder("falcon"));
  std::signal(SIGPIPE,
              SIG_IGN);  // a closed reader then causes a failed write, not the end of the program
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

}  // namespace

void add_falcon(CLI::App& app, std::function<int()>& chosen) {
  const auto [command, options] = add_command(
      app, chosen, "falcon", "the emulated Novint Falcon: on its wire protocol, or its kinematics",
      run_falcon);
  command.add_flag("--pty", options.pty,
                   "on a new pseudo-terminal, whose path is the first line of output");
  command.add_flag("--stdio", options.stdio, "on standard input and output, until the input ends");
  command
      .add_option(
          "--solve", options.solve,
          "kinematics of the poses in a CSV file with x_m,y_m,z_m and optionally fx_n,fy_n,fz_n")
      ->type_name("FILE");
  command
      .add_option("--script", options.script,
                  "faults, grip and buttons by time (TOML, docs/falcon.md)")
      ->type_name("FILE");
  add_overrides(command, options, "script");
  add_common(command, options, "falcon");
  command.footer(
      "One of --pty, --stdio and --solve is needed. Ctrl-C ends the service; log.csv in DIR has "
      "every\n"
      "request. --solve writes solution.csv.\n"
      "docs/falcon.md shows how to connect.");
}

}  // namespace palpate::cli
