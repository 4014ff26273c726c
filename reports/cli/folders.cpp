// SPDX-License-Identifier: MIT

#include "reports/cli/folders.hpp"

#include <cstdlib>
#include <memory>

#include "fixtures/io/reference_store.hpp"

std::filesystem::path palpate::cli::source_folder() { return PALPATE_SOURCE_DIR; }

namespace palpate::cli {

namespace {

io::ReferenceStore::Entry entry_of(const Trace& solution) {
  io::ReferenceStore::Entry entry;
  entry.matrices["time_s"] = Eigen::Map<const Eigen::VectorXd>(
      solution.time.data(), static_cast<Eigen::Index>(solution.time.size()));
  entry.matrices["position_m"] = solution.position;
  entry.matrices["velocity_m_per_s"] = solution.velocity;
  entry.texts["solver"] = solution.method;
  entry.texts["version"] = solution.version;
  entry.numbers["relative_tolerance"] = solution.relative_tolerance;
  entry.numbers["steps"] = static_cast<double>(solution.steps);
  entry.numbers["evaluations"] = static_cast<double>(solution.evaluations);
  entry.numbers["seconds"] = solution.seconds;
  return entry;
}

Trace solution_of(const io::ReferenceStore::Entry& entry) {
  Trace solution;
  const Eigen::MatrixXd& time = entry.matrices.at("time_s");
  solution.time.assign(time.data(), time.data() + time.size());
  solution.position = entry.matrices.at("position_m");
  solution.velocity = entry.matrices.at("velocity_m_per_s");
  solution.method = entry.texts.at("solver");
  solution.version = entry.texts.at("version");
  solution.relative_tolerance = entry.numbers.at("relative_tolerance");
  solution.steps = static_cast<long>(entry.numbers.at("steps"));
  solution.evaluations = static_cast<long>(entry.numbers.at("evaluations"));
  solution.seconds = entry.numbers.at("seconds");
  return solution;
}

}  // namespace

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
  const auto store = std::make_shared<io::ReferenceStore>(folder);
  reference::Cache cache;
  cache.load = [store](const std::string& key) -> std::optional<Trace> {
    const auto entry = store->load(key);
    if (!entry) { return std::nullopt; }
    try {
      return solution_of(*entry);
    } catch (const std::out_of_range&) {
      return std::nullopt;
    }  // of an older format: treated as absent
  };
  cache.save = [store](const std::string& key, const Trace& solution) {
    store->save(key, entry_of(solution));
  };
  return cache;
}

}  // namespace palpate::cli
