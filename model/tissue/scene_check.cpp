// SPDX-License-Identifier: MIT

#include "model/tissue/scene_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <set>
#include <span>

#include "model/problem/rules.hpp"
#include "model/problem/scene_keys.hpp"
#include "model/problem/spring_law.hpp"
#include "model/tissue/network_builder.hpp"
#include "model/tissue/skin.hpp"
#include "model/tissue/tissue_grid.hpp"
#include "model/tissue/voxel_tissue.hpp"

namespace palpate {

namespace {

constexpr double most_pauses = 1e6;
constexpr long most_sites = 10000;  // limit for a palpation map
constexpr double most_nodes = 5e7;
constexpr std::size_t most_tables = 1000;  // of one kind, such as [[record]]
/// Largest size of any number of a scene. No quantity of a tissue in SI units comes near it, and
/// products of several such numbers are still finite.
constexpr double most_size = 1e30;
/// Beginnings of the names of columns that every scene may have. A record of such a name could
/// make a column twice.
constexpr std::array<std::string_view, 6> taken_names{"tool",   "syringe", "probe",
                                                      "device", "loss",    "tissue"};
constexpr int most_substeps = 10'000;  // 0.1 us each in a tick of a millisecond
constexpr double digits_lost = 1e-9;   // relative rounding of numbers in a file

/// Visitor of scene_keys.hpp that checks the range of every key of a scene.
class RangeCheck {
 public:
  RangeCheck(Rules& rules, std::string prefix) : rules_(rules), prefix_(std::move(prefix)) {}

  template <class T> void value(std::string_view name, const T& member, const Key& key) {
    double found = 0.0;
    const auto allowed = [&](double number) {
      found = number;
      const bool no_end = key.endless && number == std::numeric_limits<double>::infinity();
      return no_end ||
             (std::isfinite(number) && std::abs(number) <= most_size && key.range.holds(number));
    };
    if (all_numbers(member, allowed)) { return; }
    rules_.must(false, prefix_ + std::string(name),
                number_in_words(found) + key.after_number() + "; " +
                    (!std::isfinite(found)         ? "must be finite"
                     : std::abs(found) > most_size ? "must be at most 1e30 in size"
                                                   : key.range.text()));
  }
  template <class T> void table(std::string_view name, const T& member) {
    RangeCheck inner(rules_, prefix_ + std::string(name) + ".");
    fields(inner, member);
  }
  template <class T> void optional_table(std::string_view name, const std::optional<T>& member) {
    if (member) { table(name, *member); }
  }
  template <class T> void list(std::string_view name, const std::vector<T>& members) {
    rules_.must(members.size() <= most_tables, prefix_ + std::string(name),
                std::to_string(members.size()) + " tables; at most " + std::to_string(most_tables));
    for (std::size_t n = 0; n < members.size(); ++n) {
      table(std::string(name) + "[" + std::to_string(n) + "]", members[n]);
    }
  }
  void exactly_one(std::string_view, std::string_view) {}
  void at_most_one(std::string_view, std::string_view) {}

