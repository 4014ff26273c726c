// SPDX-License-Identifier: MIT

#include "reports/cli/loaded_scene.hpp"

#include <chrono>
#include <cstdio>
#include <stdexcept>
#include <unistd.h>

#include "fixtures/io/csv_file.hpp"
#include "model/problem/input_error.hpp"
#include "model/tissue/voxel_tissue.hpp"

namespace palpate::cli {

namespace {

std::string known_integrators() {
  std::string names = "\"auto\"";
  for (const IntegratorInfo* info : integrators()) {
    names += ", \"" + std::string(info->name) + "\"";
  }
  return names;
}

ModelSubject loaded_model(const io::SceneFile& file, bool no_skip, double spare) {
  const std::string& name = file.scene.simulation.integrator;
  if (name != "auto" && find_integrator(name) == nullptr) {
    throw InputError(file.where("simulation.integrator") + ": unknown integrator \"" +
                     io::shown(name) + "\"; must be one of " + known_integrators());
  }
  try {
    Scene scene = file.scene;
    scene.simulation.duration += spare;
    ModelSubject subject;
    subject.load(scene, !no_skip);
    return subject;
  } catch (const std::invalid_argument& problem) {
    throw InputError(file.where("simulation.integrator") + ": " + problem.what());
  }
}

}  // namespace

std::vector<std::string> LoadedScene::warnings() const {
  std::vector<std::string> all = simulation().plan().warnings;
  const auto& voxels = file.scene.tissue.voxels;
  if (voxels == nullptr || !voxels->image) { return all; }
  for (const int label : voxels->image->unused_labels) {
    all.push_back("no node has label " + std::to_string(label) + " of tissue.mri.materials");
  }
  return all;
}

LoadedScene load_scene(const std::filesystem::path& path, const CommonOptions& options,
                       bool no_skip, double spare) {
  const auto begin = std::chrono::steady_clock::now();
  io::SceneFile file = io::read_scene(path, options.overrides);
  ModelSubject subject = loaded_model(file, no_skip, spare);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return {std::move(file), std::move(subject), seconds};
}

std::unique_ptr<Subject> foreign_subject(const SubjectChoice& choice, const LoadedScene& loaded,
                                         double spare) {
  if (!choice.foreign()) { return nullptr; }
  const std::string file = loaded.file.inputs.front().string();
  const NetworkProblem* network = loaded.network();
  if (network == nullptr) {
    throw InputError(file + ": --subject: an oscillator is not tissue; a network");
  }
  std::unique_ptr<Subject> subject =
      make_subject(choice, std::make_shared<const io::SceneFile>(loaded.file));
  Scene scene = loaded.file.scene;
  scene.simulation.duration += spare;
  try {
    subject->load(scene, network->network(), true);
  } catch (const CannotDo& problem) {
    throw InputError(file + ": --subject " + choice.subject + ": " + problem.what());
  }
  return subject;
}

RunControl run_control(bool quiet) {
  RunControl control{.stop = &interrupted};
  if (!quiet && isatty(STDERR_FILENO) != 0) {
    control.progress = [](double share) { std::fprintf(stderr, "\r%3.0f %%", 100.0 * share); };
  }
  return control;
}

std::map<std::string, std::string> scene_provenance(const LoadedScene& loaded) {
  std::map<std::string, std::string> provenance = build_provenance();
  provenance["scene"] = loaded.file.text;
  std::string overrides;
  for (const std::string& each : loaded.file.overrides) { overrides += each + "\n"; }
  if (!overrides.empty()) { provenance["overrides"] = overrides; }
  return provenance;
}

}  // namespace palpate::cli
