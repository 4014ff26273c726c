// SPDX-License-Identifier: MIT
#include "model/dynamics/tool_check.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include "model/dynamics/tissue_grid.hpp"
#include "model/dynamics/voxel_tissue.hpp"

namespace palpate {

namespace {

constexpr double most_pauses = 1e6;
constexpr long most_sites = 10000;  // of a palpation map
constexpr double slowest_rate = 100.0;   // of a haptic loop [Hz]
constexpr double fastest_rate = 20000.0;
constexpr int longest_delay = 100;       // ticks
constexpr double lowest_grip = 0.08;     // z of the device on its axis, counts within +-1600 [m]
constexpr double highest_grip = 0.175;
constexpr double digits_lost = 1e-9;  // of numbers that a person writes

template <class Vector>
std::string list_of(const Vector& values) {
  std::string text;
  for (const double value : values) {
    text.append(text.empty() ? "[" : ", ").append(number_in_words(value));
  }
  return text + "]";
}

/// Half the edges of the skin; nothing for a tissue of no known shape.
std::optional<Eigen::Vector2d> half_skin(const Tissue& tissue) {
  const Lattice& lattice = tissue.lattice;
  const LayerBlock& block = tissue.block;
  if (tissue.source == Source::lattice) {
    return 0.5 * lattice.spacing * Eigen::Vector2d(lattice.nodes[0] - 1, lattice.nodes[1] - 1);
  }
  if (tissue.source == Source::layers) {
    return 0.5 * block.spacing * Eigen::Vector2d(block.nodes[0] - 1, block.nodes[1] - 1);
  }
  return {};
}

/// What is wrong with the middle of a tool, or the middles of its sides, at a place on such a skin.
std::optional<std::string> wrong_on(const NodeGrid& grid, const Eigen::Vector2d& at,
                                    const Eigen::Vector2d& half_size) {
  using Eigen::Vector2d;
  for (const Vector2d& way : {Vector2d(0, 0), Vector2d(1, 0), Vector2d(-1, 0), Vector2d(0, 1), Vector2d(0, -1)}) {
    const Vector2d place = at + way.cwiseProduct(half_size);
    const std::string where = way.isZero() || half_size.isZero() ? "" : " at its side, " + list_of(place) + " m";
    const std::optional<double> depth = skin_depth(grid, place);
    if (!depth) { return "no tissue lies beneath" + where + "; must be above tissue"; }
    if (*depth <= -0.5 * grid.spacing.z()) {  // planes of nodes lie that near to the skin
      return "the tissue beneath" + where + " begins " + number_in_words(-*depth) + " m above z = 0; must begin at z >= 0";
    }
  }
  return {};
}

/// A place of the tool on the skin, with what of the tool lies around it.
void check_entry(const Scene& scene, const Eigen::Vector2d& entry,
                 const Eigen::Vector2d& half_size, const std::string& key, Rules& rules) {
  if (!entry.allFinite()) { return rules.must(false, key, "not finite; two finite numbers"); }
  const Tissue& tissue = scene.tissue;
  const std::optional<NodeGrid> grid = rules.none_broken() ? uneven_grid(scene) : std::nullopt;
  if (grid) {
    const std::optional<std::string> wrong = wrong_on(*grid, entry, half_size);
    return rules.must(!wrong, key, list_of(entry) + " m; " + wrong.value_or(""));
  }
  const std::optional<Eigen::Vector2d> half = half_skin(tissue);
  if (!half) { return; }
  const Eigen::Vector2d reach = entry.cwiseAbs() + half_size;
  const bool inside = (reach - *half).maxCoeff() <= digits_lost * half->maxCoeff();
  const std::string what = half_size.isZero() ? "must be" : "all of its size must be";
  rules.must(inside, key,
             list_of(entry) + " m; " + what + " on the skin, |x| <= " + number_in_words(half->x()) +
                 " and |y| <= " + number_in_words(half->y()));
}

void check_needle(const Scene& scene, const Needle& needle, Rules& rules) {
  rules.positive(needle.diameter, "needle.diameter", "m");
  rules.positive(needle.mass, "needle.mass", "kg");
  check_entry(scene, needle.entry, Eigen::Vector2d::Zero(), "needle.entry", rules);
  const double length = needle.direction.norm();
  const bool has_length = std::isfinite(length) && length >= 1e-100;
  rules.must(has_length, "needle.direction",
             list_of(needle.direction) + "; must have a length from 1e-100 to 1e100");
  rules.must(!has_length || needle.direction.z() >= (0.5 - digits_lost) * length, "needle.direction",
             list_of(needle.direction) + "; must be within 60 degrees of [0, 0, 1]");
}

void check_map(const Scene& scene, const Probe& probe, Rules& rules) {
  const Tissue& tissue = scene.tissue;
  const PalpationGrid& grid = *probe.map;
  const auto [along_x, along_y] = grid.sites;
  rules.positive(grid.spacing, "probe.map.spacing", "m");
  const bool counted = along_x >= 1 && along_y >= 1;
  rules.must(counted, "probe.map.sites",
             list_of(std::array{double(along_x), double(along_y)}) + "; both must be >= 1");
  const long count = static_cast<long>(along_x) * along_y;
  rules.must(count <= most_sites, "probe.map.sites",
             std::to_string(count) + " sites; must be at most " + std::to_string(most_sites));
  const bool usable = counted && count <= most_sites && std::isfinite(grid.spacing) && grid.spacing > 0.0 &&
                      probe.size.allFinite() && probe.entry.allFinite();
  if (!usable) { return; }
  if (const std::optional<NodeGrid> nodes = rules.none_broken() ? uneven_grid(scene) : std::nullopt) {
    for (long site = 0; site < count; ++site) {
      const Eigen::Vector2d step(static_cast<double>(site % along_x), static_cast<double>(site / along_x));
      const Eigen::Vector2d at = probe.entry - grid.half_span() + grid.spacing * step;
      if (const auto wrong = wrong_on(*nodes, at, 0.5 * probe.size)) {
        return rules.must(false, "probe.map", "its site at " + list_of(at) + " m: " + *wrong);
      }
    }
    return;
  }
  const std::optional<Eigen::Vector2d> half = half_skin(tissue);
  if (!half) { return; }
  const Eigen::Vector2d reach = probe.entry.cwiseAbs() + grid.half_span() + 0.5 * probe.size;
  rules.must((reach - *half).maxCoeff() <= digits_lost * half->maxCoeff(), "probe.map",
             "its sites with the probe reach to " + list_of(reach) + " m; the skin ends at " +
                 list_of(*half) + " m");
}

void check_probe(const Scene& scene, const Probe& probe, Rules& rules) {
  rules.positive(probe.mass, "probe.mass", "kg");
  const bool sized = probe.size.allFinite() && probe.size.minCoeff() > 0.0;
  rules.must(sized, "probe.size", list_of(probe.size) + " m; must be > 0");
  rules.must(probe.shape == Probe::Shape::ultrasound || probe.size.x() == probe.size.y(),
             "probe.size", list_of(probe.size) + " m; must be one diameter for a fingertip");
  if (sized) { check_entry(scene, probe.entry, 0.5 * probe.size, "probe.entry", rules); }
  if (probe.map) { check_map(scene, probe, rules); }
}

/// Pauses that an intermittent drive would make in the whole duration, at most.
double pauses(const Drive& drive, double duration) {
  if (drive.kind == Drive::Kind::force) { return duration / (drive.push + drive.pause); }
  const double in_time = duration / (drive.advance / drive.speed + drive.pause);
  return drive.depth ? std::min(in_time, (*drive.depth - drive.from) / drive.advance) : in_time;
}

void check_drive(const Drive& drive, double duration, Rules& rules) {
  rules.non_negative(drive.start, "drive.start", "s");
  rules.must(
      std::isfinite(drive.from) && drive.from <= 0.0, "drive.from",
      number_in_words(drive.from) + " m; must be <= 0, as the tip starts outside the tissue");
  rules.positive(drive.speed, "drive.speed", "m/s");
  rules.positive(drive.advance, "drive.advance", "m");
  rules.non_negative(drive.pause, "drive.pause", "s");
  rules.must(!drive.depth || (std::isfinite(*drive.depth) && *drive.depth > drive.from),
             "drive.depth",
             number_in_words(drive.depth.value_or(0.0)) +
                 " m; must be > from = " + number_in_words(drive.from) + " m");
  rules.non_negative(drive.hold, "drive.hold", "s");
  rules.non_negative(drive.withdraw_speed, "drive.withdraw_speed", "m/s");
  rules.positive(drive.grip_stiffness, "drive.grip_stiffness", "N/m");
  rules.positive(drive.force, "drive.force", "N");
  rules.non_negative(drive.rise, "drive.rise", "s");
  rules.positive(drive.push, "drive.push", "s");
  rules.non_negative(drive.withdraw_force, "drive.withdraw_force", "N");
  rules.non_negative(drive.hand_viscosity, "drive.hand_viscosity", "N s/m");
  if (drive.technique != Drive::Technique::intermittent) { return; }
  const double count = pauses(drive, duration);
  rules.must(!(count > most_pauses), "drive.technique",
             number_in_words(count) + " pauses in the duration; must be at most 1e6");
}

void check_syringe(const Syringe& syringe, Rules& rules) {
  rules.positive(syringe.plunger_area, "syringe.plunger_area", "m^2");
  rules.positive(syringe.compliance, "syringe.compliance", "m^3/Pa");
  rules.non_negative(syringe.thumb_force, "syringe.thumb_force", "N");
  rules.non_negative(syringe.thumb_flow, "syringe.thumb_flow", "m^3/s");
  rules.positive(syringe.tissue_resistance, "syringe.tissue_resistance", "Pa s/m^3");
  rules.positive(syringe.epidural_resistance, "syringe.epidural_resistance", "Pa s/m^3");
  rules.positive(syringe.open_resistance, "syringe.open_resistance", "Pa s/m^3");
}

/// Whole ticks of the haptic loop in one of the tissue, to rounding.
bool divides(double rate, double step) {
  const double ticks = rate * step;
  return std::abs(ticks - std::round(ticks)) <= digits_lost * ticks && std::round(ticks) >= 1.0;
}

void check_falcon(const Scene& scene, const FalconDrive& falcon, Rules& rules) {
  const bool rated = falcon.rate >= slowest_rate && falcon.rate <= fastest_rate;
  rules.must(rated, "falcon.rate", number_in_words(falcon.rate) + " Hz; must be from 100 to 20000");
  const double step = scene.simulation.step;
  rules.must(!rated || !(step > 0.0) || divides(falcon.rate, step), "simulation.step",
             number_in_words(step) + " s; with a haptic loop must be a whole number of its ticks of " +
                 number_in_words(1.0 / falcon.rate) + " s");
  rules.must(falcon.delay >= 0 && falcon.delay <= longest_delay, "falcon.delay",
             std::to_string(falcon.delay) + " ticks; must be from 0 to " +
                 std::to_string(longest_delay));
  rules.positive(falcon.coupling_stiffness, "falcon.coupling_stiffness", "N/m");
  rules.non_negative(falcon.coupling_viscosity, "falcon.coupling_viscosity", "N s/m");
  rules.must(falcon.start_height >= lowest_grip && falcon.start_height <= highest_grip,
             "falcon.start_height",
             number_in_words(falcon.start_height) + " m; must be from 0.08 to 0.175, within reach");
  rules.non_negative(falcon.tremor, "falcon.tremor", "m");
  rules.non_negative(falcon.reaction_delay, "falcon.reaction_delay", "s");
}

/// The impulses of a contact need positions and velocities of the same instant.
void check_stepping(const SimulationSettings& simulation, Rules& rules) {
  const std::string& name = simulation.integrator;
  rules.must(name != "leapfrog" && name != "feynman-newton",
             "simulation.integrator",
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
  const bool held = scene.drive && scene.drive->kind == Drive::Kind::falcon;
  rules.must(!scene.falcon || held, "falcon",
             "given without drive.kind = \"falcon\"; must be left out, or that be given");
  rules.must(!scene.syringe || scene.needle, "syringe",
             "given without [needle]; must be left out, or [needle] added");
}

}  // namespace

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
  if (scene.falcon) { check_falcon(scene, *scene.falcon, rules); }
  if (scene.drive) { check_drive(*scene.drive, scene.simulation.duration, rules); }
  if (scene.syringe) { check_syringe(*scene.syringe, rules); }
  if (scene.needle || scene.probe) { check_stepping(scene.simulation, rules); }
}

}  // namespace palpate
