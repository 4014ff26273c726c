// SPDX-License-Identifier: MIT
#pragma once
/// Recordings from files of any supported format: recording.h5, MATLAB, CSV or raw link bytes.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "device/pressure_link/frame.hpp"
#include "fixtures/io/recording_file.hpp"

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

}  // namespace palpate