 private:
  Rules& rules_;
  std::string prefix_;
};

template <class Vector> std::string list_of(const Vector& values) {
  std::string text;
  for (const double value : values) {
    text.append(text.empty() ? "[" : ", ").append(number_in_words(value));
  }
  return text + "]";
}

/// Returns half the edge lengths of the skin; empty for a tissue of unknown shape.
std::optional<Eigen::Vector2d> half_skin(const Tissue& tissue) {
  const auto half = [](const auto& grid) -> Eigen::Vector2d {
    return 0.5 * grid.spacing * Eigen::Vector2d(grid.nodes[0] - 1, grid.nodes[1] - 1);
  };
  if (tissue.source == Source::lattice) { return half(tissue.lattice); }
  if (tissue.source == Source::layers) { return half(tissue.block); }
  return {};
}
/// Returns the grid of a tissue whose skin need not be flat, if no rule is broken yet.
std::optional<NodeGrid> sound_grid(const Scene& scene, const Rules& rules) {
  return rules.none_broken() ? uneven_grid(scene) : std::nullopt;
}

/// Returns the reason why the centre of a tool, or the centres of its sides, cannot be at a
/// position on such a skin.
std::optional<std::string> wrong_on(const NodeGrid& grid, const Eigen::Vector2d& at,
                                    const Eigen::Vector2d& half_size) {
  using Eigen::Vector2d;
  for (const Vector2d& way :
       {Vector2d(0, 0), Vector2d(1, 0), Vector2d(-1, 0), Vector2d(0, 1), Vector2d(0, -1)}) {
    const Vector2d place = at + way.cwiseProduct(half_size);
    const std::string where =
        way.isZero() || half_size.isZero() ? "" : " at its side, " + list_of(place) + " m";
    const std::optional<double> depth = skin_depth(grid, place);
    if (!depth) { return "no tissue lies beneath" + where + "; must be above tissue"; }
    if (*depth <= -0.5 * grid.spacing.z()) {  // the planes of nodes are that close to the skin
      return "the tissue beneath" + where + " begins " + number_in_words(-*depth) +
             " m above z = 0; must begin at z >= 0";
    }
  }
  return {};
}

/// Checks a position of the tool on the skin, including the area around it.
void check_entry(const Scene& scene, const Eigen::Vector2d& entry, const Eigen::Vector2d& half_size,
                 const std::string& key, Rules& rules) {
  if (!entry.allFinite()) { return; }
  if (const std::optional<NodeGrid> grid = sound_grid(scene, rules)) {
    const std::optional<std::string> wrong = wrong_on(*grid, entry, half_size);
    return rules.must(!wrong, key, list_of(entry) + " m; " + wrong.value_or(""));
  }
  const std::optional<Eigen::Vector2d> half = half_skin(scene.tissue);
  if (!half) { return; }
  const Eigen::Vector2d reach = entry.cwiseAbs() + half_size;
  const bool inside = (reach - *half).maxCoeff() <= digits_lost * half->maxCoeff();
  const std::string what = half_size.isZero() ? "must be" : "all of its size must be";
  rules.must(inside, key,
             list_of(entry) + " m; " + what + " on the skin, |x| <= " + number_in_words(half->x()) +
                 " and |y| <= " + number_in_words(half->y()));
}

void check_needle(const Scene& scene, const Needle& needle, Rules& rules) {
  check_entry(scene, needle.entry, Eigen::Vector2d::Zero(), "needle.entry", rules);
  const double length = needle.direction.norm();
  const bool has_length = std::isfinite(length) && length >= 1e-100;
  rules.must(has_length || !needle.direction.allFinite(), "needle.direction",
             list_of(needle.direction) + "; must have a length from 1e-100 to 1e100");
  rules.must(!has_length || needle.direction.z() >= (0.5 - digits_lost) * length,
             "needle.direction",
             list_of(needle.direction) + "; must be within 60 degrees of [0, 0, 1]");
}

/// Checks the palpation map. `sound` is true if all numbers of the probe are within their ranges.
void check_map(const Scene& scene, const Probe& probe, bool sound, Rules& rules) {
  const PalpationGrid& grid = *probe.map;
  const auto [along_x, along_y] = grid.sites;
  const long count = static_cast<long>(along_x) * along_y;
  rules.must(count <= most_sites, "probe.map.sites",
             std::to_string(count) + " sites; must be at most " + std::to_string(most_sites));
  if (!sound || count > most_sites) { return; }
  if (const std::optional<NodeGrid> nodes = sound_grid(scene, rules)) {
    for (long site = 0; site < count; ++site) {
      const Eigen::Vector2d step(static_cast<double>(site % along_x),
                                 static_cast<double>(site / along_x));
      const Eigen::Vector2d at = probe.entry - grid.half_span() + grid.spacing * step;
      if (const auto wrong = wrong_on(*nodes, at, 0.5 * probe.size)) {
        return rules.must(false, "probe.map", "its site at " + list_of(at) + " m: " + *wrong);
      }
    }
    return;
  }
  const std::optional<Eigen::Vector2d> half = half_skin(scene.tissue);
  if (!half) { return; }
  const Eigen::Vector2d reach = probe.entry.cwiseAbs() + grid.half_span() + 0.5 * probe.size;
  rules.must((reach - *half).maxCoeff() <= digits_lost * half->maxCoeff(), "probe.map",
             "its sites with the probe reach to " + list_of(reach) + " m; the skin ends at " +
                 list_of(*half) + " m");
}

/// Checks the path of a sliding probe. `sound` as in check_map.
void check_path(const Scene& scene, const Probe& probe, bool sound, Rules& rules) {
  const std::vector<Eigen::Vector3d>& path = *probe.path;
  const auto key = [](std::size_t n) { return "probe.path[" + std::to_string(n) + "]"; };
  rules.must(!path.empty(), "probe.path", "empty; must have at least one [t, x, y]");
  for (std::size_t n = 0; n < path.size(); ++n) {
    if (!path[n].allFinite()) {
      return rules.must(false, key(n), list_of(path[n]) + "; must be finite");
    }
    if (n > 0 && !(path[n].x() > path[n - 1].x())) {
      return rules.must(false, key(n),
                        "t = " + number_in_words(path[n].x()) + " s after t = " +
                            number_in_words(path[n - 1].x()) + " s; times must ascend");
    }
  }
  const Tissue& tissue = scene.tissue;
  const bool known =
      tissue.source != Source::network &&
      (tissue.source != Source::lattice || tissue.lattice.weights == LatticeWeights::cell);
  rules.must(known, "probe.path",
             "given for a tissue without materials on a grid; needs a lattice with weights = "
             "\"cell\", layers, a mesh or an image");
  if (!sound || !known) { return; }
  const std::optional<NodeGrid> grid = sound_grid(scene, rules);
  for (std::size_t n = 0; n < path.size(); ++n) {
    if (!grid) {  // a flat skin is convex
      check_entry(scene, path[n].tail<2>(), 0.5 * probe.size, key(n), rules);
      continue;
    }
    const Eigen::Vector3d way = path[std::min(n + 1, path.size() - 1)] - path[n];
    const int steps =
        1 + static_cast<int>(way.tail<2>().norm() / grid->spacing.head<2>().minCoeff());
    for (int k = 0; k < steps; ++k) {
      const Eigen::Vector2d at = path[n].tail<2>() + k * way.tail<2>() / steps;
      if (const auto wrong = wrong_on(*grid, at, 0.5 * probe.size)) {
        return rules.must(false, key(n), "at " + list_of(at) + " m: " + *wrong);
      }
    }
  }
}

/// Checks the curvature of a probe's tip. `sound` as in check_map.
void check_tip_radius(const Probe& probe, bool sound, Rules& rules) {
  const auto must = [&](bool holds, const std::string& wrong) {
    rules.must(holds, "probe.tip_radius", number_in_words(*probe.tip_radius) + " m; " + wrong);
  };
  must(probe.shape == Probe::Shape::fingertip,
       "only a round face is spherical: must be left out, or probe.shape be \"fingertip\"");
  must(probe.face == Probe::FaceKind::rigid,
       "a face of uniform pressure has no shape: must be left out, or probe.face be \"rigid\"");
  must(!probe.path,
       "a sliding face is flat: must be left out, or probe.entry given instead of probe.path");
  if (!sound || probe.shape != Probe::Shape::fingertip) { return; }
  must(*probe.tip_radius >= 0.5 * probe.size.x(),
       "must be at least half of probe.size, " + number_in_words(0.5 * probe.size.x()) +
           " m: a narrower sphere has no face of this diameter");
}

void check_probe(const Scene& scene, const Probe& probe, Rules& rules) {
  Rules ranges;
  RangeCheck(ranges, "").table("probe", probe);
  const bool sound = ranges.none_broken();
  rules.must(probe.shape == Probe::Shape::ultrasound || probe.size.x() == probe.size.y(),
             "probe.size", list_of(probe.size) + " m; must be one diameter for a fingertip");
  if (probe.path) {
    check_path(scene, probe, sound, rules);
  } else if (sound) {
    check_entry(scene, probe.entry, 0.5 * probe.size, "probe.entry", rules);
  }
  if (probe.map) { check_map(scene, probe, sound, rules); }
  if (probe.tip_radius) { check_tip_radius(probe, sound, rules); }
}

/// Returns an upper limit on the number of pauses of an intermittent drive in the whole duration.
double pauses(const Drive& drive, double duration) {
  if (drive.kind == Drive::Kind::force) { return duration / (drive.push + drive.pause); }
  const double in_time = duration / (drive.advance / drive.speed + drive.pause);
  return drive.depth ? std::min(in_time, (*drive.depth - drive.from) / drive.advance) : in_time;
}

void check_drive(const Drive& drive, double duration, Rules& rules) {
  rules.must(!drive.depth || !std::isfinite(*drive.depth) || *drive.depth > drive.from,
             "drive.depth",
             number_in_words(drive.depth.value_or(0.0)) +
                 " m; must be > from = " + number_in_words(drive.from) + " m");
  const bool intermittent = drive.technique == Drive::Technique::intermittent;
  const double way = intermittent ? drive.advance : drive.speed * duration;
  const bool moves = drive.kind != Drive::Kind::force && drive.start < duration && way > 0.0;
  rules.must(!moves || drive.from + 1e-3 * way > drive.from || !std::isfinite(way), "drive.from",
             number_in_words(drive.from) + " m, beside which an advance of " +
                 number_in_words(way) + " m is lost to rounding; must be closer to the skin");
  if (!intermittent) { return; }
  const double count = pauses(drive, duration);
  rules.must(!(count > most_pauses), "drive.technique",
             number_in_words(count) + " pauses in the duration; must be at most 1e6");
}

/// Returns true if one step of the tissue is an integer number of haptic ticks, to rounding error.
bool divides(double rate, double step) {
  const double ticks = rate * step;
  return std::abs(ticks - std::round(ticks)) <= digits_lost * ticks && std::round(ticks) >= 1.0;
}

void check_falcon(double rate, double step, Rules& rules) {
  rules.must(!(rate > 0.0) || !(step > 0.0) || divides(rate, step), "simulation.step",
             number_in_words(step) +
                 " s; with a haptic loop must be a whole number of its ticks of " +
                 number_in_words(1.0 / rate) + " s");
}

/// Checks the integrator of a tool: contact impulses need positions and velocities at the same
/// time.
void check_stepping(const SimulationSettings& simulation, Rules& rules) {
  const std::string& name = simulation.integrator;
  rules.must(name != "leapfrog" && name != "feynman-newton", "simulation.integrator",
             "\"" + name +
                 "\" keeps velocities of half steps; with a tool must be \"auto\", "
                 "\"euler\", \"euler-cromer\", \"feynman-newton-printed\", \"velocity-verlet\", "
                 "\"rk4\", \"implicit-euler\" or \"implicit-midpoint\"");
  rules.must(!simulation.printed.no_time_step, "simulation.printed.no_time_step",
             "on; must be false with a tool, whose speed is in metres a second");
  rules.must(!simulation.printed.lagged_velocity, "simulation.printed.lagged_velocity",
             "on; must be false with a tool, whose contacts change velocities at once");
}

void check_company(const Scene& scene, Rules& rules) {
  const bool tool = scene.needle || scene.probe;
  const bool oscillator = scene.tissue.source == Source::oscillator;
  rules.must(!scene.needle || !scene.probe, "probe",
             "given beside [needle]; only one of them may be");
  rules.must(!oscillator || !tool, scene.needle ? "needle" : "probe",
             "given; must be left out with source = \"oscillator\", which has no skin");
  rules.must(!scene.drive || tool, "drive",
             "given without a tool; must be left out, or [needle] or [probe] added");
  const bool held = scene.drive && scene.drive->is_coupled();
  rules.must(
      !scene.falcon || held, "falcon",
      "given without drive.kind = \"falcon\" or \"recorded\"; must be left out, or that be given");
  rules.must(!scene.syringe || scene.needle, "syringe",
             "given without [needle]; must be left out, or [needle] added");
  const Syringe syringe = scene.syringe.value_or(Syringe{});
  rules.must(syringe.hand_share == 0.0 || syringe.thumb == Syringe::Thumb::drives,
             "syringe.hand_share",
             number_in_words(syringe.hand_share) + "; must be left out without thumb = \"drives\"");
}

/// Returns true if the needle is in a tissue without cutting forces and friction of its own, so
/// that [[layer]] tables must define them.
bool needs_layers_for_needle(const Scene& scene) {
  const Tissue& tissue = scene.tissue;
  return scene.needle &&
         (tissue.source == Source::network ||
          (tissue.source == Source::lattice && tissue.lattice.weights == LatticeWeights::uniform));
}

void check_tool(const Scene& scene, Rules& rules) {
  check_company(scene, rules);
  if (scene.needle) { check_needle(scene, *scene.needle, rules); }
  if (scene.probe) { check_probe(scene, *scene.probe, rules); }
  if (scene.falcon && scene.drive && scene.drive->kind == Drive::Kind::falcon) {
    check_falcon(scene.falcon->rate, scene.simulation.step, rules);
  }
  if (scene.drive) { check_drive(*scene.drive, scene.simulation.duration, rules); }
  if (scene.needle || scene.probe) { check_stepping(scene.simulation, rules); }
}

class Checker : private Rules {
 public:
  explicit Checker(const Scene& scene) : scene_(scene) {}

