// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include <nlohmann/json.hpp>

#include "model/dynamics/skin.hpp"
#include "model/dynamics/tissue_grid.hpp"
#include "model/dynamics/voxel_tissue.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/loaded_scene.hpp"
#include "reports/cli/tool_inspection.hpp"
#include "reports/json_number.hpp"

namespace palpate::cli {

namespace {

using Json = nlohmann::ordered_json;

Json network_facts(const NetworkProblem& problem) {
  const SpringNetwork& network = problem.network();
  double least = std::numeric_limits<double>::infinity();
  double most = 0.0;
  for (const Spring& spring : network.springs) {
    least = std::min(least, spring.stiffness);
    most = std::max(most, spring.stiffness);
  }
  double mass = 0.0;
  for (Eigen::Index i = 0; i < network.node_count(); ++i) { mass += network.mass(i); }
  return {{"nodes", network.node_count()},
          {"springs", network.springs.size()},
          {"free_nodes", problem.free_nodes().size()},
          {"mass_kg", mass},
          {"stiffness_min_n_per_m", network.springs.empty() ? 0.0 : least},
          {"stiffness_max_n_per_m", most}};
}

Json oscillator_facts(const Oscillator& oscillator) {
  return {{"nodes", 1},
          {"springs", 1},
          {"free_nodes", 1},
          {"mass_kg", oscillator.mass},
          {"stiffness_min_n_per_m", oscillator.stiffness},
          {"stiffness_max_n_per_m", oscillator.stiffness}};
}

/// Volumes by surfaces and by voxels, body by body; what was read of an image.
Json voxel_facts(const VoxelTissue& tissue) {
  Json facts = Json::object();
  if (tissue.image) {
    const ImageFacts& image = *tissue.image;
    facts["image"] = {{"format", image.format},
                      {"pixels", image.pixels},
                      {"spacing_m", {image.spacing.x(), image.spacing.y(), image.spacing.z()}},
                      {"intensity_range", {image.range.x(), image.range.y()}},
                      {"weighting", image.weighting},
                      {"labelled_nodes", image.labelled_nodes}};
  }
  double mesh = 0.0;
  double voxels = 0.0;
  for (const BodyFacts& body : tissue.bodies) {
    mesh += body.surface_volume;
    voxels += body.voxel_volume;
    facts["bodies"][body.name] = {{"material", body.material},
                                  {"mesh_m3", body.surface_volume},
                                  {"voxels_m3", body.voxel_volume},
                                  {"kept_voxels", body.kept_cells},
                                  {"parts", body.parts}};
  }
  if (!tissue.bodies.empty()) { facts["volume_m3"] = {{"mesh", mesh}, {"voxels", voxels}}; }
  return facts;
}

/// Where the surface lies, and how much of a block of layers is beneath it.
Json skin_facts(const Scene& scene) {
  const TriangleSurface& surface = scene.tissue.skin->surface();
  const auto list = [](const Eigen::Vector3d& v) { return std::vector<double>(v.begin(), v.end()); };
  Json facts{{"faces", surface.triangle.size()},
             {"min_m", list(surface.vertex.rowwise().minCoeff())},
             {"max_m", list(surface.vertex.rowwise().maxCoeff())}};
  if (layers_follow_skin(scene)) { facts["columns_covered"] = block_beneath_skin(scene).covered(); }
  return facts;
}

Json facts_of(const LoadedScene& loaded) {
  const Simulation& simulation = loaded.simulation;
  const StepPlan& plan = simulation.plan();
  const auto* network = dynamic_cast<const NetworkProblem*>(&simulation.problem());
  Json facts{{"title", loaded.file.scene.title}};
  facts.update(network != nullptr ? network_facts(*network)
                                  : oscillator_facts(loaded.file.scene.tissue.oscillator));
  if (network != nullptr) { facts.update(tool_inspection(loaded.file.scene, *network)); }
  if (loaded.file.scene.tissue.skin) { facts["skin"] = skin_facts(loaded.file.scene); }
  if (const auto& voxels = loaded.file.scene.tissue.voxels) { facts.update(voxel_facts(*voxels)); }
  facts["omega_max_rad_per_s"] = plan.bounds.omega_estimate;
  facts["omega_upper_bound_rad_per_s"] = plan.bounds.omega_upper;
  facts["damping_upper_bound_per_s"] = plan.bounds.damping_upper;
  Json stable = Json::object();
  for (const auto& [name, step] : plan.stable_step) { stable[name] = finite_or_null(step); }
  facts["stable_step_s"] = stable;
  facts["integrator"] = plan.integrator->name;
  facts["integrator_reason"] = plan.integrator_reason;
  facts["substeps"] = plan.substeps;
  facts["substeps_reason"] = plan.substeps_reason;
  facts["integrator_step_s"] = plan.h;
  facts["ticks"] = simulation.tick_count();
  facts["kernel"] = plan.kernel;
  facts["skipped"] = plan.skipped;
  facts["warnings"] = plan.warnings;
  facts["zero_length_springs"] = simulation.zero_length_springs();
  facts["memory_bytes"] = simulation.memory_bytes();
  return facts;
}

std::string text_of(const Json& value) {
  if (value.is_null()) { return "no limit"; }
  if (value.is_string()) { return value.get<std::string>(); }
  if (value.is_number_float()) {
    std::array<char, 32> buffer{};
    std::snprintf(buffer.data(), buffer.size(), "%.6g", value.get<double>());
    return buffer.data();
  }
  return value.dump();
}

void print(const Json& facts) {
  for (const auto& [name, value] : facts.items()) {
    if (name == "tool") {
      print_tool(value);
      continue;
    }
    if (name == "static_compliance_m_per_n" && value.is_null()) { continue; }  // its reason follows
    if (value.is_object() || value.is_array()) {
      std::printf("%s\n", name.c_str());
      for (const auto& [key, item] : value.items()) {
        std::printf("  %s%s\n", value.is_object() ? (key + ": ").c_str() : "", text_of(item).c_str());
      }
      continue;
    }
    std::printf("%-28s %s\n", name.c_str(), text_of(value).c_str());
  }
}

}  // namespace

int inspect(const InspectOptions& options) {
  const LoadedScene loaded = load_scene(options.scene, options, options.no_skip);
  const Json facts = facts_of(loaded);
  if (options.json) {
    std::printf("%s\n", facts.dump(2).c_str());
  } else {
    print(facts);
  }
  return done;
}

}  // namespace palpate::cli
