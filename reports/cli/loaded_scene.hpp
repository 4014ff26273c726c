// SPDX-License-Identifier: MIT
#pragma once
/// Scene file after reading and checking, with its simulation.

#include <map>
#include <optional>
#include <string>

#include "fixtures/io/scene_file.hpp"
#include "model/stepping/simulation.hpp"
#include "reports/cli/commands.hpp"
#include "validation/roll_out.hpp"

namespace palpate::cli {

struct LoadedScene {
  io::SceneFile file;
  ModelSubject subject;  ///< simulation subject with the scene loaded

  [[nodiscard]] const Simulation& simulation() const { return subject.simulation(); }
  /// Returns nullptr for an oscillator.
  [[nodiscard]] const NetworkProblem* network() const {
    return dynamic_cast<const NetworkProblem*>(&simulation().problem());
  }
  /// Returns the warnings of the plan, and of labels of an image that no node has.
  [[nodiscard]] std::vector<std::string> warnings() const;
  double load_seconds = 0.0;
};

/// Loads a scene. Throws InputError, also for an integrator that is unknown or does not fit the
/// scene. The simulation can continue for `spare` [s] after the duration of the scene.
LoadedScene load_scene(const std::filesystem::path& path, const CommonOptions& options,
                       bool no_skip, double spare = 0.0);

/// Loads the scene into another simulator than the model, with `spare` [s] after its duration;
/// nullptr if the model is the subject. Throws InputError if the simulator cannot represent it.
std::unique_ptr<Subject> foreign_subject(const SubjectChoice& choice, const LoadedScene& loaded,
                                         double spare = 0.0);

/// Run control that stops on Ctrl-C and prints progress to standard error if it is a terminal.
RunControl run_control(bool quiet);

/// Result of build_provenance(), extended with the scene text and the command line overrides.
std::map<std::string, std::string> scene_provenance(const LoadedScene& loaded);

/// Static compliance of the tissue at the tool [m/N]. Empty without a tool, for too many nodes and
/// for tissue that can move freely.
std::optional<double> tool_compliance(const Scene& scene, const NetworkProblem& problem);

}  // namespace palpate::cli