  std::vector<Violation> run() {
    RangeCheck ranges(*this, "");
    fields(ranges, scene_);
    check_simulation();
    check_material_laws();
    check_source();
    check_loads();
    check_records();
    check_tool(scene_, *this);
    return take();
  }

 private:
  void known_material(const std::string& name, std::string key) {
    must(find_material(scene_.materials, name) != nullptr, std::move(key),
         unknown_material(name, scene_.materials));
  }

  template <class Part>
  void known_materials(const std::vector<Part>& parts, std::string_view table) {
    for (std::size_t n = 0; n < parts.size(); ++n) {
      known_material(parts[n].material, at(table, n, "material"));
    }
  }

  void check_simulation() {
    const SimulationSettings& s = scene_.simulation;
    const double ticks = s.duration / s.step;
    must(!(ticks > 1e9), "simulation.duration", number_in_words(ticks) + " ticks; at most 1e9");
    const int substeps = s.substeps.value_or(1);
    must(substeps <= most_substeps, "simulation.substeps",
         std::to_string(substeps) + "; at most " + std::to_string(most_substeps) +
             ", because a run can be stopped between ticks only");
    must(!(ticks < 1.0 - 1e-9), "simulation.duration", "shorter than one step; at least one step");
    must(scene_.tissue.source != Source::oscillator || !s.printed.any() ||
             (!s.printed.direction && !s.printed.sign && !s.printed.reversed &&
              !s.printed.half_force),
         "simulation.equations",
         "errata of the network's springs have no meaning for an oscillator");
  }

