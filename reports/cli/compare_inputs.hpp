// SPDX-License-Identifier: MIT
#pragma once
/// What `palpate compare` lays over each other: recordings from files or folders, and a simulated trace.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "reports/cli/commands.hpp"
#include "reports/cli/loaded_scene.hpp"
#include "reports/comparison_report.hpp"
#include "validation/rollout.hpp"

namespace palpate::cli {

/// Files, and of each folder its .h5 files in the order of names. Throws an InputError of one line per
/// problem.
std::vector<ComparedRecording> read_recordings(const std::vector<std::filesystem::path>& paths);

/// Throws InputError, also where it has no column of that name or no number in it.
ComparedSimulation read_simulation(const std::filesystem::path& trace, const std::string& column);

/// A scene made ready to run for as long as it says, and after a loss of resistance until the rule that finds
/// it can decide.
struct SceneRun {
  LoadedScene loaded;
  double rest = 6.0;  ///< [s] after the event
};
/// Throws InputError, also where the scene will have no column of that name.
SceneRun prepare_scene(const CompareOptions& options, const std::string& column, double rest);

struct SimulatedScene {
  ComparedSimulation simulation{};
  std::map<std::string, std::string> provenance{};
  bool interrupted = false;
};
SimulatedScene simulate_scene(SceneRun& scene, bool quiet);

}  // namespace palpate::cli
