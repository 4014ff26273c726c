// SPDX-License-Identifier: MIT
#pragma once
/// report.html of `palpate run`.

#include <filesystem>
#include <map>
#include <string>

#include "reports/cli/loaded_scene.hpp"
#include "reports/cli/palpation.hpp"
#include "validation/rollout.hpp"

namespace palpate::cli {

struct RunPage {
  const LoadedScene& loaded;
  const Run& run;
  const Palpation& palpation;
  const std::map<std::string, std::string>& provenance;
  std::string no_view{};  ///< why the page has no view in three dimensions; empty: it has one
};

/// Throws DrawingError.
void write_run_report(const std::filesystem::path& folder, const RunPage& page);

}  // namespace palpate::cli
