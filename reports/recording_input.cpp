// SPDX-License-Identifier: MIT

#include "reports/recording_input.hpp"

#include <algorithm>
#include <span>

#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/hdf5_file.hpp"
#include "fixtures/io/recording_file.hpp"
#include "model/problem/input_error.hpp"
#include "validation/comparison/link_recording.hpp"

namespace palpate {
namespace {

namespace link = device::pressure_link;

constexpr std::size_t first_look = 64 * 1024;
/// Size limit of a raw link file, with as many damaged bytes as sample bytes.
constexpr std::size_t most_raw_bytes = 2 * link::frame_bytes * io::most_samples;

std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

bool has_frames(const std::string& bytes) {
  link::FrameReader reader;
  for (const std::uint8_t byte : bytes_of(bytes)) {
    if (reader.take(byte)) { return true; }
  }
  return false;
}

/// Returns true for text: no control characters except white space.
bool is_text(std::string_view bytes) {
  return std::ranges::all_of(bytes, [](char c) {
    return static_cast<unsigned char>(c) >= ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f';
  });
}

void refuse_columns(const std::filesystem::path& path, const io::ReadOptions& options) {
  if (options.columns.empty() && !options.sample_rate) { return; }
  throw InputError(path.string() +
                   ": the raw link has neither columns nor another rate; --column and --rate are "
                   "for CSV and HDF5");
}

InputRecording read_raw(const std::filesystem::path& path, const io::ReadOptions& options) {
  refuse_columns(path, options);
  const std::string text = io::read_bytes(path, most_raw_bytes);
  LinkRecording heard = recording_of_link(bytes_of(text), io::most_samples);
  if (heard.counts.frames > static_cast<std::int64_t>(io::most_samples)) {
    io::refuse_length(path.string());
  }
  if (heard.counts.frames == 0) {
    throw InputError(path.string() +
                     ": no frame of the raw link; frames of 8 bytes that begin with A5 5A and pass "
                     "their checksum are needed");
  }
  InputRecording read;
  read.recording = std::move(heard.recording);
  read.frames = heard.counts;
  io::check_usable(read.recording, path);
  io::add_warnings(read);
  if (heard.counts.gaps > 0) {
    read.warnings.emplace_back(
        "sequence numbers wrap at 256: a gap of more than 2.1 s looks shorter by multiples of "
        "that");
  }
  if (heard.counts.battery_low > 0) {
    read.warnings.push_back("battery low in " + std::to_string(heard.counts.battery_low) +
                            " frames");
  }
  return read;
}

std::vector<std::filesystem::path> files_in(const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) { return {path}; }
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(path)) {
    if (entry.path().extension() == ".h5") { files.push_back(entry.path()); }
  }
  if (files.empty()) {
    throw InputError(path.string() + ": has no .h5 file; a folder of recordings has some");
  }
  std::ranges::sort(files);
  return files;
}

}  // namespace

std::string_view name_of(RecordingFormat format) {
  switch (format) {
    case RecordingFormat::csv: return "csv";
    case RecordingFormat::raw: return "raw";
    case RecordingFormat::hdf5: return "hdf5";
    case RecordingFormat::automatic: break;
  }
  return "auto";
}

RecordingFormat format_of(const std::filesystem::path& path) {
  const std::string beginning = io::read_beginning(path, first_look);
  if (beginning.empty()) { throw InputError(path.string() + ": is empty; a recording is needed"); }
  if (io::is_hdf5(beginning)) { return RecordingFormat::hdf5; }
  if (beginning.starts_with("MATLAB 5.0")) {
    throw InputError(path.string() + ": is a MATLAB file of an older kind; save it with -v7.3");
  }
  if (has_frames(beginning)) { return RecordingFormat::raw; }
  if (is_text(beginning)) { return RecordingFormat::csv; }
  throw InputError(path.string() +
                   ": is no text, no HDF5 and has no frames of the raw link; one of these is "
                   "needed (CSV as UTF-8)");
}

InputRecording read_any_recording(const std::filesystem::path& path, RecordingFormat format,
                                  const io::ReadOptions& options) {
  if (format == RecordingFormat::automatic) { format = format_of(path); }
  InputRecording read;
  if (format == RecordingFormat::raw) {
    read = read_raw(path, options);
  } else {
    static_cast<io::ReadRecording&>(read) = format == RecordingFormat::hdf5
                                                ? io::read_recording_hdf5(path, options)
                                                : io::read_recording_csv(path, options);
  }
  read.format = format;
  return read;
}

RecordingFormat format_named(const std::string& option, const std::string& name) {
  for (const RecordingFormat format : {RecordingFormat::automatic, RecordingFormat::csv,
                                       RecordingFormat::raw, RecordingFormat::hdf5}) {
    if (name == name_of(format)) { return format; }
  }
  throw InputError(option + " " + name + "; must be auto, csv, raw or hdf5");
}

std::string hash_of_file(const std::filesystem::path& file) {
  constexpr std::size_t most_bytes = std::size_t{4} << 30U;
  return io::content_hash(io::read_bytes(file, most_bytes));
}

std::vector<RecordingFile> read_recordings(const std::vector<std::filesystem::path>& paths,
                                           const std::function<void(const RecordingFile&)>& check) {
  std::vector<RecordingFile> recordings;
  std::string problems;
  const auto gather = [&problems](auto&& read) {
    try {
      read();
    } catch (const InputError& error) {
      problems += (problems.empty() ? "" : "\n") + std::string(error.what());
    }
  };
  const auto read_one = [&](const std::filesystem::path& file) {
    RecordingFile one{.file = file, .hash = {}, .input = read_any_recording(file)};
    one.hash = hash_of_file(file);
    const auto twin = std::ranges::find(recordings, one.hash, &RecordingFile::hash);
    if (twin != recordings.end()) {
      throw InputError(file.string() + ": the same bytes as " + twin->file.string() +
                       "; every recording once");
    }
    if (one.input.recording.name.empty()) { one.input.recording.name = file.stem().string(); }
    check(one);
    recordings.push_back(std::move(one));
  };
  for (const std::filesystem::path& path : paths) {
    gather([&] {
      for (const auto& file : files_in(path)) {
        gather([&] { read_one(file); });
      }
    });
  }
  if (!problems.empty()) { throw InputError(problems); }
  return recordings;
}

}  // namespace palpate
