// SPDX-License-Identifier: MIT
/// A needle in fifty thousand nodes, of which those away from it are left to a far field: what a tick costs, and what
/// it changes in the force, against explicit steps of every node.
#include <algorithm>

#include "validation/bench/bench_cases.hpp"
#include "validation/bench/insertion_runs.hpp"
#include "validation/cases/tool_setting.hpp"

namespace palpate::bench {

namespace {

constexpr int across = 71;
constexpr int repeats = 2;
/// Explicit steps of every node take a second for each tick of 1 ms: the needle is quick, and the run ends before it
/// stops, for the jolt of that stop implicit Euler damps and explicit steps do not.
constexpr double speed = 0.06;  ///< [m/s]

struct Far {
  double near_radius = 0.0;  ///< [m]
  int modes = 0;
};
constexpr Far judged{0.01, 40};

/// Tissue as in fixtures/scenes/needle-50k.toml.
Scene block_of(int nodes, bool quick) {
  Scene scene = tools::seven_published_layers(nodes);
  scene.materials[0].youngs_modulus = 1.5e6;
  scene.materials[1].cutting_force = 0.43;
  scene.drive->depth = 0.0423;
  scene.drive->speed = speed;
  scene.simulation = {.duration = quick ? 0.1 : 0.7, .step = 1e-3};
  return scene;
}

Scene with_far_field(Scene scene, const Far& far) {
  scene.simulation.integrator = "implicit-euler";
  scene.simulation.solver_tolerance = 1e-2;
  scene.simulation.near_radius = far.near_radius;
  scene.simulation.far_modes = far.modes;
  return scene;
}

std::vector<Cell> row_of(const std::string& name, const Insertion& run, const Insertion& truth) {
  return {name,
          run.loading,
          ticks_within(run, 0.5),
          ticks_within(run, 1.0),
          largest(errors_within_a_tick(run, truth)),
          static_cast<double>(std::ranges::count_if(errors(run, truth), [](double e) { return !(e <= 0.02); }))};
}

void measure(const CaseContext& context, Outcome& outcome) {
  const Scene whole = block_of(across, context.quick);
  const Insertion run = insert_repeatedly(with_far_field(whole, judged), repeats);
  outcome.judge({.name = "diverged", .value = run.diverged ? 1.0 : 0.0, .upper = 0.0,
                 .bound_from = "stable at ticks of 1 ms"});
  outcome.judge({.name = "worst_tick",
                 .value = 1e6 * largest(run.seconds),
                 .unit = "us",
                 .upper = 1000.0,
                 .bound_from = "wanted: the period of a loop of 1 kHz"});
  tell_times(run, "with_a_far_field", outcome);
  outcome.timings.push_back({"loading", run.loading, "s"});

  Scene reference = whole;
  reference.simulation.integrator = "velocity-verlet";
  reference.simulation.threads = 2;
  const Insertion truth = insert(reference);
  outcome.judge({.name = "force_error_over_peak_within_a_tick",
                 .value = largest(errors_within_a_tick(run, truth)),
                 .upper = 0.02,
                 .bound_from = "wanted: 2 % of the largest force, from what explicit steps of every node go through "
                               "within a tick before or after"});
  outcome.judge({.name = "ticks_more_than_2_percent_from_explicit_steps",
                 .value = static_cast<double>(
                     std::ranges::count_if(errors(run, truth), [](double error) { return !(error <= 0.02); })),
                 .upper = 3.0,
                 .bound_from = "an event falls to the one or the other end of its step; no more than bench/stiff-needle allows"});

  Table table{.id = "far-fields",
              .title = "How much is left of the far field",
              .caption = "Seven layers of published moduli, 5 mm apart; the needle moves at 60 mm/s.",
              .columns = {"tissue", "loading (s)", "median tick (us)", "worst tick (us)",
                          "error over peak, within a tick (1)", "ticks above 2 % (1)"},
              .timing = true};
  table.rows.push_back(row_of("10 mm, 40 modes", run, truth));
  const auto add = [&](const std::string& name, const Scene& scene) {
    table.rows.push_back(row_of(name, insert_repeatedly(scene, repeats), truth));
  };
  if (!context.quick) {
    add("10 mm, 20 modes", with_far_field(whole, {0.01, 20}));
    add("15 mm, 40 modes", with_far_field(whole, {0.015, 40}));
    add("20 mm, 80 modes", with_far_field(whole, {0.02, 80}));
  }
  add("block of 9 x 9 nodes, held around", with_far_field(block_of(9, context.quick), {}));
  table.rows.push_back(row_of("every node, explicit steps, two threads", truth, truth));
  outcome.tables.push_back(table);
}

}  // namespace

std::vector<Case> far_field_cases() {
  return {{.name = "bench/far-field",
           .suite = "timing",
           .claim = "A needle in ligament of 15 MPa among 50 410 nodes takes less than every tick of 1 ms, with the "
                    "force within 2 % of its peak: what lies further than 10 mm away is left with 40 modes.",
           .measure = measure,
           .weight = 600.0}};
}

}  // namespace palpate::bench
