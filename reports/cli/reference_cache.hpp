// SPDX-License-Identifier: MIT
#pragma once
/// The kept references of reference::Cache, in a folder of HDF5 files.

#include <filesystem>

#include "reference/cache.hpp"

namespace palpate::cli {

/// $XDG_CACHE_HOME/palpate, or ~/.cache/palpate, or a folder beside the temporary files.
std::filesystem::path default_cache_folder();

reference::Cache cache_in(const std::filesystem::path& folder);

}  // namespace palpate::cli
