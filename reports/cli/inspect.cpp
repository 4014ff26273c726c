// SPDX-License-Identifier: MIT

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>

#include "fixtures/io/file_bytes.hpp"
#include "model/problem/needle_path.hpp"
#include "model/problem/scene_keys.hpp"
#include "model/tissue/skin.hpp"
#include "model/tissue/tissue_grid.hpp"
#include "model/tissue/voxel_tissue.hpp"
#include "reference/solution.hpp"
#include "reference/static_equilibrium.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/loaded_scene.hpp"
#include "reports/html/html_page.hpp"
#include "reports/results/results_json.hpp"

namespace palpate::cli {
namespace {

struct InspectOptions : CommonOptions {
  std::filesystem::path scene{};
  bool no_skip = false;
};

using Json = nlohmann::ordered_json;

std::string with(double value, const char* unit) { return plain_number(value, 6) + " " + unit; }
std::string millimetres(double value) { return with(mm * value, "mm"); }

template <class Value> std::string scene_word(Value value) {
  for (const auto& [word, candidate] : words(Value{})) {
    if (candidate == value) { return std::string(word); }
  }
  return {};
}

/// Gauge of a needle, if the diameter is a standard one.
std::optional<int> gauge_of(double diameter) {
  for (int gauge = 1; gauge < 40; ++gauge) {
    const std::optional<double> made = diameter_of_gauge(gauge);
    if (made && std::abs(*made - diameter) < 1e-9) { return gauge; }
  }
  return {};
}

std::vector<double> values_in(const Eigen::VectorXd& v) { return {v.begin(), v.end()}; }

std::string pushes(const Drive& drive) {
  const std::string rise =
      "the hand pushes with " + with(drive.force, "N") + ", risen in " + with(drive.rise, "s");
  const std::string steps =
      drive.technique == Drive::Technique::intermittent
          ? ", " + with(drive.push, "s") + " at a time with pauses of " + with(drive.pause, "s")
          : "";
  const std::string end =
      drive.withdraw_force > 0.0
          ? "; after " + with(drive.hold, "s") + " it pulls with " + with(drive.withdraw_force, "N")
          : "; it does not stop";
  return rise + steps + ", against " + with(drive.hand_viscosity, "N s/m") + " of its own" + end;
}

std::string advances(const Drive& drive) {
  const std::string speed = "advances at " + with(mm * drive.speed, "mm/s");
  const std::string steps = drive.technique == Drive::Technique::intermittent
                                ? ", " + millimetres(drive.advance) + " at a time with pauses of " +
                                      with(drive.pause, "s")
                                : "";
  if (!drive.depth) { return speed + steps + ", as long as the run lasts"; }
  const std::string end = drive.withdraw_speed > 0.0
                              ? ", holds for " + with(drive.hold, "s") + " and is withdrawn at " +
                                    with(mm * drive.withdraw_speed, "mm/s")
                              : " and stays there";
  return speed + steps + " to " + millimetres(*drive.depth) + end;
}

std::string drive_in_words(const Drive& drive) {
  if (drive.kind == Drive::Kind::recorded) { return "as the grip in " + drive.recording; }
  const std::string from =
      drive.from == 0.0 ? "from the skin" : "from " + millimetres(drive.from) + " along its line";
  const std::string who =
      drive.kind == Drive::Kind::falcon ? "as the hand on an emulated Falcon intends, " : "";
  return who + from + " at t = " + with(drive.start, "s") + ": " +
         (drive.kind == Drive::Kind::force ? pushes(drive) : advances(drive));
}

Json interval_json(const PathInterval& interval) {
  return object("label", interval.label, "begin_m", interval.begin, "end_m",
                finite_or_null(interval.end), "puncture_force_n",
                finite_or_null(interval.puncture_force), "cutting_force_n",
                finite_or_null(interval.cutting_force), "friction_n_per_m", interval.friction,
                "role", scene_word(interval.role));
}

Json needle_facts(const Needle& needle, const NeedlePath& path) {
  return object("kind", "needle", "gauge", gauge_of(needle.diameter), "diameter_m", needle.diameter,
                "entry_m", values_in(needle.entry), "direction", values_in(path.direction()),
                "mass_kg", needle.mass, "knots", path.knots().size(), "bone_at_m",
                finite_or_null(path.bone()), "line", list_of(path.intervals(), interval_json));
}

Json probe_facts(const Probe& probe, const NeedlePath& path) {
  const bool round = probe.shape == Probe::Shape::fingertip;
  return object("kind", "probe", "shape", scene_word(probe.shape), "size_m",
                values_in(probe.size.head(round ? 1 : 2)), "face", scene_word(probe.face),
                "tip_radius_m", probe.tip_radius ? Json(*probe.tip_radius) : Json(nullptr),
                "entry_m", values_in(probe.centre(0.0)), "mass_kg", probe.mass, "nodes_beneath",
                path.knots().front().count, "on", path.intervals().front().label);
}

/// c = w.K^-1 w at the first contact point (EQUATIONS.md, "Needle tip").
double static_compliance(const NeedlePath& path, const NetworkProblem& problem) {
  Eigen::VectorXd w = Eigen::VectorXd::Zero(problem.dof());
  for (const NeedlePath::Support& support : path.supports(path.knots().front())) {
    const Eigen::Index at = problem.coordinate(support.node);
    if (at >= 0) { w.segment<3>(at) += support.weight * path.direction(); }
  }
  if (w.isZero(0.0)) { return 0.0; }
  constexpr Eigen::Index quickly_factorised = 6000;  // for one right-hand side
  constexpr int most_rounds = 3000;
  return reference::StaticResponse(problem, quickly_factorised, most_rounds).compliance(w);
}

/// Returns false if the stiffness is singular but rounding hides it. A series chain of all springs,
/// each as soft as the softest, has the compliance `chain`; tissue does not exceed a thousand times
/// that value.
bool is_believable(double compliance, const NetworkProblem& problem) {
  const SpringNetwork& network = problem.network();
  const auto nodes = static_cast<std::size_t>(network.node_count());
  if (problem.free_nodes().size() == nodes) { return false; }  // no fixed node
  double least = std::numeric_limits<double>::infinity();
  for (const Spring& spring : network.springs) {
    if (spring.stiffness > 0.0) { least = std::min(least, spring.stiffness); }
  }
  const double chain = static_cast<double>(network.springs.size()) / least;
  return compliance >= 0.0 && compliance <= 1e3 * chain;
}

/// Static compliance at the tool, or the reason why there is none.
Json compliance_json(const NeedlePath& path, const NetworkProblem& problem) {
  const auto none = [](const std::string& reason) {
    return object("static_compliance_m_per_n", nullptr, "static_compliance_reason", reason);
  };
  if (problem.free_nodes().size() > most_implicit_nodes) {
    return none("not sought: a stiffness matrix of more than " +
                std::to_string(most_implicit_nodes) + " free nodes takes gigabytes");
  }
  try {
    const double compliance = static_compliance(path, problem);
    if (is_believable(compliance, problem)) {
      return object("static_compliance_m_per_n", compliance);
    }
  } catch (const reference::NotConverged& problem_of_solver) {
    return none(std::string("not found: ") + problem_of_solver.what());
  } catch (const reference::SolverError&) {}  // the stiffness is singular
  return none("infinite: the tissue can move freely");
}

std::string cell(const Json& value, double scale) {
  return value.is_null() ? "-" : plain_number(scale * value.get<double>(), 6);
}

void print_line(const Json& line) {
  std::printf("  %9s %9s %10s %13s  %-14s  %s\n", "from mm", "to mm", "cutting N", "friction N/m",
              "role", "layer");
  for (const Json& each : line) {
    std::printf("  %9s %9s %10s %13s  %-14s  %s\n", cell(each["begin_m"], mm).c_str(),
                cell(each["end_m"], mm).c_str(), cell(each["cutting_force_n"], 1.0).c_str(),
                cell(each["friction_n_per_m"], 1.0).c_str(),
                each["role"].get<std::string>().c_str(),
                io::printable(each["label"].get<std::string>()).c_str());
  }
}

/// Keys "tool", "static_compliance_m_per_n" and, if that is null, "static_compliance_reason". Empty
/// for a scene without a tool.
Json tool_inspection(const Scene& scene, const NetworkProblem& problem, const TipCompliance& tip) {
  Json facts = Json::object();
  if (!scene.needle && !scene.probe) { return facts; }
  const NeedlePath path(scene, problem.network());
  facts["tool"] =
      scene.needle ? needle_facts(*scene.needle, path) : probe_facts(*scene.probe, path);
  const Drive drive = scene.drive.value_or(Drive{});
  add_keys(facts["tool"], "drive", scene_word(drive.kind), "drive_in_words", drive_in_words(drive),
           "syringe", scene.syringe.has_value());
  facts.update(compliance_json(path, problem));
  const Json& compliance = facts["static_compliance_m_per_n"];
  if (compliance.is_null()) { return facts; }
  const double contact = tip.at(path.knots().front().depth);
  const double total = compliance.get<double>() + contact;
  facts["static_compliance_m_per_n"] = total;
  add_keys(facts, "contact_compliance_m_per_n", contact, "needle_stiffness_n_per_m",
           total > 0.0 ? Json(1.0 / total) : Json(nullptr));
  return facts;
}

/// Text of a value; `none` represents null.
std::string text_of(const Json& value, const char* none) {
  if (value.is_null()) { return none; }
  if (value.is_string()) { return value.get<std::string>(); }
  if (value.is_number_float()) { return plain_number(value.get<double>(), 6); }
  return value.dump();
}

/// Prints one key of "tool" per line, and the needle path as a table.
void print_tool(const Json& tool) {
  std::printf("tool\n");
  for (const auto& [name, value] : tool.items()) {
    if (name == "line") { continue; }
    std::printf("  %-16s %s\n", name.c_str(), io::printable(text_of(value, "none")).c_str());
  }
  if (tool.contains("line")) { print_line(tool["line"]); }
}

/// Prints objects with the same keys as a table with a column for each key.
void print_rows(const Json& rows) {
  std::vector<std::vector<std::string>> table(1);
  for (const auto& [key, value] : rows.front().items()) { table.front().push_back(key); }
  for (const Json& row : rows) {
    std::vector<std::string>& cells = table.emplace_back();
    for (const auto& [key, value] : row.items()) {
      cells.push_back(io::printable(text_of(value, "none")));
    }
  }
  for (const std::vector<std::string>& cells : table) {
    std::string line;
    for (std::size_t n = 0; n < cells.size(); ++n) {
      std::size_t width = 0;
      for (const auto& each : table) { width = std::max(width, each[n].size()); }
      line +=
          "  " + cells[n] + std::string(n + 1 < cells.size() ? width - cells[n].size() : 0, ' ');
    }
    std::printf("%s\n", line.c_str());
  }
}

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
  return object("nodes", network.node_count(), "springs", network.springs.size(), "free_nodes",
                problem.free_nodes().size(), "mass_kg", mass, "stiffness_min_n_per_m",
                network.springs.empty() ? 0.0 : least, "stiffness_max_n_per_m", most);
}

Json oscillator_facts(const Oscillator& oscillator) {
  return object("nodes", 1, "springs", 1, "free_nodes", 1, "mass_kg", oscillator.mass,
                "stiffness_min_n_per_m", oscillator.stiffness, "stiffness_max_n_per_m",
                oscillator.stiffness);
}

/// Volumes by surfaces and by voxels for each body, and properties of the image that was read.
Json voxel_facts(const VoxelTissue& tissue) {
  Json facts = Json::object();
  if (tissue.image) {
    const ImageFacts& image = *tissue.image;
    facts["image"] = object("format", image.format, "pixels", image.pixels, "spacing_m",
                            values_in(image.spacing), "intensity_range", values_in(image.range),
                            "weighting", image.weighting, "labelled_nodes", image.labelled_nodes);
  }
  double mesh = 0.0;
  double voxels = 0.0;
  for (const BodyFacts& body : tissue.bodies) {
    mesh += body.surface_volume;
    voxels += body.voxel_volume;
    facts["bodies"][body.name] =
        object("material", body.material, "mesh_m3", body.surface_volume, "voxels_m3",
               body.voxel_volume, "kept_voxels", body.kept_cells, "parts", body.parts);
  }
  if (!tissue.bodies.empty()) { facts["volume_m3"] = {{"mesh", mesh}, {"voxels", voxels}}; }
  return facts;
}

/// Extent of the surface, and the fraction of a block of layers below it.
Json skin_facts(const Scene& scene) {
  const TriangleSurface& surface = scene.tissue.skin->surface();
  Json facts = object("faces", surface.triangle.size(), "min_m",
                      values_in(surface.vertex.rowwise().minCoeff()), "max_m",
                      values_in(surface.vertex.rowwise().maxCoeff()));
  if (layers_follow_skin(scene)) { facts["columns_covered"] = uneven_block(scene).covered; }
  return facts;
}

Json facts_of(const LoadedScene& loaded) {
  const Simulation& simulation = loaded.simulation();
  const StepPlan& plan = simulation.plan();
  const NetworkProblem* network = loaded.network();
  Json facts = object("title", loaded.file.scene.title);
  facts.update(network != nullptr ? network_facts(*network)
                                  : oscillator_facts(loaded.file.scene.tissue.oscillator));
  if (network != nullptr) { facts.update(tool_inspection(loaded.file.scene, *network, plan.tip)); }
  if (const auto layers = resolved_layers(loaded.file.scene); !layers.empty()) {
    facts["layers"] = list_of(layers, [](const ResolvedLayer& layer) {
      return object("tissue", layer.tissue, "thickness_m", layer.thickness, "cells", layer.cells);
    });
  }
  if (loaded.file.scene.tissue.skin) { facts["skin"] = skin_facts(loaded.file.scene); }
  if (const auto& voxels = loaded.file.scene.tissue.voxels) { facts.update(voxel_facts(*voxels)); }
  Json stable = Json::object();
  for (const auto& [name, step] : plan.stable_step) { stable[name] = finite_or_null(step); }
  add_keys(facts, "omega_max_rad_per_s", plan.bounds.omega_estimate, "omega_upper_bound_rad_per_s",
           plan.bounds.omega_upper, "damping_upper_bound_per_s", plan.bounds.damping_upper,
           "stable_step_s", stable, "integrator", plan.integrator->name, "integrator_reason",
           plan.integrator_reason, "substeps", plan.substeps, "substeps_reason",
           plan.substeps_reason, "integrator_step_s", plan.h, "ticks", simulation.tick_count(),
           "kernel", plan.kernel);
  if (!plan.far_reason.empty()) { facts["near_radius_reason"] = plan.far_reason; }
  add_keys(facts, "skipped", plan.skipped, "warnings", loaded.warnings(), "zero_length_springs",
           simulation.zero_length_springs(), "memory_bytes", simulation.memory_bytes());
  return facts;
}

void print(const Json& facts) {
  for (const auto& [name, value] : facts.items()) {
    if (name == "tool") {
      print_tool(value);
      continue;
    }
    // The next key contains the reason.
    if (name == "static_compliance_m_per_n" && value.is_null()) { continue; }
    if (value.is_object() || value.is_array()) {
      std::printf("%s\n", name.c_str());
      if (value.is_array() && !value.empty() && value.front().is_object()) {
        print_rows(value);
        continue;
      }
      for (const auto& [key, item] : value.items()) {
        std::printf("  %s%s\n", value.is_object() ? (io::printable(key) + ": ").c_str() : "",
                    io::printable(text_of(item, "no limit")).c_str());
      }
      continue;
    }
    std::printf("%-28s %s\n", name.c_str(), io::printable(text_of(value, "no limit")).c_str());
  }
}

int run_inspect(const InspectOptions& options) {
  const LoadedScene loaded = load_scene(options.scene, options, options.no_skip);
  const Json facts = facts_of(loaded);
  if (options.json) {
    std::printf("%s\n", facts.dump(2).c_str());
  } else {
    print(facts);
  }
  return done;
}

}  // namespace

std::optional<double> tool_compliance(const Scene& scene, const NetworkProblem& problem) {
  if (!scene.needle && !scene.probe) { return {}; }
  const Json found = compliance_json(NeedlePath(scene, problem.network()), problem);
  const Json& compliance = found.at("static_compliance_m_per_n");
  return compliance.is_null() ? std::nullopt : std::optional(compliance.get<double>());
}

void add_inspect(Program& program) {
  const auto [command, options] = add_command(
      program, "inspect", "show contents, cost and skipped work of a scene, without simulating",
      run_inspect);
  add_scene(command, options, options.scene);
  add_json(command, options);
  writes_nothing(command);
  command.add_flag("--no-skip", options.no_skip, "plan without skipping");
  command.footer(integrator_help());
}

}  // namespace palpate::cli
