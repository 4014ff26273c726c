// SPDX-License-Identifier: MIT
#include "model/dynamics/scene_check.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <span>

#include "model/dynamics/network_builder.hpp"
#include "model/dynamics/rules.hpp"
#include "model/dynamics/skin.hpp"
#include "model/dynamics/tissue_grid.hpp"
#include "model/dynamics/tool_check.hpp"
#include "model/dynamics/voxel_tissue.hpp"

namespace palpate {

namespace {

constexpr double most_nodes = 5e7;
constexpr int most_threads = 64;
constexpr int most_far_modes = 1000;

class Checker : private Rules {
 public:
  explicit Checker(const Scene& scene) : scene_(scene) {}

  std::vector<Violation> run() {
    check_simulation();
    check_materials();
    check_source();
    check_loads();
    check_records();
    check_tool(scene_, *this);
    must(scene_.output.frames >= 0, "output.frames",
         std::to_string(scene_.output.frames) + "; must be 0 or more");
    return take();
  }

 private:
  void known_material(const std::string& name, std::string key) {
    must(std::ranges::find(scene_.materials, name, &Material::name) != scene_.materials.end(),
         std::move(key), unknown_material(name, scene_.materials));
  }

  void check_simulation() {
    const SimulationSettings& s = scene_.simulation;
    positive(s.duration, "simulation.duration", "s");
    must(s.solver_tolerance >= 0.0 && s.solver_tolerance < 1.0, "simulation.solver_tolerance",
         number_in_words(s.solver_tolerance) + "; must be from 0 to below 1");
    positive(s.step, "simulation.step", "s");
    must(!s.substeps || *s.substeps >= 1, "simulation.substeps", "must be \"auto\" or 1 or more");
    must(s.threads >= 1 && s.threads <= most_threads, "simulation.threads",
         std::to_string(s.threads) + "; must be from 1 to " + std::to_string(most_threads));
    must(s.sleep_force >= 0.0 && std::isfinite(s.sleep_force), "simulation.sleep_force",
         number_in_words(s.sleep_force) + " N; must be 0 or more");
    must(s.near_radius >= 0.0 && std::isfinite(s.near_radius), "simulation.near_radius",
         number_in_words(s.near_radius) + " m; must be 0 or more");
    must(s.far_modes >= 1 && s.far_modes <= most_far_modes, "simulation.far_modes",
         std::to_string(s.far_modes) + "; must be from 1 to " + std::to_string(most_far_modes));
    const double ticks = s.duration / s.step;
    must(!(ticks > 1e9), "simulation.duration", number_in_words(ticks) + " ticks; at most 1e9");
    must(!(ticks < 1.0 - 1e-9), "simulation.duration", "shorter than one step; at least one step");
    must(scene_.tissue.source != Source::oscillator || !s.printed.any() ||
             (!s.printed.direction && !s.printed.sign && !s.printed.reversed &&
              !s.printed.half_force),
         "simulation.equations", "errata of the network's springs have no meaning for an oscillator");
  }

  void check_materials() {
    for (std::size_t n = 0; n < scene_.materials.size(); ++n) {
      const Material& m = scene_.materials[n];
      const std::string table = "material." + m.name + ".";
      positive(m.youngs_modulus, table + "youngs_modulus", "Pa");
      positive(m.density, table + "density", "kg/m^3");
      non_negative(m.damping_ratio, table + "damping_ratio", "");
      non_negative(m.viscosity.value_or(0.0), table + "viscosity", "N s/m");
      non_negative(m.cutting_force, table + "cutting_force", "N");
      non_negative(m.friction, table + "friction", "N/m");
    }
  }

  void check_source() {
    const Tissue& tissue = scene_.tissue;
    must(tissue.gravity.allFinite(), "tissue.gravity", "not finite; three finite numbers");
    positive(tissue.heavy_mass_factor, "tissue.heavy_mass_factor", "");
    switch (tissue.source) {
      case Source::lattice: check_lattice(tissue.lattice); break;
      case Source::layers: check_layers(tissue); break;
      case Source::network: check_network(tissue.network); break;
      case Source::oscillator: check_oscillator(tissue.oscillator); break;
      case Source::mesh: check_voxels("tissue.mesh"); break;
      case Source::mri: check_voxels("tissue.mri"); break;
    }
    if (tissue.source != Source::layers) { check_layers_of_needle(); }
    const bool bare = tissue.source == Source::network || tissue.source == Source::oscillator;
    must(!(tissue.skin && bare), "tissue.skin", "given; must be left out with source = \"network\" or "
                                                "\"oscillator\", which have no cells for it to lie in");
    for (std::size_t n = 0; n < tissue.inclusions.size(); ++n) {
      const Inclusion& body = tissue.inclusions[n];
      known_material(body.material, at("inclusion", n, "material"));
      const bool sphere = body.shape == Inclusion::Shape::sphere;
      must(sphere ? body.size.x() > 0.0 : body.size.minCoeff() > 0.0, at("inclusion", n, "size"),
           "must be > 0 m");
    }
  }

