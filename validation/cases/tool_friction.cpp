// SPDX-License-Identifier: MIT
/// The shaft alone: a tip that nothing resists, tissue that rubs.
#include <cmath>

#include "validation/cases/tool_setting.hpp"

namespace palpate::tools {

namespace {

constexpr double friction = 20.0;  // [N/m]

Scene rubbing_scene() {
  Scene scene = chain_scene({.stiffness = 2000.0});
  scene.materials = {tissue_of("rubbing", 1.0, 0.0, friction)};
  scene.tissue.layers = {{"rubbing", "rubbing", 0.05}};
  return scene;
}

void measure_loop(const CaseContext& context, Outcome& outcome) {
  Scene scene = rubbing_scene();
  const double depth = 0.012;
  scene.drive = Drive{.from = -0.001, .speed = 0.02, .depth = depth, .hold = 0.1,
                      .withdraw_speed = 0.02};
  const double h = 1e-5;
  scene.simulation = {.duration = 1.5, .step = h, .substeps = 1, .integrator = "velocity-verlet"};
  const Insertion run = insert_tool(context, scene);
  double area = 0.0;
  double largest = 0.0;
  double smallest = 0.0;
  double slid = 0.0;
  std::vector<double> place, force;
  for (std::size_t n = 0; n < run.tool.size(); ++n) {
    const ToolReport& now = run.tool[n];
    largest = std::fmax(largest, now.forces.friction);
    smallest = std::fmin(smallest, now.forces.friction);
    if (n > 0) {
      const ToolReport& last = run.tool[n - 1];
      area += 0.5 * h * (last.forces.friction * last.slip + now.forces.friction * now.slip);
      slid += 0.5 * (last.forces.total + now.forces.total) * (now.place - last.place);
    }
    if (n % 100 == 0) {
      place.push_back(1e3 * now.place);
      force.push_back(now.forces.total);
    }
  }
  const double lost = run.tool.back().losses.friction;
  outcome.judge({.name = "area_of_friction_over_slip_less_dissipation",
                 .value = std::abs(area / lost - 1.0),
                 .upper = 1e-3,
                 .bound_from = "theory: friction times slip is what is lost; trapezoids over 10 us "
                               "across two reversals"});
  outcome.judge({.name = "area_of_the_loop_over_dissipation",
                 .value = slid / lost,
                 .lower = 0.98,
                 .upper = 1.02,
                 .bound_from = "theory: a closed loop stores nothing; dampers and impacts take "
                               "less than 2 %"});
  outcome.judge({.name = "largest_friction_over_limit",
                 .value = largest / (friction * depth),
                 .upper = 1.0 + 1e-12,
                 .bound_from = "Coulomb: f times the length in tissue"});
  outcome.judge({.name = "asymmetry_of_the_loop",
                 .value = std::abs(largest + smallest) / largest,
                 .upper = 0.05,
                 .bound_from = "theory: the same limit both ways; tissue length differs by its "
                               "own strain, F/k of a spring"});
  Figure figure{.id = "loop",
                .title = "Friction of a shaft in and out",
                .caption = "In, rest, out: the loop's area is the energy that friction took.",
                .x = {.label = "place of the tip (mm)"},
                .y = {.label = "force (N)"}};
  figure.series = {curve("force on the needle", place, force)};
  outcome.figures.push_back(std::move(figure));
}

void measure_rest(const CaseContext& context, Outcome& outcome) {
  Scene scene = rubbing_scene();
  // Friction ends the push at 6 mm; the pull that follows is less than it can hold.
  const double pull = 0.05;
  scene.drive = Drive{.kind = Drive::Kind::force, .hold = 4.0, .force = 0.006 * friction,
                      .rise = 0.1, .withdraw_force = pull, .hand_viscosity = 5.0};
  const long ticks = context.quick ? 100000 : 1000000;
  scene.simulation = {.duration = 1e-3 * static_cast<double>(ticks), .step = 1e-3,
                      .integrator = "velocity-verlet"};
  const Insertion run = insert_tool(context, scene, {.every = ticks / 20});
  const double settled = run.tool[2].place;
  double creep = 0.0;
  for (std::size_t n = 3; n < run.tool.size(); ++n) {
    creep = std::fmax(creep, std::abs(run.tool[n].place - settled));
  }
  outcome.judge({.name = "creep",
                 .value = run.diverged ? std::nan("") : creep,
                 .unit = "m",
                 .upper = static_cast<double>(ticks) * 2.3e-16 * 0.02,
                 .bound_from = "law: a stuck shaft does not move; one rounding of a place of 20 mm "
                               "a tick"});
  outcome.judge({.name = "friction_at_rest",
                 .value = run.tool.back().forces.friction,
                 .unit = "N",
                 .lower = -pull - 1e-9,
                 .upper = -pull + 1e-9,
                 .bound_from = "balance: it carries the whole force of the hand"});
  outcome.judge({.name = "slip_at_rest",
                 .value = std::abs(run.tool.back().slip),
                 .unit = "m/s",
                 .upper = 1e-15,
                 .bound_from = "law: what sticks has no slip; rounding"});
}

}  // namespace

std::vector<Case> friction_cases() {
  return {{.name = "needle/friction/loop",
           .suite = "accuracy",
           .claim = "In and out, the force of the shaft draws a loop whose area is the energy lost.",
           .measure = measure_loop,
           .weight = 1.0},
          {.name = "needle/friction/rest",
           .suite = "accuracy",
           .claim = "Under less than its limit a shaft sticks and does not creep, however long.",
           .measure = measure_rest,
           .weight = 6.0}};
}

}  // namespace palpate::tools
