// SPDX-License-Identifier: MIT
#pragma once
/// A baseline on disk (docs/gate.md): numbers, spreads and the ledger as JSON that a reviewer can
/// read, the samples of curves in an HDF5 file beside it, of the same name with .h5 for its ending.

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "validation/gate/baseline.hpp"

namespace palpate {

/// The curves first, then the file that names them, each under a temporary name. Throws InputError.
void write_baseline(const std::filesystem::path& path, const gate::Baseline& baseline);

/// Throws InputError where either file is missing, damaged or edited by hand, where one does not
/// belong to the other, or where a number in them is not finite.
gate::Baseline read_baseline(const std::filesystem::path& path);

/// Where the curves of a baseline are.
std::filesystem::path curves_of_baseline(const std::filesystem::path& path);

// Baselines and results on disk, damaged one way at a time, to see that none is taken for sound.

/// What was done to the files, and the message that refused them; empty where they were taken.
/// Works in a temporary folder of its own. Throws InputError where that cannot be made.
std::vector<std::pair<std::string, std::string>> try_damaged_files();

}  // namespace palpate