  void check_connectivity(int connectivity, std::string key) {
    must(connectivity == 6 || connectivity == 18 || connectivity == 26, std::move(key),
         std::to_string(connectivity) + "; must be 6, 18 or 26");
  }

  void check_node_counts(std::span<const int> counts, const std::string& key) {
    double total = 1.0;
    for (const int count : counts) {
      must(count >= 2, key, std::to_string(count) + "; must be 2 or more");
      total *= count;
    }
    must(!(total > most_nodes), key, number_in_words(total) + " nodes; at most 5e7");
  }

  void check_lattice(const Lattice& lattice) {
    check_node_counts(lattice.nodes, "tissue.lattice.nodes");
    positive(lattice.spacing, "tissue.lattice.spacing", "m");
    check_connectivity(lattice.connectivity, "tissue.lattice.connectivity");
    if (lattice.weights == LatticeWeights::cell) {
      known_material(lattice.material, "tissue.lattice.material");
      return;
    }
    positive(lattice.stiffness, "tissue.lattice.stiffness", "N/m");
    non_negative(lattice.viscosity, "tissue.lattice.viscosity", "N s/m");
    positive(lattice.node_mass, "tissue.lattice.node_mass", "kg");
  }

  /// Returns their depth in all [m].
  double check_each_layer(const std::vector<Layer>& layers) {
    double depth = 0.0;
    for (std::size_t n = 0; n < layers.size(); ++n) {
      positive(layers[n].thickness, at("layer", n, "thickness"), "m");
      known_material(layers[n].material, at("layer", n, "material"));
      depth += layers[n].thickness;
    }
    return depth;
  }

  /// Layers beside another source tell a needle what it meets, where nothing else does.
  void check_layers_of_needle() {
    const std::vector<Layer>& layers = scene_.tissue.layers;
    const bool needed = needs_layers_for_needle(scene_);
    must(!needed || !layers.empty(), "layer",
         "no [[layer]]; a needle in a tissue without materials needs at least one");
    must(needed || layers.empty(), "layer",
         "given; must be left out, unless source = \"layers\" or a needle is in a tissue without "
         "materials");
    if (needed) { check_each_layer(layers); }
  }

  void check_layers(const Tissue& tissue) {
    check_node_counts(tissue.block.nodes, "tissue.layers.nodes");
    positive(tissue.block.spacing, "tissue.layers.spacing", "m");
    check_connectivity(tissue.block.connectivity, "tissue.layers.connectivity");
    must(!tissue.layers.empty(), "layer", "no [[layer]]; source \"layers\" needs at least one");
    const double depth = check_each_layer(tissue.layers);
    const double planes = std::round(depth / tissue.block.spacing) + 1.0;
    const double nodes = planes * tissue.block.nodes[0] * tissue.block.nodes[1];
    must(!(nodes > most_nodes), "tissue.layers.spacing",
         number_in_words(nodes) + " nodes; at most 5e7");
    if (none_broken() && layers_follow_skin(scene_)) { check_beneath_skin(); }
  }

  /// "from z = 0.01 to 0.02 m"
  [[nodiscard]] std::string skin_reach() const {
    const auto z = scene_.tissue.skin->surface().vertex.row(2);
    return "from z = " + number_in_words(z.minCoeff()) + " to " + number_in_words(z.maxCoeff()) + " m";
  }

  void check_beneath_skin() {
    const double places = places_beneath_skin(scene_);
    const bool fits = places <= most_nodes;
    must(!fits || layered_node_count(scene_) > 0, "tissue.skin.path",
         "no cell of the block of layers lies beneath its surface, which reaches " + skin_reach() +
             "; at least one must");
    must(fits, "tissue.skin.path",
         "its highest place is so far above z = 0 that the block takes " + number_in_words(places) +
             " nodes; at most 5e7");
  }

