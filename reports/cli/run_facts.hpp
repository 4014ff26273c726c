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

/// Throws DrawingError.
void write_run_report(const std::filesystem::path& folder, const LoadedScene& loaded,
                      const Run& run, const Palpation& palpation,
                      const std::map<std::string, std::string>& provenance);

}  // namespace palpate::cli
