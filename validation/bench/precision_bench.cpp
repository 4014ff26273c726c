// SPDX-License-Identifier: MIT
/// Error against run time on four scenes: one spring, a soft cube, seven layers under a needle, a stiff
/// ligament.
#include <algorithm>
#include <array>
#include <cmath>

#include "validation/bench/bench_cases.hpp"
#include "validation/bench/model_runs.hpp"
#include "validation/cases/tool_setting.hpp"

namespace palpate::bench {

namespace {

/// But the printed Feynman-Newton, which is an erratum.
const std::vector<std::string> all_schemes{"euler",          "euler-cromer",     "feynman-newton",
                                           "leapfrog",       "velocity-verlet",  "rk4",
                                           "implicit-euler", "implicit-midpoint"};
const std::vector<std::string> explicit_solvers{"cvode-adams", "arkode-dormand-prince-5-4", "gsl-rk8pd",
                                                "odeint-dormand-prince-5-4"};

/// Of the peak at the tool (docs/scenes.md).
constexpr double automatic_promise = 0.02;

/// What is asked of one scene.
struct Demand {
  double times_cheaper = 0.0;  ///< than others at a thousandth of the peak; 0: nothing
  /// At the end of S26: what semi-implicit Euler of any engine has (5.7338e-4 m for 5.7313e-4 m), to two
  /// digits.
  double error_at_end = unbounded;
};

/// Of "auto", and of one step of semi-implicit Euler a tick, which kernels are timed with.
void judge_end(const std::vector<Point>& points, double most, Outcome& outcome) {
  for (const Point& p : points) {
    const bool timed = p.method.starts_with("euler-cromer") && p.setting == "1 substep";
    if (p.far_field) { continue; }
    if (!timed && p.kind != Point::Kind::automatic) { continue; }
    outcome.judge({.name = "error_at_end_" + std::string(p.kind == Point::Kind::automatic  ? "auto"
                                                         : p.kind == Point::Kind::in_float ? "float"
                                                                                           : "double"),
                   .value = p.errors.tool_at_end,
                   .upper = most,
                   .bound_from = "what semi-implicit Euler of other engines has after 0.1 s, 4.3e-4"});
  }
}

void judge(const CaseContext& context, const Study& study, const Demand& demand, Outcome& outcome) {
  const std::vector<Point> points = measure_points(study, context.quick ? 0.1 : 0.6, context.quick ? 2 : 5);
  outcome.judge({.name = "floor_of_the_reference",
                 .value = study.truth.floor,
                 .upper = 1e-5,
                 .bound_from = "a tenth of the smallest error that is asked for"});
  outcome.judge({.name = "auto_over_quickest_as_accurate",
                 .value = automatic_over_best(points),
                 .upper = noise_of(points),
                 .bound_from =
                     "integrator = \"auto\" is on the frontier: the least of its run times over the median "
                     "of any setting in double that is as near, apart by no more than least and median "
                     "of one setting are in this table, or a tenth"});
  outcome.judge(
      {.name = "error_of_auto",
       .value = largest_error_of_automatic(points),
       .upper = automatic_promise,
       .bound_from = "what docs/scenes.md promises of integrator = \"auto\""});
  if (demand.times_cheaper > 0.0) {
    const Point* here = cheapest(points, 1e-3, true);
    const Point* there = cheapest(points, 1e-3, false);
    outcome.judge(
        {.name = "elsewhere_over_here_at_1e-3",
         .value = here != nullptr && there != nullptr ? there->seconds / here->seconds : std::nan(""),
         .lower = demand.times_cheaper,
         .bound_from = "asked of the project: so many times cheaper than the best of SUNDIALS, GSL and "
                       "odeint"});
  }
  if (std::isfinite(demand.error_at_end)) { judge_end(points, demand.error_at_end, outcome); }
  add_tables(points, study, outcome);
  add_figures(points, study, outcome);
}

/// A scene without a tool, against two solvers that share no method.
void judge_point(const CaseContext& context, Study study, int node,
                 const std::array<const char*, 2>& references, const Demand& demand, Outcome& outcome) {
  const PointScene point(context, study.scene, node);
  const reference::Tolerance tight{.relative = 1e-9, .position_scale = 1e-3, .velocity_scale = 1e-2};
  study.truth = truth_of(point.there(references[0], tight), point.there(references[1], tight));
  const reference::Tolerance scales{.position_scale = study.truth.travel,
                                    .velocity_scale = study.truth.travel / study.scene.simulation.duration};
  study.here = [&](const Scene& scene) { return point.here(scene); };
  study.there = [&](const std::string& solver, double tolerance) {
    reference::Tolerance wanted = scales;
    wanted.relative = tolerance;
    return point.there(solver, wanted);
  };
  judge(context, study, demand, outcome);
}

/// The paper's lightest damping (its Figs. 6-10): m = k = 1, c = 0.1, some four periods.
void measure_oscillator(const CaseContext& context, Outcome& outcome) {
  Study study;
  study.tool = "the mass";
  study.schemes = all_schemes;
  study.solvers = explicit_solvers;
  study.most_substeps = 256;
  study.scene.simulation = {.duration = 25.0, .step = 0.25};
  study.scene.tissue.source = Source::oscillator;
  judge_point(context, study, 0, {"modal", "arkode-fehlberg-7-8"}, {}, outcome);
}

/// 1000 nodes, 26 neighbours, one pulled; not stiff, so solvers with matrices have no part in it.
void measure_cube(const CaseContext& context, Outcome& outcome) {
  Study study;
  study.scene = s26_scene(10);
  study.tool = "the pulled node";
  study.schemes = all_schemes;
  study.solvers = explicit_solvers;
  study.most_substeps = context.quick ? 4 : 64;
  study.scene.simulation.substeps.reset();
  // Two and a half spacings; what its shapes lack is then half of what RK4 is off with one substep.
  study.reduction = {.near_radius = 0.025, .far_modes = 24};
  study.schemes_of_reduction = {"euler-cromer", "velocity-verlet", "rk4"};
  const int node = study.scene.loads.front().nodes.front();
  judge_point(context, study, node, {"arkode-fehlberg-7-8", "cvode-adams"},
              {.times_cheaper = 20.0, .error_at_end = 4.35e-4}, outcome);
}

/// A block of ligament with its published modulus: explicit schemes take some ten microseconds a step.
void measure_ligament(const CaseContext& context, Outcome& outcome) {
  Study study;
  study.tool = "the pushed node";
  study.schemes = all_schemes;
  study.solvers = explicit_solvers;
  study.solvers.emplace_back("cvode-bdf");
  if (!context.quick) { study.solvers.emplace_back("arkode-esdirk-5-4"); }
  study.most_substeps = context.quick ? 128 : 512;
  study.scene.simulation = {.duration = 0.02, .step = 1e-3};
  study.scene.tissue.lattice = {.nodes = {6, 6, 6}, .spacing = 0.002, .material = "interspinous-ligament"};
  study.scene.materials = {
      {.name = "interspinous-ligament", .youngs_modulus = 10e6, .density = 1130.0, .damping_ratio = 0.5}};
  constexpr int node = 3 * 6 + 3;
  study.scene.loads = {
      {.nodes = {node}, .force = {0.0, 0.0, 0.5}, .end = 0.015, .profile = Profile::half_sine}};
  judge_point(context, study, node, {"arkode-fehlberg-7-8", "cvode-bdf"}, {}, outcome);
}

/// Seven layers with moduli that explicit schemes can follow, at 20 mm/s; force at ticks that no jump is
/// near.
void measure_needle(const CaseContext& context, Outcome& outcome) {
  Study study;
  study.scene = tools::seven_soft_layers();
  study.schemes = all_schemes;
  // They keep velocities of half steps, which no tool can be felt with.
  std::erase(study.schemes, "leapfrog");
  std::erase(study.schemes, "feynman-newton");
  study.tool = "the force on the hand, but within two ticks of an event";
  study.solvers = {"cvode-adams with events as roots"};
  study.most_substeps = context.quick ? 64 : 256;
  study.scene.simulation = {.duration = context.quick ? 0.15 : 0.45, .step = 1e-3};
  const NeedleReference finest = needle_there(study.scene, 1e-10);
  study.truth = truth_of(finest.run, needle_there(study.scene, 1e-8).run, finest.jumps);
  study.here = [&](const Scene& scene) { return needle_here(context, scene); };
  study.there = [&](const std::string&, double tolerance) {
    return needle_there(study.scene, tolerance).run;
  };
  judge(context, study, {}, outcome);
}

Case precision_case(const std::string& scene, const std::string& claim,
                    void (*measure)(const CaseContext&, Outcome&)) {
  return {.name = "bench/precision/" + scene,
          .suite = "timing",
          .claim = claim,
          .measure = measure,
          .weight = 60.0};
}

}  // namespace

std::vector<Case> precision_cases() {
  return {
      precision_case(
          "oscillator",
          "On one spring, nothing in double is both quicker and nearer than what \"auto\" chooses.",
          measure_oscillator),
      precision_case(
          "cube",
          "The pulled cube of 1000 nodes is computed to a thousandth of its peak at a small part of "
          "what the best solver of another library takes for it, and \"auto\" is on the frontier.",
          measure_cube),
      precision_case("needle",
                     "Of seven layers under a needle, nothing in double is both quicker and nearer than what "
                     "\"auto\" chooses.",
                     measure_needle),
      precision_case("ligament",
                     "Of a stiff ligament, nothing in double is both quicker and nearer than what \"auto\" "
                     "chooses.",
                     measure_ligament)};
}

}  // namespace palpate::bench