  void check_material_laws() {
    bool any = false;
    for (std::size_t n = 0; n < scene_.materials.size(); ++n) {
      const Material& material = scene_.materials[n];
      const MaterialLaw law = law_of(material);
      any = any || !law.is_linear_elastic();
      if (const std::optional<Stiffening>& s = material.stiffening) {
        const bool exponential = s->law == Stiffening::Law::exponential;
        const auto key = [&](const char* name) {
          return at("material", n, std::string("stiffening.") + name);
        };
        const auto unused = [&](double value, const char* name, const char* other) {
          must(value == 0.0, key(name),
               number_in_words(value) + "; must be left out with law = \"" + other + "\"");
        };
        if (exponential) {
          unused(s->quadratic, "quadratic", "exponential");
          unused(s->cubic, "cubic", "exponential");
        } else {
          unused(s->rate, "rate", "polynomial");
        }
        must(law.stiffens(), key(exponential ? "rate" : "quadratic"),
             exponential ? "0; must be > 0" : "0, as is cubic; one of them must be > 0");
      }
      const double puncture = material.puncture_force.value_or(material.cutting_force);
      must(puncture >= material.cutting_force, at("material", n, "puncture_force"),
           number_in_words(puncture) + " N; at least the cutting_force of " +
               number_in_words(material.cutting_force) + " N, which the crack needs to grow");
      must(material.friction_exponent == 0.0 || material.friction_travel > 0.0,
           at("material", n, "friction_exponent"),
           number_in_words(material.friction_exponent) +
               "; must be left out, or friction_travel added");
      must(material.relaxation.size() <= most_branches, at("material", n, "relaxation"),
           std::to_string(material.relaxation.size()) + " branches; at most " +
               std::to_string(most_branches));
      must(law.lasting_share() > 0.0, at("material", n, "relaxation"),
           "shares of " + number_in_words(1.0 - law.lasting_share()) +
               " in all; must be < 1, so that some stiffness lasts");
    }
    check_changes();
    must(!any || !SpringLaw::is_printed(scene_.simulation.printed), "simulation.equations",
         "a printed form of the spring force; materials with stiffening or relaxation need the "
         "corrected one");
  }

