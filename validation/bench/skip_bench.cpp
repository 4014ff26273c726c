// SPDX-License-Identifier: MIT
/// What each thing that a scene does not need is worth: ticks with it left out and ticks with it gone through all the
/// same.
#include <algorithm>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "model/dynamics/network_builder.hpp"
#include "model/stepping/simulation.hpp"
#include "validation/bench/bench_cases.hpp"
#include "validation/bench/interleaved.hpp"
#include "validation/bench/kernel_variants.hpp"

namespace palpate::bench {

namespace {

/// A scene that needs all but one thing, so that nothing else is left out.
struct SkippedThing {
  std::string name{};
  Scene scene{};
  SpringNetwork network{};
};

constexpr int nodes_a_side = 24;
constexpr long ticks = 20;

/// The pulled cube with weight and nothing held: nothing is left out.
Scene whole_scene() {
  Scene scene = s26_scene(nodes_a_side);
  scene.simulation.duration = 1e3;
  scene.tissue.gravity = {0.0, 0.0, 1e-3};
  scene.tissue.fixed.emplace();
  return scene;
}

SkippedThing thing(std::string name, const Scene& scene, bool as_list) {
  SkippedThing made{.name = std::move(name), .scene = scene, .network = build_network(scene)};
  if (as_list) { break_lattice(made.network); }
  return made;
}

/// Half of the nodes: rows of them, layer by layer.
void fix_half(SpringNetwork& network) {
  const std::size_t half = network.fixed.size() / 2;
  std::fill_n(network.fixed.begin(), half, std::uint8_t{1});
}

std::vector<SkippedThing> skipped_things() {
  std::vector<SkippedThing> things;
  for (const bool as_list : {false, true}) {
    const std::string where = as_list ? "list: " : "lattice: ";
    Scene undamped = whole_scene();
    undamped.tissue.lattice.viscosity = 0.0;
    things.push_back(thing(where + "dampers, of no viscosity", undamped, as_list));
    Scene weightless = whole_scene();
    weightless.tissue.gravity.setZero();
    things.push_back(thing(where + "weight, without gravity", weightless, as_list));
    things.push_back(thing(where + "fixed nodes and their springs, half of all", whole_scene(), as_list));
    fix_half(things.back().network);
  }
  Scene asleep = whole_scene();
  asleep.tissue.gravity.setZero();
  asleep.simulation.sleep_force = 1e-3;
  things.push_back(thing("lattice: nodes at rest, in the first " + std::to_string(ticks) + " ticks", asleep, false));
  return things;
}

/// So many ticks from the beginning, each time of a simulation made anew outside the time.
Contender contender(const SkippedThing& what, bool skip, std::unique_ptr<Simulation>& simulation) {
  return {.name = what.name,
          .repeat = [&simulation](long times) {
            for (long n = 0; n < times * ticks; ++n) { (void)simulation->tick(); }
          },
          .begin = [&simulation, &what, skip] {
            simulation = std::make_unique<Simulation>(what.scene, what.network, skip);
            for (int n = 0; n < 3; ++n) { (void)simulation->tick(); }  // the first touch new memory
          },
          .end = [&simulation] { simulation.reset(); }};
}

void measure(const CaseContext& /*context*/, Outcome& outcome) {
  Table table{.id = "skips",
              .title = "What is left out",
              .caption = "A cube of " + std::to_string(nodes_a_side) +
                         " nodes a side that needs all but the one thing, semi-implicit Euler: microseconds of a tick, "
                         "least of interleaved rounds by the processor time of one thread. Both ways give the same bits, "
                         "but for nodes at rest (ctest -R \"model/(skip|lattice_sleep)\").",
              .columns = {"left out", "gone through (us)", "left out (us)", "gone through / left out (1)"},
              .timing = true};
  double worst = std::numeric_limits<double>::infinity();
  for (const SkippedThing& what : skipped_things()) {
    std::unique_ptr<Simulation> simulation;
    const std::vector<Timed> timed = time_interleaved(
        {contender(what, false, simulation), contender(what, true, simulation)}, {.rounds = 9, .batch = 0.0});
    const double scale = 1e6 / static_cast<double>(ticks);
    const double worth = timed[0].least / timed[1].least;
    worst = std::min(worst, worth);
    table.rows.push_back({what.name, scale * timed[0].least, scale * timed[1].least, worth});
  }
  outcome.tables.push_back(std::move(table));
  outcome.judge({.name = "least_worth",
                 .value = worst,
                 .lower = 0.9,
                 .bound_from = "wanted: leaving something out never costs time; a tenth is noise of this comparison"});
}

}  // namespace

std::vector<Case> skip_cases() {
  return {{.name = "bench/skips",
           .suite = "timing",
           .claim = "Leaving out what a scene does not need never makes a tick slower.",
           .measure = measure,
           .weight = 10.0}};
}

}  // namespace palpate::bench
