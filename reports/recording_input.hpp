// SPDX-License-Identifier: MIT
#pragma once
/// Recordings from files of any supported format: recording.h5, MATLAB, CSV or raw link bytes.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "device/pressure_link/frame.hpp"
#include "fixtures/io/csv_tables.hpp"
#include "fixtures/io/recording_file.hpp"
#include "model/problem/recording.hpp"

namespace palpate {

enum class RecordingFormat { automatic, csv, raw, hdf5 };
std::string_view name_of(RecordingFormat format);  ///< "auto", "csv", "raw", "hdf5"

struct InputRecording : io::ReadRecording {
  RecordingFormat format = RecordingFormat::automatic;  ///< format of the file that was read
  std::optional<device::pressure_link::ReaderCounts> frames{};  ///< only of the raw link
};

/// Detects the format from the file content, not from its name: HDF5 by its signature, the raw link
/// by frames in the first 64 KiB, otherwise CSV. Throws InputError.
RecordingFormat format_of(const std::filesystem::path& path);

/// Format with this name. Throws InputError that begins with the name of the option.
RecordingFormat format_named(const std::string& option, const std::string& name);

/// Reads a recording. Throws InputError with one line per problem.
InputRecording read_any_recording(const std::filesystem::path& path,
                                  RecordingFormat format = RecordingFormat::automatic,
                                  const io::ReadOptions& options = {});

/// Hash of the bytes of a file (content_hash.hpp).
std::string hash_of_file(const std::filesystem::path& file);

struct RecordingFile {
  std::filesystem::path file{};
  std::string hash{};  ///< hash of the file contents
  InputRecording input{};
};

/// Reads files, and the .h5 files of folders in the order of their names. A recording without a
/// name has that of its file. `check` may refuse a recording by an InputError. Throws an InputError
/// with one line per problem, also for a file with the same bytes as another.
std::vector<RecordingFile> read_recordings(
    const std::vector<std::filesystem::path>& paths,
    const std::function<void(const RecordingFile&)>& check = [](const RecordingFile&) {});

// Recordings that are reconstructed from published summary values. No public measurements exist.

/// Returns the reconstructed recordings. Each group has five subjects per technique:
/// - P01-P04: women in labour, grouped by BMI, thumb on the plunger. Mean and SD of the peaks equal
///   the table exactly; BMI affects depth only through the fat layer.
/// - P05, P06: porcine specimens, thumb. Peaks are spaced evenly over the published range; there is
///   no depth.
/// - P07-P09: five continuous recordings with a pump, a different regime without depth.
/// Output is deterministic up to rounding in the last digit.
std::vector<Recording> reconstructed_recordings(const io::PublishedValues& table);

}  // namespace palpate