  void check_changes() {
    const Tissue& tissue = scene_.tissue;
    const bool built =
        tissue.source == Source::layers ||
        (tissue.source == Source::lattice && tissue.lattice.weights == LatticeWeights::cell);
    for (std::size_t n = 0; n < scene_.materials.size(); ++n) {
      const std::vector<ModulusChange>& changes = scene_.materials[n].changes;
      must(changes.empty() || built, at("material", n, "change"),
           "must be left out: only layers and a lattice of cells are built of materials again");
      for (std::size_t k = 1; k < changes.size(); ++k) {
        must(changes[k].time > changes[k - 1].time,
             at("material", n, "change[" + std::to_string(k) + "].time"),
             number_in_words(changes[k].time) + " s after " + number_in_words(changes[k - 1].time) +
                 " s; times must ascend");
      }
    }
  }

  void check_source() {
    const Tissue& tissue = scene_.tissue;
    switch (tissue.source) {
      case Source::lattice:
        check_node_counts(tissue.lattice.nodes, "tissue.lattice.nodes");
        if (tissue.lattice.weights == LatticeWeights::cell) {
          known_material(tissue.lattice.material, "tissue.lattice.material");
        }
        break;
      case Source::layers: check_layers(tissue); break;
      case Source::network: check_network(tissue.network); break;
      case Source::oscillator:
        must(scene_.loads.empty(), "load", "an oscillator takes no [[load]]; use drive_amplitude");
        must(scene_.records.empty(), "record",
             "an oscillator has no nodes to record; it writes x_m");
        break;
      case Source::mesh: check_voxels("tissue.mesh"); break;
      case Source::mri: check_voxels("tissue.mri"); break;
    }
    if (tissue.source != Source::layers) { check_layers_of_needle(); }
    const bool bare = tissue.source == Source::network || tissue.source == Source::oscillator;
    must(!(tissue.skin && bare), "tissue.skin",
         "given; must be left out with source = \"network\" or "
         "\"oscillator\", which have no cells for it to lie in");
    known_materials(tissue.inclusions, "inclusion");
  }

