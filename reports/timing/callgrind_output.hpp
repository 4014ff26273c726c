// SPDX-License-Identifier: MIT
#pragma once
/// What callgrind writes: one file for each part of a run (the format's description is callgrind-format.html of
/// the Valgrind manual).

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace palpate::timing {

struct CallgrindPart {
  int number = 0;
  std::string creator{};  ///< "callgrind-3.19.0"
  std::string label{};    ///< that the program gave; empty: not asked for by the program
  std::int64_t instructions = 0;
};

/// Throws InputError, naming the file, when it is cut short or counts anything but instructions.
CallgrindPart part_from(const std::string& text, const std::string& file);

/// The parts in a folder that the program asked for, in that order.
std::vector<CallgrindPart> labelled_parts(const std::filesystem::path& folder);

}  // namespace palpate::timing
