// SPDX-License-Identifier: MIT
/// Insertions of a needle with force and cost of every tick.

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "validation/bench/bench_cases.hpp"
#include "validation/claims/tool_fixture.hpp"
#include "validation/number_text.hpp"
#include "validation/refinement.hpp"
#include "validation/roll_out.hpp"
#include "validation/signal.hpp"
#include "validation/statistics.hpp"

namespace palpate::bench {

namespace {

struct TimedInsertion {
  std::vector<double> force{};    ///< on the hand at every tick [N]
  std::vector<double> seconds{};  ///< of the processor, for every tick
  double loading = 0.0;           ///< [s] of the processor
  bool diverged = false;
};

TimedInsertion insert(const Scene& scene) {
  TimedInsertion run;
  const double start = seconds_on(Clock::processor);
  Simulation simulation(scene);
  run.loading = seconds_on(Clock::processor) - start;
  while (simulation.ticks() < simulation.tick_count() && !run.diverged) {
    const double begin = seconds_on(Clock::processor);
    run.diverged = simulation.tick() != StepStatus::ok;
    run.seconds.push_back(seconds_on(Clock::processor) - begin);
    run.force.push_back(simulation.tool().forces.total);
  }
  return run;
}

/// Takes the minimum of several runs at each tick, because the work of a tick is the same in every
/// run.
TimedInsertion insert_repeatedly(const Scene& scene, int repeats) {
  TimedInsertion least = insert(scene);
  for (int n = 1; n < repeats; ++n) {
    const TimedInsertion again = insert(scene);
    least.loading = std::min(least.loading, again.loading);
    for (std::size_t k = 0; k < std::min(least.seconds.size(), again.seconds.size()); ++k) {
      least.seconds[k] = std::min(least.seconds[k], again.seconds[k]);
    }
  }
  return least;
}

/// Returns the distance of each force from the range of `truth` within so many ticks, over its
/// peak; NaN if a run ended early.
std::vector<double> errors(const TimedInsertion& run, const TimedInsertion& truth,
                           std::size_t within = 0) {
  const std::vector<double>& force = truth.force;
  const double peak = std::ranges::max(force);
  std::vector<double> errors(force.size(), std::nan(""));
  for (std::size_t k = 0; k < std::min(run.force.size(), force.size()); ++k) {
    const std::size_t begin = k > within ? k - within : 0;
    const std::size_t end = std::min(k + within + 1, force.size());
    const auto [low, high] = std::ranges::minmax(std::span(force).subspan(begin, end - begin));
    errors[k] = std::abs(run.force[k] - std::clamp(run.force[k], low, high)) / peak;
  }
  return errors;
}

double largest(const std::vector<double>& values) {
  Largest most;
  for (const double value : values) { most.add(value); }
  return most.value();
}

double count_above(const std::vector<double>& errors, double limit) {
  return static_cast<double>(
      std::ranges::count_if(errors, [&](double error) { return !(error <= limit); }));
}

/// Returns the time that this share of the ticks does not exceed [us].
double ticks_within(const TimedInsertion& run, double share) {
  return 1e6 * comparison::quantile(run.seconds, share);
}

/// Median, hundredth and worst tick [us].
void add_times(const TimedInsertion& run, const std::string& of, Outcome& outcome) {
  for (const auto& [name, share] :
       {std::pair{"median_tick_", 0.5}, {"tick_of_a_hundred_", 0.99}, {"worst_tick_", 1.0}}) {
    outcome.timings.push_back({name + of, ticks_within(run, share), "us"});
  }
}

void judge_ticks(const TimedInsertion& run, double most, const char* from, Outcome& outcome) {
  outcome.judge_at_most("diverged", run.diverged ? 1.0 : 0.0, 0.0, "stable at ticks of 1 ms");
  outcome.judge_at_most("worst_tick", 1e6 * largest(run.seconds), most, from, "us");
}

// A needle through ligament of published modulus on 1000 nodes, an implicit step a tick: what the
// slowest tick costs on one core, and what the solver's tolerance does to the force.

/// 42.3 mm deep into a block of 10 x 10 x 10 nodes, and half a second of rest there.
Scene needle_scene(const CaseContext& context) {
  Scene scene = tools::seven_published_layers(10);
  scene.drive->depth = 0.0423;
  scene.simulation = {.duration = context.quick ? 0.6 : 2.6, .step = 1e-3};
  return scene;
}

void measure_stiff_needle(const CaseContext& context, Outcome& outcome) {
  Scene scene = needle_scene(context);
  scene.simulation.solver_tolerance = 1e-2;
  const TimedInsertion run = insert_repeatedly(scene, 9);
  judge_ticks(run, 250.0, "wanted: a quarter of the period of a loop of 1 kHz", outcome);
  add_times(run, "at_tolerance_0.01", outcome);
  scene.simulation.solver_tolerance = 0.0;
  const TimedInsertion solved = insert(scene);
  add_times(solved, "solved_to_rounding", outcome);
  outcome.judge_at_most(
      "force_error_of_the_tolerance_over_peak", largest(errors(run, solved)), 0.01,
      "wanted: 1 % of the largest force, against the same steps solved to rounding");
  scene.simulation.integrator = "velocity-verlet";
  // In a quick run the tip does not get beyond the interspinous ligament.
  outcome.judge_at_most("ticks_more_than_1_percent_from_explicit_steps",
                        count_above(errors(run, insert(scene)), 0.01), context.quick ? 2.0 : 3.0,
                        "a step sees a harder layer when it ends: one tick for each of the three");
}

// Needle in fifty thousand nodes with a reduced-order model away from it: cost of a tick and change
// of the force, compared with explicit steps of every node.

constexpr int across = 71;
constexpr int far_field_repeats = 2;
/// Explicit steps of every node take a second for each tick of 1 ms: the needle is quick, and the
/// run ends before it stops, for the jolt of that stop implicit Euler damps and explicit steps do
/// not.
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

std::vector<Cell> row_of(const std::string& name, const TimedInsertion& run,
                         const TimedInsertion& truth) {
  return {name,
          run.loading,
          ticks_within(run, 0.5),
          ticks_within(run, 1.0),
          largest(errors(run, truth, 1)),
          count_above(errors(run, truth), 0.02)};
}

void measure_far_field(const CaseContext& context, Outcome& outcome) {
  const Scene whole = block_of(across, context.quick);
  const TimedInsertion run = insert_repeatedly(with_far_field(whole, judged), far_field_repeats);
  judge_ticks(run, 1000.0, "wanted: the period of a loop of 1 kHz", outcome);
  add_times(run, "with_a_far_field", outcome);
  outcome.timings.push_back({"loading", run.loading, "s"});

  Scene reference = whole;
  reference.simulation.integrator = "velocity-verlet";
  reference.simulation.threads = 2;
  const TimedInsertion truth = insert(reference);
  outcome.judge_at_most("force_error_over_peak_within_a_tick", largest(errors(run, truth, 1)), 0.02,
                        "wanted: 2 % of the largest force, from what explicit steps of every node "
                        "go through within a tick before or after");
  outcome.judge_at_most("ticks_more_than_2_percent_from_explicit_steps",
                        count_above(errors(run, truth), 0.02), 3.0,
                        "an event falls to the one or the other end of its step; no more than "
                        "bench/stiff-needle allows");

  Table& table =
      outcome.table("far-fields", "How much is left of the far field",
                    "Seven layers of published moduli, 5 mm apart; the needle moves at 60 mm/s.",
                    {"tissue", "loading (s)", "median tick (us)", "worst tick (us)",
                     "error over peak, within a tick (1)", "ticks above 2 % (1)"});
  table.timing = true;
  table.rows.push_back(row_of("10 mm, 40 modes", run, truth));
  const auto add = [&](const std::string& name, const Scene& scene) {
    table.rows.push_back(row_of(name, insert_repeatedly(scene, far_field_repeats), truth));
  };
  if (!context.quick) {
    add("10 mm, 20 modes", with_far_field(whole, {0.01, 20}));
    add("15 mm, 40 modes", with_far_field(whole, {0.015, 40}));
    add("20 mm, 80 modes", with_far_field(whole, {0.02, 80}));
  }
  add("block of 9 x 9 nodes, held around", with_far_field(block_of(9, context.quick), {}));
  table.rows.push_back(row_of("every node, explicit steps, two threads", truth, truth));
}

// Error of the force by all sources together, against the cost of a tick, for our settings and for
// those of other simulators.

/// One way to simulate a scene.
struct Way {
  std::string name{};
  std::string source{};  ///< source of error that it removes from the shipped settings; or empty
  Scene scene{};
  int repeats = 2;
  Trace trace{};
  TimedInsertion run{};
};

/// Returns a scene whose block has `pieces` cells in place of one along each axis.
Scene with_finer_cells(Scene scene, double pieces) {
  LayerBlock& block = scene.tissue.block;
  for (int& nodes : block.nodes) {
    nodes = static_cast<int>(std::lround(pieces * (nodes - 1))) + 1;
  }
  block.spacing /= pieces;
  return scene;
}

/// Returns a scene with every node integrated.
Scene with_every_node(Scene scene, double tolerance, const std::string& integrator) {
  scene.simulation.near_radius = 0.0;
  scene.simulation.solver_tolerance = tolerance;
  scene.simulation.solver_corrections = 0;
  scene.simulation.integrator = integrator;
  return scene;
}

/// The shipped scene, with its needle at 30 mm/s so that explicit steps of every node take seconds.
std::optional<Scene> insertion_of(const CaseContext& context, const std::string& name) {
  if (!context.shipped_scene) { return {}; }
  std::optional<Scene> scene = context.shipped_scene(name);
  if (!scene) { return {}; }
  constexpr double quick_needle = 0.03;  // [m/s]
  if (scene->needle && scene->drive->speed < quick_needle) {
    scene->simulation.duration *= scene->drive->speed / quick_needle;
    scene->drive->speed = quick_needle;
  }
  if (context.quick) { scene->simulation.duration *= 0.1; }
  scene->records.clear();
  scene->output.frames = 0;
  return scene;
}

std::vector<Way> ways_of(const Scene& shipped) {
  const std::string implicit = "implicit-euler";
  Scene halved = shipped;
  halved.simulation.substeps = 2;
  Scene doubled = shipped;
  doubled.simulation.step *= 2.0;
  Scene solved = shipped;
  solved.simulation.solver_tolerance = 0.0;
  solved.simulation.solver_corrections = 0;
  const double tolerance = shipped.simulation.solver_tolerance;
  std::vector<Way> ways{{.name = "shipped", .scene = shipped, .repeats = 5},
                        {.name = "two steps a tick", .source = "step", .scene = halved},
                        {.name = "ticks of twice the length", .scene = doubled, .repeats = 5},
                        {.name = "solved to rounding", .source = "solver", .scene = solved},
                        {.name = "every node",
                         .source = "reduced-order model",
                         .scene = with_every_node(shipped, tolerance, implicit)},
                        {.name = "every node, implicit Euler, solved to rounding",
                         .scene = with_every_node(shipped, 0.0, implicit)},
                        {.name = "every node, semi-implicit Euler",
                         .scene = with_every_node(shipped, 0.0, "euler-cromer"),
                         .repeats = 1}};
  if (shipped.tissue.source == Source::layers) {
    ways.push_back({.name = "half the spacing", .scene = with_finer_cells(shipped, 2.0)});
    ways.push_back(
        {.name = "twice the spacing", .scene = with_finer_cells(shipped, 0.5), .repeats = 5});
  }
  return ways;
}

/// Explicit steps of more springs than this take minutes.
constexpr double most_spring_steps = 5e10;

/// Returns how many times the steps of a run evaluate a spring.
double spring_steps(const Scene& scene) {
  const Simulation simulation(scene);
  return static_cast<double>(simulation.tick_count()) * simulation.plan().substeps *
         static_cast<double>(simulation.spring_count());
}

void simulate(const CaseContext& context, Way& way) {
  way.run = insert_repeatedly(way.scene, way.repeats);
  way.trace = roll_out(context, way.scene, {});
}

/// Difference of a run from another.
struct Distance {
  double curve = std::nan("");  ///< root mean square with events aligned, as a share of the peak
  double peak = std::nan("");   ///< of the largest forces, as a share
  double shift = std::nan("");  ///< of the event that moved most along the needle [mm]
};

/// Returns the distance of two runs: NaN if one ended early, and for the shift if one lacks an
/// event of the other.
Distance distance_of(const Way& way, const Way& other) {
  if (way.run.diverged || other.run.diverged) { return {}; }
  const auto difference = difference_of(way.trace, other.trace);
  if (!difference) { return {}; }
  Distance distance{.curve = difference->curve, .peak = difference->peak};
  if (difference->extra_events > 0) { return distance; }
  double shift = 0.0;
  for (const MovedEvent& event : difference->events) {
    if (!event.refined_place) { return distance; }
    shift = std::max(shift, 1e3 * std::abs(*event.refined_place - event.place));
  }
  distance.shift = shift;
  return distance;
}

/// Cell of a distance; runs cannot be compared if one ended early, or shifts if it lacks an event.
Cell cell_of(double distance) {
  if (std::isnan(distance)) { return std::string("-"); }
  return distance;
}

/// Returns the grid convergence index (Roache 1994) from the change of the force between the coarse
/// and the middle grid and between the middle and the fine one, each of half the spacing: 1.25
/// times what the fine grid still lacks by the observed order, which counts as one at most; without
/// convergence three times the last change.
double convergence_index(double coarse, double fine) {
  if (!(coarse > fine)) { return 3.0 * fine; }
  const double order = std::min(std::log2(coarse / fine), 1.0);
  return 1.25 * fine / (std::exp2(order) - 1.0);
}

void measure_total_error(const std::string& name, const CaseContext& context, Outcome& outcome) {
  const std::optional<Scene> shipped = insertion_of(context, name);
  if (!shipped) {
    outcome.skip("the shipped scenes are not at hand");
    return;
  }
  std::vector<Way> ways = ways_of(*shipped);
  std::erase_if(ways, [&](const Way& way) {
    const double work = spring_steps(way.scene);
    if (work <= most_spring_steps) { return false; }
    outcome.notes.push_back("left out, with " + short_number(work) +
                            " evaluations of a spring: " + way.name);
    return true;
  });
  for (Way& way : ways) { simulate(context, way); }

  Table sources = make_table(
      "sources", "Sources of the error",
      "Difference of the shipped settings from the same scene with half the step, solved to "
      "rounding, and with every node integrated; and, where every node is integrated in four steps "
      "a tick, from half the spacing. Curve: root mean square of the force with events aligned. "
      "Both as a share of the peak.",
      {"source", "curve (1)", "peak (1)", "largest shift of an event (mm)"});
  const auto add_source = [&](const std::string& source, const Way& way, const Way& other) {
    const Distance distance = distance_of(way, other);
    sources.rows.push_back(
        {source, cell_of(distance.curve), cell_of(distance.peak), cell_of(distance.shift)});
    return distance.curve;
  };
  double numerical = 0.0;
  for (const Way& way : ways) {
    if (!way.source.empty()) { numerical += add_source(way.source, ways.front(), way); }
  }
  Scene finest = with_every_node(*shipped, 1e-4, "implicit-euler");
  finest.simulation.substeps = 4;
  Way reference{.name = "reference", .scene = finest, .repeats = 1};
  simulate(context, reference);
  const bool has_spacing = shipped->tissue.source == Source::layers;
  if (has_spacing) {
    const Way middle = reference;
    Way coarse{.scene = with_finer_cells(finest, 0.5), .repeats = 1};
    simulate(context, coarse);
    reference.scene = with_finer_cells(finest, 2.0);
    simulate(context, reference);
    const double index = convergence_index(distance_of(coarse, middle).curve,
                                           add_source("spacing", middle, reference));
    outcome.notes.push_back(
        "uncertainty of the reference by its spacing: " + short_number(100.0 * index) +
        " % of the peak (grid convergence index of three grids)");
  } else {
    outcome.notes.push_back(
        "the spacing is not varied: the error is that of the equations of these nodes");
  }
  outcome.judge_at_most("error_by_step_solver_and_reduction_over_peak", numerical, 0.02,
                        "wanted: 2 % of the peak, the sum of the three differences of the curve");
  judge_ticks(ways.front().run, 1e6 * shipped->simulation.step, "wanted: the period of a tick",
              outcome);

  Table table = make_table("ways", "Error of the force and cost of a tick",
                           std::string("Reference: ") + (has_spacing ? "half the spacing, " : "") +
                               "every node, four steps a tick, implicit Euler. Errors as in the "
                               "table of sources, by all sources together. Processor time of one "
                               "thread, the least of repeated runs.",
                           {"way", "curve (1)", "peak (1)", "largest shift of an event (mm)",
                            "mean tick (us)", "worst tick (us)", "of real time (1)"});
  table.timing = true;
  Figure figure = plot("error-cost", "Error against the mean tick",
                       "Lower and further left is better. Errors are against the reference of the "
                       "table; below its uncertainty they cannot be told apart.",
                       {.label = "processor time for 1 ms (us)", .logarithmic = true},
                       logarithmic("error of the force, all sources (1)"));
  figure.timing = true;
  struct Target {
    double error = 0.0;
    double cost = 0.0;
    std::string cheapest = "none of these";
  };
  std::array<Target, 3> targets{{{.error = 0.1}, {.error = 0.05}, {.error = 0.02}}};
  for (const Way& way : ways) {
    const Distance distance = distance_of(way, reference);
    const double mean = comparison::mean_of(way.run.seconds);
    const double cost = mean / way.scene.simulation.step;
    table.rows.push_back({way.name, cell_of(distance.curve), cell_of(distance.peak),
                          cell_of(distance.shift), 1e6 * mean, 1e6 * largest(way.run.seconds),
                          cost});
    if (distance.curve > 0.0) {
      figure.series.push_back({.label = way.name,
                               .style = Series::Style::points,
                               .x = {1e3 * cost},
                               .y = {distance.curve}});
    }
    for (Target& target : targets) {
      if (distance.curve <= target.error && (target.cost == 0.0 || cost < target.cost)) {
        target.cost = cost;
        target.cheapest = way.name;
      }
    }
  }
  for (const Target& target : targets) {
    outcome.notes.push_back("cheapest within " + short_number(100.0 * target.error) +
                            " %: " + target.cheapest);
  }
  outcome.tables.push_back(std::move(sources));
  outcome.tables.push_back(std::move(table));
  outcome.figures.push_back(std::move(figure));
}

// Cost of each tick of a scene, and error of the force by its tolerance and its reduced-order
// model.

void measure_scene(const Scene& given, const CaseContext& context, Outcome& outcome) {
  Scene scene = given;
  scene.output.frames = 0;
  const TimedInsertion run = insert_repeatedly(scene, context.quick ? 2 : 5);
  const auto worst = std::ranges::max_element(run.seconds) - run.seconds.begin();
  judge_ticks(run, 1e6 * scene.simulation.step, "wanted: the period of a tick", outcome);
  outcome.timings.push_back({"mean_tick", 1e6 * comparison::mean_of(run.seconds), "us"});
  add_times(run, "of_the_scene", outcome);
  outcome.timings.push_back({"loading", run.loading, "s"});
  outcome.notes.push_back("the worst tick ends at t = " +
                          short_number(scene.simulation.step * static_cast<double>(worst + 1)) +
                          " s");
  Scene whole = scene;
  whole.simulation.near_radius = 0.0;
  whole.simulation.solver_tolerance = 0.0;
  whole.simulation.solver_corrections = 0;
  whole.simulation.sleep_force = 0.0;
  whole.simulation.precision = Precision::double_precision;
  const TimedInsertion truth = insert(whole);
  const std::vector<double> off = errors(run, truth, 1);
  outcome.judge_at_most("share_of_ticks_more_than_2_percent_off",
                        count_above(off, 0.02) / static_cast<double>(off.size()), 0.01,
                        "wanted: 2 % of the largest force, against every node in double precision "
                        "solved to rounding; events may move by some ticks");
  outcome.judge_at_most("peak_force_off",
                        std::abs(std::ranges::max(run.force) / std::ranges::max(truth.force) - 1.0),
                        0.02, "wanted: 2 % of it");
}

}  // namespace

Case tick_case(const std::string& name, const Scene& scene) {
  return {
      "ticks/" + name,
      "timing",
      "Every tick of the scene takes less than its period, with a force within 2 % of the peak.",
      [scene](const CaseContext& context, Outcome& outcome) {
        measure_scene(scene, context, outcome);
      },
      60.0,
      true,
      false};
}

std::vector<Case> needle_cases() {
  std::vector<Case> cases{
      {"bench/stiff-needle", "timing",
       "A needle in ligament of 15 MPa on 1000 nodes takes at most a quarter of every tick of 1 "
       "ms, with the force within 1 % of its peak.",
       measure_stiff_needle, 30.0},
      {"bench/far-field", "timing",
       "A needle in ligament of 15 MPa among 50 410 nodes takes less than every tick of 1 ms, with "
       "the force within 2 % of its peak: what lies further than 10 mm away is left with 40 modes.",
       measure_far_field, 600.0}};
  for (const char* scene : {"epidural", "epidural-bmi-47", "paramedian", "palpation",
                            "mri-example/scene", "mesh-example/scene"}) {
    const std::string name(scene);
    cases.push_back({"bench/total-error/" + name.substr(0, name.find('/')), "timing",
                     "The force of a shipped scene is within 2 % of its peak but for the spacing, "
                     "and every tick takes less than its period.",
                     [name](const CaseContext& context, Outcome& outcome) {
                       measure_total_error(name, context, outcome);
                     },
                     300.0});
  }
  return cases;
}

}  // namespace palpate::bench
