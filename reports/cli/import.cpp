// SPDX-License-Identifier: MIT
/// The commands `import` and `reconstruct`.

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <limits>

#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/recording_file.hpp"
#include "model/problem/input_error.hpp"
#include "model/problem/recording.hpp"
#include "reports/cli/commands.hpp"
#include "reports/recording_input.hpp"
#include "reports/recording_preset.hpp"

namespace palpate::cli {
namespace {

struct ImportOptions : CommonOptions {
  std::vector<std::filesystem::path> files{};
  std::string preset{};  ///< name of a preset, or a JSON file
  std::string format = "auto";
  std::vector<std::string> columns{};       ///< NAME=ROLE
  std::optional<double> sample_rate{};      ///< [Hz], for a file without time
  std::optional<double> body_mass_index{};  ///< [kg/m^2]
  std::optional<double> plunger_area{};     ///< [m^2]
  std::string technique{}, source{}, group{}, subject{}, name_shown{};
  bool pump = false;  ///< pressure of a pump, not of a thumb
};

/// Roles of the preset, except for columns that the user gave another.
io::ReadOptions read_options(const ImportOptions& options, const RecordingPreset& preset) {
  io::ReadOptions read{.columns = options.columns, .sample_rate = options.sample_rate};
  if (!read.sample_rate) { read.sample_rate = preset.read.sample_rate; }
  for (const std::string& role : preset.read.columns) {
    const std::string name = role.substr(0, role.rfind('=') + 1);
    const bool given = std::ranges::any_of(
        options.columns, [&](const std::string& one) { return one.starts_with(name); });
    if (!given) { read.columns.push_back(role); }
  }
  return read;
}

InputRecording read_one(const ImportOptions& options, const std::filesystem::path& file,
                        const std::optional<RecordingPreset>& preset) {
  InputRecording read =
      read_any_recording(file, format_named("--format", options.format),
                         read_options(options, preset.value_or(RecordingPreset{})));
  if (preset) { apply(*preset, file, read); }
  // Options of the command line override the contents of the file.
  Recording& recording = read.recording;
  if (options.body_mass_index) { recording.body_mass_index = options.body_mass_index; }
  if (options.plunger_area) { recording.plunger_area = *options.plunger_area; }
  if (!options.technique.empty()) { recording.technique = options.technique; }
  if (!options.source.empty()) { recording.source = options.source; }
  if (!options.group.empty()) { recording.group = options.group; }
  if (!options.subject.empty()) { recording.subject = options.subject; }
  if (!options.name_shown.empty()) { recording.name = options.name_shown; }
  if (options.pump) { recording.regime = Recording::Regime::pump; }
  if (recording.name.empty()) { recording.name = file.stem().string(); }
  recording.note +=
      (recording.note.empty() ? "" : "; ") + ("imported file: FNV-1a " + hash_of_file(file));
  return read;
}

void tell_range(const char* signal, const std::vector<double>& values, double factor,
                const char* unit) {
  if (values.empty()) { return; }
  const Extremes range = extremes_of(values);
  std::printf("%s from %.6g to %.6g %s", signal, factor * range.least, factor * range.largest,
              unit);
}

void tell(const InputRecording& read) {
  const Recording& recording = read.recording;
  std::printf("%s: %zu samples, %.6g Hz, %.6g s\n", std::string(name_of(read.format)).c_str(),
              recording.time.size(), recording.sample_rate,
              recording.time.back() - recording.time.front());
  if (!recording.pressure.empty()) {
    const Extremes pressure = extremes_of(recording.pressure);
    tell_range("pressure", recording.pressure, 1e-3, "kPa");
    std::printf(" (%.4g to %.4g mmHg)\n", pressure.least / pascals_per_mmhg,
                pressure.largest / pascals_per_mmhg);
  } else {
    tell_range("force", recording.force, 1.0, "N");
    std::printf("\n");
  }
  if (recording.kind == Recording::Kind::reconstructed) {
    std::printf("%s: not a measurement\n", std::string(io::reconstruction_note).c_str());
  }
  if (recording.kind == Recording::Kind::measured_phantom) {
    std::printf("measured phantom: no patient\n");
  }
  for (const std::string& line : read.found) { std::printf("%s\n", io::printable(line).c_str()); }
  if (read.frames) {
    std::cout << "frames: " << read.frames->frames << " good, " << read.frames->bad_frames
              << " bad, " << read.frames->missing << " missing in " << read.frames->gaps
              << " gaps, " << read.frames->repeated << " repeated; " << read.frames->skipped_bytes
              << " bytes skipped\n";
  }
  const RecordingDefects& defects = recording.defects;
  std::cout << "missing " << defects.missing << " in " << defects.gaps << " gaps, not a number "
            << defects.not_finite << ", out of range " << defects.out_of_range << ", clipped "
            << defects.clipped << ", out of order " << defects.not_increasing << '\n';
  for (const std::string& warning : read.warnings) {
    std::cout << "warning: " << io::printable(warning) << '\n';
  }
}

/// Imports several files into one folder, each as NAME.h5.
int import_all(const ImportOptions& options, const std::optional<RecordingPreset>& preset) {
  if (!options.name_shown.empty()) {
    throw InputError("import: --name is for one file; there are " +
                     std::to_string(options.files.size()));
  }
  std::vector<InputRecording> recordings;
  std::string problems;
  for (std::size_t n = 0; n < options.files.size(); ++n) {
    const std::filesystem::path& file = options.files[n];
    const auto twin =
        std::find_if(options.files.begin(), options.files.begin() + std::ssize(recordings),
                     [&](const auto& one) { return one.stem() == file.stem(); });
    try {
      if (twin != options.files.begin() + std::ssize(recordings)) {
        throw InputError(file.string() + ": the same name as " + twin->string() +
                         "; each is written as NAME.h5");
      }
      recordings.push_back(read_one(options, file, preset));
    } catch (const InputError& error) {
      problems += (problems.empty() ? "" : "\n") + std::string(error.what());
      recordings.emplace_back();
    }
  }
  if (!problems.empty()) { throw InputError(problems); }
  std::vector<std::string> names;
  for (const std::filesystem::path& file : options.files) {
    names.push_back(file.stem().string() + ".h5");
  }
  const std::filesystem::path folder = options.make_folder(names);
  for (const std::string& name : names) {
    const std::filesystem::path file = folder / name;
    if (!std::filesystem::exists(file)) { continue; }
    const std::string bytes = io::read_bytes(file, std::numeric_limits<std::size_t>::max());
    if (io::ends_with_seal(bytes)) { continue; }
    throw InputError(file.string() + ": exists and was not written by palpate; another --out");
  }
  const io::WholeWrite whole;
  for (std::size_t n = 0; n < recordings.size(); ++n) {
    const std::filesystem::path file = folder / (options.files[n].stem().string() + ".h5");
    io::write_recording_hdf5(file, recordings[n].recording);
    if (!options.quiet) {
      std::printf("%s\n", io::printable(options.files[n].string()).c_str());
      tell(recordings[n]);
    }
    if (!options.quiet || n + 1 == recordings.size()) {
      std::printf("%s\n", io::printable(file.string()).c_str());
    }
  }
  return done;
}

int run_import(const ImportOptions& options) {
  std::optional<RecordingPreset> preset;
  if (!options.preset.empty()) { preset = preset_named(options.preset); }
  if (options.files.size() > 1) { return import_all(options, preset); }
  const InputRecording read = read_one(options, options.files.front(), preset);
  const std::filesystem::path folder = options.make_folder({"recording.csv", "recording.h5"});
  const io::WholeWrite whole;
  io::write_recording_hdf5(folder / "recording.h5", read.recording);
  io::write_recording_csv(folder / "recording.csv", read.recording);
  if (!options.quiet) {
    tell(read);
    const std::string file = (folder / "recording.h5").string();
    std::printf("%s\nnext: palpate compare %s --scene SCENE.toml\n", io::printable(file).c_str(),
                io::printable(in_shell_quotes(file)).c_str());
  }
  std::printf("%s\n", io::printable((folder / "recording.csv").string()).c_str());
  return done;
}

struct ReconstructOptions : CommonOptions {
  std::filesystem::path table{};
};

int run_reconstruct(const ReconstructOptions& options) {
  const std::vector<Recording> recordings =
      reconstructed_recordings(io::read_published_values(options.table));
  std::vector<std::string> names;
  for (const Recording& recording : recordings) { names.push_back(recording.name + ".h5"); }
  const std::filesystem::path folder = options.make_folder(names);
  const io::WholeWrite whole;
  for (const Recording& recording : recordings) {
    io::write_recording_hdf5(folder / (recording.name + ".h5"), recording);
  }
  std::printf("%zu recordings, reconstructed from published summary values: %s\n",
              recordings.size(), io::printable(folder.string()).c_str());
  return done;
}

}  // namespace

void add_import(Program& program) {
  const auto [command, options] = add_command(
      program, "import", "convert recordings of any supported format to recording.h5", run_import);
  add_value(
      command, "file", options.files, "FILE",
      "CSV, recording.h5, MATLAB 7.3, or bytes of the raw link; several are written as NAME.h5")
      ->required();
  add_value(command, "--preset", options.preset, "NAME",
            "dialect of a rig: needle-insertion-app, or a description NAME.json");
  command.add_option("--format", options.format, "auto (by content), csv, raw or hdf5 [auto]");
  add_value(
      command, "--column", options.columns, "NAME=ROLE",
      "content of a column: time_ms, pressure_kPa, depth_mm, path_mm, force_N, ignore; repeatable");
  const CLI::Validator positive = number_range(1e-12, 1e12);
  add_value(command, "--rate", options.sample_rate, "HZ",
            "samples per second, for a file without time")
      ->check(positive);
  add_value(command, "--bmi", options.body_mass_index, "BMI", "body mass index, kg/m^2")
      ->check(number_range(5.0, 250.0));
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
      "role from --column or --preset. Writes recording.h5 and recording.csv, of several files "
      "NAME.h5\n"
      "each. docs/recordings.md shows how.");
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
