// SPDX-License-Identifier: MIT
#pragma once
/// A baseline on disk (docs/gate.md): numbers, spreads and the ledger as JSON that a reviewer can read, the
/// samples of curves in an HDF5 file beside it, of the same name with .h5 for its ending.

#include <filesystem>

#include "validation/gate/baseline.hpp"

namespace palpate {

/// The curves first, then the file that names them, each under a temporary name. Throws InputError.
void write_baseline(const std::filesystem::path& path, const gate::Baseline& baseline);

/// Throws InputError where either file is missing, damaged or edited by hand, where one does not belong to the
/// other, or where a number in them is not finite.
gate::Baseline read_baseline(const std::filesystem::path& path);

/// Where the curves of a baseline are.
std::filesystem::path curves_of_baseline(const std::filesystem::path& path);

}  // namespace palpate
