// SPDX-License-Identifier: MIT

#include <cmath>
#include <cstdio>

#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/recording_file.hpp"
#include "model/problem/input_error.hpp"
#include "model/problem/recording.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/loaded_scene.hpp"
#include "reports/recording_input.hpp"

namespace palpate::cli {
namespace {

struct ImportOptions : CommonOptions {
  std::filesystem::path file{};
  std::string format = "auto";
  std::vector<std::string> columns{};       ///< NAME=ROLE
  std::optional<double> sample_rate{};      ///< [Hz], for a file without time
  std::optional<double> body_mass_index{};  ///< [kg/m^2]
  std::optional<double> plunger_area{};     ///< [m^2]
  std::string technique{}, source{}, group{}, subject{}, name{};
  bool pump = false;  ///< pressure of a pump, not of a thumb
};

constexpr std::size_t most_imported_bytes = std::size_t{1} << 30U;

RecordingFormat format_named(const std::string& name) {
  for (const RecordingFormat format : {RecordingFormat::automatic, RecordingFormat::csv,
                                       RecordingFormat::raw, RecordingFormat::hdf5}) {
    if (name == name_of(format)) { return format; }
  }
  throw InputError("--format " + name + "; must be auto, csv, raw or hdf5");
}

/// Options of the command line override the contents of the file.
void apply(const ImportOptions& options, Recording& recording) {
  if (options.body_mass_index) { recording.body_mass_index = options.body_mass_index; }
  if (options.plunger_area) { recording.plunger_area = *options.plunger_area; }
  if (!options.technique.empty()) { recording.technique = options.technique; }
  if (!options.source.empty()) { recording.source = options.source; }
  if (!options.group.empty()) { recording.group = options.group; }
  if (!options.subject.empty()) { recording.subject = options.subject; }
  if (!options.name.empty()) { recording.name = options.name; }
  if (options.pump) { recording.regime = Recording::Regime::pump; }
  if (recording.name.empty()) { recording.name = options.file.stem().string(); }
  const std::string hash = io::content_hash(io::read_bytes(options.file, most_imported_bytes));
  recording.note += (recording.note.empty() ? "" : "; ") + ("imported file: FNV-1a " + hash);
}

void tell_samples(const InputRecording& read) {
  const Recording& recording = read.recording;
  const Extremes pressure = extremes_of(recording.pressure);
  std::printf("%s: %zu samples, %.6g Hz, %.6g s\n", std::string(name_of(read.format)).c_str(),
              recording.time.size(), recording.sample_rate,
              recording.time.back() - recording.time.front());
  std::printf("pressure from %.6g to %.6g kPa (%.4g to %.4g mmHg)\n", 1e-3 * pressure.least,
              1e-3 * pressure.largest, pressure.least / pascals_per_mmhg,
              pressure.largest / pascals_per_mmhg);
  if (recording.kind == Recording::Kind::reconstructed) {
    std::printf("%s: not a measurement\n", std::string(io::reconstruction_note).c_str());
  }
  for (const std::string& line : read.found) { std::printf("%s\n", line.c_str()); }
}

void tell_defects(const InputRecording& read) {
  if (read.frames) {
    std::printf(
        "frames: %lld good, %lld bad, %lld missing in %lld gaps, %lld repeated; %lld bytes "
        "skipped\n",
        static_cast<long long>(read.frames->frames),
        static_cast<long long>(read.frames->bad_frames),
        static_cast<long long>(read.frames->missing), static_cast<long long>(read.frames->gaps),
        static_cast<long long>(read.frames->repeated),
        static_cast<long long>(read.frames->skipped_bytes));
  }
  const RecordingDefects& defects = read.recording.defects;
  std::printf(
      "missing %zu in %zu gaps, not a number %zu, out of range %zu, clipped %zu, out of order "
      "%zu\n",
      defects.missing, defects.gaps, defects.not_finite, defects.out_of_range, defects.clipped,
      defects.not_increasing);
  for (const std::string& warning : read.warnings) {
    std::printf("warning: %s\n", warning.c_str());
  }
}

int run_import(const ImportOptions& options) {
  InputRecording read =
      read_any_recording(options.file, format_named(options.format),
                         {.columns = options.columns, .sample_rate = options.sample_rate});
  apply(options, read.recording);
  const std::filesystem::path folder = make_folder(options.folder("import"));
  io::write_recording_hdf5(folder / "recording.h5", read.recording);
  io::write_recording_csv(folder / "recording.csv", read.recording);
  if (options.quiet) { return done; }
  tell_samples(read);
  tell_defects(read);
  std::printf("%s\n%s\n", (folder / "recording.h5").c_str(), (folder / "recording.csv").c_str());
  return done;
}

}  // namespace

void add_import(CLI::App& app, std::function<int()>& chosen) {
  const auto [command, options] =
      add_command(app, chosen, "import",
                  "convert a recording of any supported format to recording.h5", run_import);
  command
      .add_option("file", options.file, "CSV, recording.h5, MATLAB 7.3, or bytes of the raw link")
      ->required()
      ->type_name("FILE");
  command.add_option("--format", options.format, "auto (by content), csv, raw or hdf5 [auto]");
  command
      .add_option(
          "--column", options.columns,
          "content of a column: time_ms, pressure_kPa, depth_mm, force_N, ignore; repeatable")
      ->type_name("NAME=ROLE")
      ->allow_extra_args(false);
  const CLI::Validator positive = number_range(1e-12, 1e12);
  command.add_option("--rate", options.sample_rate, "samples per second, for a file without time")
      ->type_name("HZ")
      ->check(positive);
  command.add_option("--bmi", options.body_mass_index, "body mass index, kg/m^2")
      ->type_name("BMI")
      ->check(positive);
  command.add_option("--plunger-area", options.plunger_area, "m^2 [1.767e-4]")
      ->type_name("AREA")
      ->check(positive);
  command.add_option("--technique", options.technique, "continuous or intermittent")
      ->check(CLI::IsMember({"continuous", "intermittent"}));
  command.add_option("--source", options.source, "publication, hospital or device")
      ->type_name("TEXT");
  command.add_option("--group", options.group, "group of subjects")->type_name("TEXT");
  command
      .add_option("--subject", options.subject,
                  "code of the person; all recordings of one person count once")
      ->type_name("TEXT");
  command.add_option("--name", options.name, "display name [the file's]")->type_name("TEXT");
  command.add_flag("--pump", options.pump,
                   "the pressure is that of an injection pump, not of a thumb");
  add_common(command, options, "import");
  command.footer(
      "Units: a column is named like pressure_mmHg, \"pressure (kPa)\" or \"t [s]\", or has its\n"
      "role from --column. Writes recording.h5 and recording.csv. docs/recordings.md shows how.");
}

}  // namespace palpate::cli