  void check_node_counts(std::span<const int> counts, const std::string& key) {
    const double total = std::accumulate(counts.begin(), counts.end(), 1.0, std::multiplies<>());
    check_node_count(total, key);
  }
  void check_node_count(double count, const std::string& key) {
    must(!(count > most_nodes), key, number_in_words(count) + " nodes; at most 5e7");
  }

  /// Checks the layers of a source other than "layers". They define the needle's materials if the
  /// tissue has none.
  void check_layers_of_needle() {
    const std::vector<Layer>& layers = scene_.tissue.layers;
    const bool needed = needs_layers_for_needle(scene_);
    must(!needed || !layers.empty(), "layer",
         "no [[layer]]; a needle in a tissue without materials needs at least one");
    must(needed || layers.empty(), "layer",
         "given; must be left out, unless source = \"layers\" or a needle is in a tissue without "
         "materials");
    if (needed) { check_materials_of(layers); }
  }

  void check_materials_of(const std::vector<Layer>& layers) {
    for (std::size_t n = 0; n < layers.size(); ++n) {
      const Layer& layer = layers[n];
      const std::string key = at("layer", n, "material");
      if (layer.gap) {
        must(layer.material.empty(), key,
             '"' + layer.material + "\" in a gap; must be left out with gap = true");
      } else {
        must(!layer.material.empty(), key, "is missing; must be given, or gap = true");
        if (!layer.material.empty()) { known_material(layer.material, key); }
      }
    }
  }

