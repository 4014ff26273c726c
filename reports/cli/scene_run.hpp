// SPDX-License-Identifier: MIT
#pragma once
/// What every command that simulates a scene shares.

#include <map>
#include <string>

#include "reports/cli/loaded_scene.hpp"
#include "validation/rollout.hpp"

namespace palpate::cli {

/// Ctrl-C ends it; progress goes to standard error where that is a terminal.
RollOutOptions roll_out_options(const LoadedScene& loaded, bool quiet);

/// build_provenance() with the text of the scene and what the command line overrode in it.
std::map<std::string, std::string> scene_provenance(const LoadedScene& loaded);

}  // namespace palpate::cli
