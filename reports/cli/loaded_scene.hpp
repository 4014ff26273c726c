// SPDX-License-Identifier: MIT
#pragma once
/// A scene file read, checked and ready to run.

#include <map>
#include <string>

#include "fixtures/io/scene_file.hpp"
#include "model/stepping/simulation.hpp"
#include "reports/cli/commands.hpp"
#include "validation/roll_out.hpp"

namespace palpate::cli {

struct LoadedScene {
  io::SceneFile file;
  ModelSubject subject;  ///< with the scene loaded

  [[nodiscard]] const Simulation& simulation() const { return subject.simulation(); }
  double load_seconds = 0.0;
};

/// Throws InputError, also for an integrator that is unknown or does not fit the scene. The
/// simulation may go on for `spare` [s] after the scene's duration.
LoadedScene load_scene(const std::filesystem::path& path, const CommonOptions& options,
                       bool no_skip, double spare = 0.0);

/// The folder, made if need be. Throws InputError when it cannot be.
std::filesystem::path make_folder(const std::filesystem::path& folder);

// What every command that simulates a scene shares.

/// Ctrl-C ends it; progress goes to standard error where that is a terminal.
RunControl run_control(bool quiet);

/// build_provenance() with the text of the scene and what the command line overrode in it.
std::map<std::string, std::string> scene_provenance(const LoadedScene& loaded);

}  // namespace palpate::cli