  void check_network(const SpringNetwork& network) {
    must(network.node_count() > 0, "tissue.network.nodes", "no nodes; at least one");
    for (const Spring& spring : network.springs) {
      const bool inside = spring.a >= 0 && spring.b >= 0 && spring.a < network.node_count() &&
                          spring.b < network.node_count() && spring.a != spring.b;
      if (!inside) {
        must(false, "tissue.network.springs",
             "spring from node " + std::to_string(spring.a) + " to node " +
                 std::to_string(spring.b) + "; two different nodes of 0 to " +
                 std::to_string(network.node_count() - 1));
        return;
      }
    }
    for (Eigen::Index i = 0; i < network.node_count(); ++i) {
      if (!network.is_fixed(static_cast<int>(i)) && !(network.mass(i) > 0.0)) {
        must(false, "tissue.network.nodes",
             "mass " + number_in_words(network.mass(i)) + " kg of node " + std::to_string(i) +
                 "; must be > 0");
        return;
      }
    }
  }

  void check_voxels(const std::string& table) {
    const Tissue& tissue = scene_.tissue;
    must(tissue.voxels != nullptr, table, "was not read; its files are needed");
    must(tissue.inclusions.empty(), "inclusion", "given; must be left out, unless source = \"lattice\" or "
                                                 "\"layers\"");
  }

  void check_oscillator(const Oscillator& o) {
    positive(o.mass, "tissue.oscillator.mass", "kg");
    non_negative(o.stiffness, "tissue.oscillator.stiffness", "N/m");
    must(std::isfinite(o.viscosity), "tissue.oscillator.viscosity", "not finite; a finite number");
    must(scene_.loads.empty(), "load", "an oscillator takes no [[load]]; use drive_amplitude");
    must(scene_.records.empty(), "record", "an oscillator has no nodes to record; it writes x_m");
  }

  /// Number of nodes that indices may refer to; negative: not known because of earlier violations.
  [[nodiscard]] Eigen::Index node_count() const {
    const Tissue& tissue = scene_.tissue;
    if (!none_broken()) { return -1; }
    switch (tissue.source) {
      case Source::lattice:
        return static_cast<Eigen::Index>(tissue.lattice.nodes[0]) * tissue.lattice.nodes[1] *
               tissue.lattice.nodes[2];
      case Source::layers: return layered_node_count(scene_);
      case Source::network: return tissue.network.node_count();
      case Source::oscillator: return -1;
      case Source::mesh:
      case Source::mri: return tissue.voxels->network.node_count();
    }
    return -1;
  }

  void node_exists(int node, const std::string& key, Eigen::Index count) {
    must(count < 0 || (node >= 0 && node < count), key,
         "node " + std::to_string(node) + "; 0 to " + std::to_string(count - 1));
  }

  void check_loads() {
    const Eigen::Index count = scene_.loads.empty() ? -1 : node_count();
    for (std::size_t n = 0; n < scene_.loads.size(); ++n) {
      const Load& load = scene_.loads[n];
      must(load.face.has_value() != !load.nodes.empty(), at("load", n, "nodes"),
           "either nodes or face; exactly one of them");
      for (const int node : load.nodes) { node_exists(node, at("load", n, "nodes"), count); }
      must(load.force.allFinite(), at("load", n, "force"), "not finite; three finite numbers");
      non_negative(load.start, at("load", n, "start"), "s");
      must(load.end > load.start, at("load", n, "end"),
           number_in_words(load.end) + " s; must be after start = " +
               number_in_words(load.start) + " s");
      must(load.profile == Profile::constant || std::isfinite(load.end), at("load", n, "end"),
           "left out; profiles \"ramp\" and \"half-sine\" need an end");
    }
  }

  void check_records() {
    const Eigen::Index count = scene_.records.empty() ? -1 : node_count();
    std::set<std::string> names;
    for (std::size_t n = 0; n < scene_.records.size(); ++n) {
      const Record& record = scene_.records[n];
      must(!record.name.empty(), at("record", n, "name"), "empty; a name");
      must(names.insert(record.name).second, at("record", n, "name"),
           "\"" + record.name + "\" twice; each name once");
      must(!record.quantities.empty(), at("record", n, "quantities"), "empty; at least one");
      if (const int* node = std::get_if<int>(&record.where)) {
        node_exists(*node, at("record", n, "node"), count);
      }
    }
  }

  const Scene& scene_;
};

}  // namespace

std::string unknown_material(const std::string& name, const std::vector<Material>& known) {
  std::string names;
  for (const Material& material : known) { names += (names.empty() ? "" : ", ") + material.name; }
  return "unknown material \"" + name + "\"; known are " + names;
}

std::vector<Violation> check_scene(const Scene& scene) { return Checker(scene).run(); }

}  // namespace palpate
