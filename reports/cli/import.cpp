// SPDX-License-Identifier: MIT
/// The commands `import` and `reconstruct`.

#include <cstdio>
#include <iostream>

#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/recording_file.hpp"
#include "model/problem/input_error.hpp"
#include "model/problem/recording.hpp"
#include "reports/cli/commands.hpp"
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
  std::string technique{}, source{}, group{}, subject{}, name_shown{};
  bool pump = false;  ///< pressure of a pump, not of a thumb
};

int run_import(const ImportOptions& options) {
  InputRecording read =
      read_any_recording(options.file, format_named("--format", options.format),
                         {.columns = options.columns, .sample_rate = options.sample_rate});
  // Options of the command line override the contents of the file.
  if (options.body_mass_index) { read.recording.body_mass_index = options.body_mass_index; }
  if (options.plunger_area) { read.recording.plunger_area = *options.plunger_area; }
  if (!options.technique.empty()) { read.recording.technique = options.technique; }
  if (!options.source.empty()) { read.recording.source = options.source; }
  if (!options.group.empty()) { read.recording.group = options.group; }
  if (!options.subject.empty()) { read.recording.subject = options.subject; }
  if (!options.name_shown.empty()) { read.recording.name = options.name_shown; }
  if (options.pump) { read.recording.regime = Recording::Regime::pump; }
  if (read.recording.name.empty()) { read.recording.name = options.file.stem().string(); }
  read.recording.note += (read.recording.note.empty() ? "" : "; ") +
                         ("imported file: FNV-1a " + hash_of_file(options.file));
  const std::filesystem::path folder = options.make_folder();
  io::write_recording_hdf5(folder / "recording.h5", read.recording);
  io::write_recording_csv(folder / "recording.csv", read.recording);
  if (options.quiet) { return done; }
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
  if (read.frames) {
    std::cout << "frames: " << read.frames->frames << " good, " << read.frames->bad_frames
              << " bad, " << read.frames->missing << " missing in " << read.frames->gaps
              << " gaps, " << read.frames->repeated << " repeated; " << read.frames->skipped_bytes
              << " bytes skipped\n";
  }
  const RecordingDefects& defects = read.recording.defects;
  std::cout << "missing " << defects.missing << " in " << defects.gaps << " gaps, not a number "
            << defects.not_finite << ", out of range " << defects.out_of_range << ", clipped "
            << defects.clipped << ", out of order " << defects.not_increasing << '\n';
  for (const std::string& warning : read.warnings) { std::cout << "warning: " << warning << '\n'; }
  std::printf("%s\n%s\n", (folder / "recording.h5").c_str(), (folder / "recording.csv").c_str());
  return done;
}

struct ReconstructOptions : CommonOptions {
  std::filesystem::path table{};
};

int run_reconstruct(const ReconstructOptions& options) {
  const std::vector<Recording> recordings =
      reconstructed_recordings(io::read_published_values(options.table));
  const std::filesystem::path folder = options.make_folder();
  for (const Recording& recording : recordings) {
    io::write_recording_hdf5(folder / (recording.name + ".h5"), recording);
  }
  if (!options.quiet) {
    std::printf("%zu recordings, reconstructed from published summary values: %s\n",
                recordings.size(), folder.c_str());
  }
  return done;
}

}  // namespace

void add_import(Program& program) {
  const auto [command, options] = add_command(
      program, "import", "convert a recording of any supported format to recording.h5", run_import);
  add_value(command, "file", options.file, "FILE",
            "CSV, recording.h5, MATLAB 7.3, or bytes of the raw link")
      ->required();
  command.add_option("--format", options.format, "auto (by content), csv, raw or hdf5 [auto]");
  add_value(command, "--column", options.columns, "NAME=ROLE",
            "content of a column: time_ms, pressure_kPa, depth_mm, force_N, ignore; repeatable");
  const CLI::Validator positive = number_range(1e-12, 1e12);
  add_value(command, "--rate", options.sample_rate, "HZ",
            "samples per second, for a file without time")
      ->check(positive);
  add_value(command, "--bmi", options.body_mass_index, "BMI", "body mass index, kg/m^2")
      ->check(positive);
  add_value(command, "--plunger-area", options.plunger_area, "AREA", "m^2 [1.767e-4]")
      ->check(positive);
  command.add_option("--technique", options.technique, "continuous or intermittent")
      ->check(CLI::IsMember({"continuous", "intermittent"}));
  add_value(command, "--source", options.source, "TEXT", "publication, hospital or device");
  add_value(command, "--group", options.group, "TEXT", "group of subjects");
  add_value(command, "--subject", options.subject, "TEXT",
            "code of the person; all recordings of one person count once");
  add_value(command, "--name", options.name_shown, "TEXT", "display name [the file's]");
  command.add_flag("--pump", options.pump,
                   "the pressure is that of an injection pump, not of a thumb");
  command.footer(
      "Units: a column is named like pressure_mmHg, \"pressure (kPa)\" or \"t [s]\", or has its\n"
      "role from --column. Writes recording.h5 and recording.csv. docs/recordings.md shows how.");
}

void add_reconstruct(Program& program) {
  const auto [command, options] =
      add_command(program, "reconstruct", "recordings rebuilt from a table of published values",
                  run_reconstruct);
  add_value(command, "table", options.table, "TABLE",
            "fixtures/clinical/published_values.csv, or one like it")
      ->required();
  command.footer(
      "Writes one .h5 per recording into DIR. They are no measurements, and each says so\n"
      "(fixtures/recordings/README.md).");
}

}  // namespace palpate::cli
