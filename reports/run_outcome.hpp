// SPDX-License-Identifier: MIT
#pragma once
/// What `palpate run` left in a folder, as a case that a gate can hold against another run of the scene.

#include <filesystem>

#include "reports/results.hpp"

namespace palpate {

/// Whether a folder holds a run, and no results.json.
bool is_run_folder(const std::filesystem::path& folder);

/// One outcome, "run": facts, energies and events as quantities, every column of the trace as a figure over
/// time, and how far every node has moved. A run that diverged or was cut short is an error. Throws InputError.
Results read_run_folder(const std::filesystem::path& folder);

}  // namespace palpate
