// SPDX-License-Identifier: MIT
#pragma once
/// summary.json of a run, and the facts its report shows.

#include <string>

#include "reports/cli/loaded_scene.hpp"
#include "validation/rollout.hpp"

namespace palpate::cli {

std::string summary_json(const LoadedScene& loaded, const Run& run);

}  // namespace palpate::cli
