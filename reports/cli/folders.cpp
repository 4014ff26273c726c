// SPDX-License-Identifier: MIT

#include "reports/cli/folders.hpp"

#include <cstdlib>

#include "fixtures/io/reference_store.hpp"

std::filesystem::path palpate::cli::source_folder() { return PALPATE_SOURCE_DIR; }

namespace palpate::cli {

std::filesystem::path default_cache_folder() {
  if (const char* folder = std::getenv("XDG_CACHE_HOME"); folder != nullptr && *folder != '\0') {
    return std::filesystem::path(folder) / "palpate";
  }
  if (const char* home = std::getenv("HOME"); home != nullptr && *home != '\0') {
    return std::filesystem::path(home) / ".cache" / "palpate";
  }
  return std::filesystem::temp_directory_path() / "palpate-cache";
}

reference::Cache cache_in(const std::filesystem::path& folder) {
  reference::Cache cache;
  cache.load = [folder](const std::string& key) { return io::load_reference(folder, key); };
  cache.save = [folder](const std::string& key, const Trace& solution) {
    io::save_reference(folder, key, solution);
  };
  return cache;
}

}  // namespace palpate::cli
