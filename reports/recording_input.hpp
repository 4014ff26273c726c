// SPDX-License-Identifier: MIT
#pragma once
/// A recording from a file of any kind: recording.h5, MATLAB, CSV or the bytes of the raw link.

#include <optional>

#include "device/pressure_link/frame.hpp"
#include "fixtures/io/recording_file.hpp"

namespace palpate {

enum class RecordingFormat { automatic, csv, raw, hdf5 };
std::string_view name_of(RecordingFormat format);  ///< "auto", "csv", "raw", "hdf5"

struct InputRecording : io::ReadRecording {
  RecordingFormat format = RecordingFormat::automatic;          ///< that it was read as
  std::optional<device::pressure_link::ReaderCounts> frames{};  ///< of the raw link
};

/// By content, not by name: HDF5 by its signature, the raw link by frames among its first 64 KiB,
/// CSV what is left. Throws InputError.
RecordingFormat format_of(const std::filesystem::path& path);

/// Throws InputError with one line per problem.
InputRecording read_any_recording(const std::filesystem::path& path,
                                  RecordingFormat format = RecordingFormat::automatic,
                                  const io::ReadOptions& options = {});

}  // namespace palpate
