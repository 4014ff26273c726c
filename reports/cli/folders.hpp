// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "reference/solution.hpp"

namespace palpate::cli {

/// Source folder that this program was built from. It contains the shipped scenes.
std::filesystem::path source_folder();

// Cache of reference solutions (reference::Cache) in a folder of HDF5 files.

/// Returns $XDG_CACHE_HOME/palpate, else ~/.cache/palpate, else a folder beside the temporary
/// files.
std::filesystem::path default_cache_folder();

reference::Cache cache_in(const std::filesystem::path& folder);

}  // namespace palpate::cli
