// SPDX-License-Identifier: MIT
#pragma once
/// Recordings from files of any supported format: recording.h5, MATLAB, CSV or raw link bytes.

#include <optional>

#include "device/pressure_link/frame.hpp"
#include "fixtures/io/recording_file.hpp"

namespace palpate {

enum class RecordingFormat { automatic, csv, raw, hdf5 };
std::string_view name_of(RecordingFormat format);  ///< "auto", "csv", "raw", "hdf5"

struct InputRecording : io::ReadRecording {
  RecordingFormat format = RecordingFormat::automatic;  ///< format of the file that was read
  std::optional<device::pressure_link::ReaderCounts>
      frames{};  ///< frame counts of the raw link; empty for other formats
};

/// Detects the format from the file content, not from its name: HDF5 by its signature, the raw link
/// by frames in the first 64 KiB, otherwise CSV. Throws InputError.
RecordingFormat format_of(const std::filesystem::path& path);

/// Reads a recording. Throws InputError with one line per problem.
InputRecording read_any_recording(const std::filesystem::path& path,
                                  RecordingFormat format = RecordingFormat::automatic,
                                  const io::ReadOptions& options = {});

}  // namespace palpate
