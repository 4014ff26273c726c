// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>

#include "reference/solution.hpp"

namespace palpate::cli {

/// Folder of the sources that this program was built from. It contains the shipped scenes.
std::filesystem::path source_folder();

// The kept references of reference::Cache, in a folder of HDF5 files.

/// $XDG_CACHE_HOME/palpate, or ~/.cache/palpate, or a folder beside the temporary files.
std::filesystem::path default_cache_folder();

reference::Cache cache_in(const std::filesystem::path& folder);

}  // namespace palpate::cli
