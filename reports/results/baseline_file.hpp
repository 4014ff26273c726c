// SPDX-License-Identifier: MIT
#pragma once
/// Baseline on disk (docs/gate.md). Numbers, spreads and the ledger are readable JSON; the samples
/// of curves are in an HDF5 file with the same name and the ending .h5.

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "validation/gate/baseline.hpp"

namespace palpate {

/// Writes a baseline. Both files are written under temporary names and renamed, the curves first.
/// Throws InputError.
void write_baseline(const std::filesystem::path& path, const gate::Baseline& baseline);

/// Reads a baseline. Throws InputError if either file is missing, damaged or edited by hand, if the
/// files do not match, or if a number is not finite.
gate::Baseline read_baseline(const std::filesystem::path& path);

/// Damages baseline and results files in one way at a time. Returns each damage with the resulting
/// error message; the message is empty if the damage was not detected. Works in its own temporary
/// folder. Throws InputError if the folder cannot be created.
std::vector<std::pair<std::string, std::string>> try_damaged_files();

}  // namespace palpate
