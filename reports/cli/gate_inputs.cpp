// SPDX-License-Identifier: MIT
#include "reports/cli/gate_inputs.hpp"

#include <algorithm>

#include "model/dynamics/scene_check.hpp"
#include "reports/results_folder.hpp"
#include "reports/run_outcome.hpp"

namespace palpate::cli {

Results read_judged(const std::filesystem::path& folder) {
  if (!std::filesystem::is_directory(folder)) {
    throw InputError(folder.string() + ": is no folder; one that validate, bench or run wrote");
  }
  return is_run_folder(folder) ? read_run_folder(folder) : read_results_folder(folder);
}

std::vector<std::string> names_of(const std::vector<std::string>& patterns, const std::vector<std::string>& names) {
  std::vector<std::string> selected;
  for (const std::string& pattern : patterns) {
    const auto before = selected.size();
    for (const std::string& name : names) {
      const bool meant = name == pattern || name.starts_with(pattern + "/");
      if (meant && std::ranges::find(selected, name) == selected.end()) { selected.push_back(name); }
    }
    if (selected.size() == before) {
      throw InputError("--case " + pattern + ": selects nothing; a case or a group of the results or the baseline");
    }
  }
  return selected;
}

}  // namespace palpate::cli