  void check_layers(const Tissue& tissue) {
    check_node_counts(tissue.block.nodes, "tissue.layers.nodes");
    must(!tissue.layers.empty(), "layer", "no [[layer]]; source \"layers\" needs at least one");
    check_materials_of(tissue.layers);
    double depth = 0.0;
    for (std::size_t n = 0; n < tissue.layers.size(); ++n) {
      const Layer& layer = tissue.layers[n];
      depth += layer.thickness;
      const bool between = n > 0 && n + 1 < tissue.layers.size();
      must(!layer.gap || between, at("layer", n, "gap"),
           "true for the " + std::string(n == 0 ? "first" : "last") +
               " layer; a gap must be between two layers of tissue");
      must(!layer.gap || !(layer.thickness < tissue.block.spacing), at("layer", n, "thickness"),
           number_in_words(layer.thickness) + " of a gap; at least one tissue.layers.spacing, " +
               number_in_words(tissue.block.spacing));
    }
    const double planes = std::round(depth / tissue.block.spacing) + 1.0;
    check_node_count(planes * tissue.block.nodes[0] * tissue.block.nodes[1],
                     "tissue.layers.spacing");
    if (none_broken() && layers_follow_skin(scene_)) { check_beneath_skin(); }
  }

  void check_beneath_skin() {
    if (const auto sheets = column_between_sheets(scene_)) {
      const auto& [x, y, upper, lower] = *sheets;
      return must(false, "tissue.skin.path",
                  "beneath " + list_of(Eigen::Vector2d(x, y)) + " m it has faces at z = " +
                      number_in_words(upper) + " and " + number_in_words(lower) +
                      " m, and they are not of a closed surface: where the tissue ends is unknown. "
                      "Close the surface, or leave one sheet above the tissue");
    }
    const double places = places_beneath_skin(scene_);
    const bool fits = places <= most_nodes;
    const auto z = scene_.tissue.skin->surface().vertex.row(2);
    must(!fits || layered_node_count(scene_) > 0, "tissue.skin.path",
         "no cell of the block of layers lies beneath its surface, which reaches from z = " +
             number_in_words(z.minCoeff()) + " to " + number_in_words(z.maxCoeff()) +
             " m; at least one must");
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
    must(tissue.inclusions.empty(), "inclusion",
         "given; must be left out, unless source = \"lattice\" or "
         "\"layers\"");
  }

  /// Returns the number of nodes for the check of indices; -1 if it is unknown because of
  /// violations.
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
    must(count < 0 || node < 0 || node < count, key,
         "node " + std::to_string(node) + "; 0 to " + std::to_string(count - 1));
  }

  void check_loads() {
    const Eigen::Index count = scene_.loads.empty() ? -1 : node_count();
    for (std::size_t n = 0; n < scene_.loads.size(); ++n) {
      const Load& load = scene_.loads[n];
      must(load.face.has_value() != !load.nodes.empty(), at("load", n, "nodes"),
           "either nodes or face; exactly one of them");
      std::set<int> met;
      for (const int node : load.nodes) {
        node_exists(node, at("load", n, "nodes"), count);
        must(met.insert(node).second, at("load", n, "nodes"),
             "node " + std::to_string(node) + " twice; each at most once");
      }
      must(load.end > load.start, at("load", n, "end"),
           number_in_words(load.end) + " s; must be after start = " + number_in_words(load.start) +
               " s");
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
      must(std::ranges::find(taken_names, record.name) == taken_names.end(),
           at("record", n, "name"),
           "\"" + record.name + "\" begins the names of other columns; another name");
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
