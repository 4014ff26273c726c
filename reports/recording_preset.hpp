// SPDX-License-Identifier: MIT
#pragma once
/// Descriptions of the dialect of a rig: which columns a file has, and how a recording is made of
/// them. A preset is a JSON file (docs/recordings.md); one is compiled in.

#include <filesystem>
#include <optional>
#include <string>

#include "fixtures/io/recording_file.hpp"
#include "model/problem/recording.hpp"

namespace palpate {

struct RecordingPreset {
  std::string name{};
  std::string source{};
  Recording::Kind kind = Recording::Kind::measured;
  io::ReadOptions read{};                ///< roles of the columns
  double force_factor = 1.0;             ///< -1 where a resisting force is negative
  std::size_t tare_samples = 0;          ///< first samples whose mean force is subtracted; 0: none
  std::optional<ContactRule> contact{};  ///< the depth begins at the contact; absent: as recorded
  std::size_t mean_samples = 1;  ///< samples of the running mean in which the contact is found
  /// Pattern of the names of files without extension, such as "{tissue}_{needle}". Group and
  /// subject are texts with these fields.
  std::string file_name{}, group{}, subject{};
};

/// Returns the preset of this name that is compiled in, or the one of a JSON file. Throws
/// InputError.
RecordingPreset preset_named(const std::string& name_or_file);

/// Parses the JSON of a preset; `place` begins the messages. Throws InputError.
RecordingPreset preset_from(const std::string& json, const std::string& place);

/// Applies a preset to the samples that were read from a file: kind, source, sign, tare, depth from
/// the contact, group and subject. The note of the recording states what was subtracted.
void apply(const RecordingPreset& preset, const std::filesystem::path& file,
           io::ReadRecording& read);

}  // namespace palpate
