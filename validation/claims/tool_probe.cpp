// SPDX-License-Identifier: MIT
/// Palpation: a blunt probe distributes its force, does not cut, and detects bone under fat.

#include <cmath>

#include "model/problem/needle_path.hpp"
#include "model/tissue/network_builder.hpp"
#include "validation/claims/groups.hpp"
#include "validation/claims/tool_fixture.hpp"
#include "validation/number_text.hpp"
#include "validation/palpation_map.hpp"

namespace palpate::tools {

namespace {

/// Fat over a spinous process: a box of bone 8 mm wide whose top lies 10 mm under the skin.
Scene palpated_scene() {
  Scene scene;
  scene.tissue.source = Source::lattice;
  scene.tissue.lattice = {.nodes = {17, 13, 7}, .spacing = 0.004, .material = "fat"};
  scene.materials = {tissue_of("fat", 9.1e3, 2.0, 20.0),
                     tissue_of("bone", 1e6, 0.0, 0.0, TissueRole::bone)};
  scene.tissue.inclusions = {{.shape = Inclusion::Shape::box,
                              .centre = {0.0, 0.0, 0.018},
                              .size = {0.008, 0.024, 0.016},
                              .material = "bone"}};
  scene.probe = Probe{.size = {0.010, 0.010}};
  scene.drive = Drive{.speed = 0.01, .depth = 0.002};
  return scene;
}

void measure_probe(const CaseContext& context, Outcome& outcome) {
  Scene scene = palpated_scene();
  scene.simulation = {.duration = 1.0, .step = 1e-3};
  const auto [run, tool] = insert(context, scene);
  Largest cutting;
  Largest friction;
  for (const ToolReport& t : tool) {
    cutting.add(std::abs(t.forces.cutting));
    friction.add(std::abs(t.forces.friction));
  }
  const std::string law = "law: a probe only presses";
  outcome.judge_at_most("cutting", cutting.value(), 0.0, law, "N");
  outcome.judge_at_most("friction", friction.value(), 0.0, law, "N");
  const NeedlePath path(scene, build_network(scene));
  double sum = 0.0;
  for (const auto& s : path.supports(path.knots().front())) { sum += s.weight; }
  outcome.judge_near("sum_of_the_shares", sum, 1.0, 1e-14,
                     "the footprint shares out the whole force");
}

void measure_map(const CaseContext& context, Outcome& outcome) {
  Scene scene = palpated_scene();
  const NetworkProblem problem(build_network(scene));
  const PalpationGrid grid = context.quick ? PalpationGrid{.sites = {7, 5}, .spacing = 0.008}
                                           : PalpationGrid{.sites = {13, 9}, .spacing = 0.004};
  const auto [columns, rows] = grid.sites;
  Figure figure = plot("palpation-map", "Palpation map over a spinous process",
                       "Stiffness under a fingertip 10 mm wide: the process, 8 mm x 24 mm of bone "
                       "10 mm under the skin, is felt through the fat.",
                       {"x (mm)"}, {"y (mm)"});
  figure.heat_map = palpation_map(scene, problem, grid);
  figure.square = true;
  const HeatMap& map = *figure.heat_map;
  const auto z = [&, n = columns](int i, int j) {
    return map.z[static_cast<std::size_t>(j * n + i)];
  };
  const double over = z(columns / 2, rows / 2);
  const double beside = z(0, rows / 2);
  outcome.judge_at_least(
      "stiffness_over_bone_to_beside_it", over / beside, 1.2,
      "a finger resolves a tenth to a fifth of stiffness (Weber share about 0.2)");
  Largest skew;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      skew.add(std::abs(z(i, j) - z(columns - 1 - i, rows - 1 - j)) / over);
    }
  }
  outcome.judge_at_most("asymmetry_of_the_map", skew.value(), 1e-9,
                        "the scene is symmetric; condition of the solve");

  outcome.figures.push_back(std::move(figure));

  // One site pressed in time must agree with its solve.
  scene.probe->entry = {0.0, 0.0};
  scene.drive = Drive{.speed = 1e-3, .depth = 1e-5};
  scene.simulation = {.duration = 1.0, .step = 1e-3};
  const auto [run, tool] = insert(context, scene, {.every = 1000, .energy = true});
  outcome.judge_near("pressed_stiffness_over_solved",
                     tool.back().forces.total / 1e-5 / (1e3 * over), 1.0, 2e-3,
                     "theory: the same springs; 10 um deep, strains of 1e-3");
}

/// Force over insertion of a needle that rests 20 um deep on gel 40 mm deep.
double stiffness_on_gel(const CaseContext& context, double nu, int gauge, double spacing) {
  Scene scene;
  const int cells = static_cast<int>(std::lround(0.04 / spacing));
  scene.tissue.source = Source::lattice;
  scene.tissue.lattice = {
      .nodes = {cells + 1, cells + 1, cells + 1}, .spacing = spacing, .material = "gel"};
  scene.materials = {tissue_of("gel", 1e4, 10.0, 0.0)};
  scene.materials[0].poissons_ratio = nu;
  scene.materials[0].damping_ratio = 0.0;
  scene.materials[0].retardation_time = 2e-3;
  scene.needle = Needle{.diameter = diameter_of_gauge(gauge).value()};
  constexpr double depth = 2e-5;
  scene.drive = Drive{.speed = 1e-3, .depth = depth, .hold = 1.0};
  scene.simulation = {.duration = 0.25, .step = 1e-3, .integrator = "implicit-euler"};
  return insert(context, scene, {.every = 250}).tool.back().forces.total / depth;
}

void measure_continuum(const CaseContext& context, Outcome& outcome) {
  Figure figure = plot("needle-stiffness", "Stiffness of a needle on gel before it cuts",
                       "Force over insertion at 20 um; lines: rigid flat punch on a half space, "
                       "2 E a / (1 - nu^2).",
                       {"outer diameter (mm)"}, {"stiffness (N/m)"});
  for (const double nu : {0.25, 0.49}) {
    Series line{.label = "half space, nu = " + plain_number(nu, 2)};
    for (const double spacing : {5e-3, 2.5e-3}) {
      if (spacing < 5e-3 && context.quick && nu > 0.25) { continue; }
      Series points{.label = plain_number(1e3 * spacing, 2) + " mm, nu = " + plain_number(nu, 2),
                    .style = Series::Style::points};
      Largest error;
      for (const int gauge : {14, 16, 18, 22, 27}) {
        if (spacing < 5e-3 && gauge != 14 && gauge != 27) { continue; }
        const double diameter = diameter_of_gauge(gauge).value();
        const double exact = 1e4 * diameter / (1.0 - nu * nu);
        const double found = stiffness_on_gel(context, nu, gauge, spacing);
        error.add(std::abs(found / exact - 1.0));
        points.add(1e3 * diameter, found);
        if (spacing == 5e-3) { line.add(1e3 * diameter, exact); }
      }
      outcome.judge_at_most(
          "error_" + plain_number(1e3 * spacing, 2) + "_mm_nu_" + plain_number(nu, 2),
          error.value(), 0.05,
          "continuum: rigid flat punch on a half space; the base 40 mm below "
          "stiffens by a / H = 2.6 %, free sides soften");
      figure.series.push_back(std::move(points));
    }
    figure.series.push_back(std::move(line));
  }
  outcome.figures.push_back(std::move(figure));
}

/// A finger that presses skin and fat over a spinous process to 8 mm.
void measure_monotonic(const CaseContext& context, Outcome& outcome) {
  Scene scene = palpated_scene();
  scene.materials[0].poissons_ratio = 0.45;
  scene.materials[0].damping_ratio = 0.0;
  scene.materials[0].retardation_time = 1e-3;
  scene.drive = Drive{.speed = 0.02, .depth = 0.008};
  scene.simulation = {.duration = 0.42, .step = 1e-3, .integrator = "implicit-euler"};
  const SpringNetwork network = build_network(scene);
  const Trace trace = roll_out(context, scene, &network, {.every = 20, .cells = &network});
  const std::vector<double>& force = trace.values("tool.force_n");
  double least_rise = unbounded;
  for (std::size_t n = 1; n < force.size(); ++n) {
    least_rise = std::min(least_rise, force[n] - force[n - 1]);
  }
  outcome.judge_at_least("least_rise_in_20_ms", least_rise, 0.0,
                         "law: pressing tissue harder against bone never feels softer", "N");
  outcome.judge_at_least("smallest_corner_jacobian", trace.smallest_jacobian, 1e-3,
                         "law: no cell turns inside out");
}

}  // namespace

std::vector<Case> probe_cases() {
  return {
      {"needle/continuum-stiffness", "accuracy",
       "A needle that has not cut has the stiffness of a rigid flat punch of its diameter on a "
       "half space, for gauges 14 to 27 and on every grid.",
       measure_continuum, 8.0},
      {"probe/over-bone", "accuracy",
       "The force of a finger that presses fat over bone never falls, and no cell of the tissue "
       "turns inside out.",
       measure_monotonic, 3.0},
      {"probe/spread", "accuracy",
       "A probe cuts nothing, rubs nothing and spreads its whole force.", measure_probe, 1.0},
      {"probe/palpation-map", "accuracy",
       "Bone under fat is felt from the skin: it is stiffer over the process than beside it.",
       measure_map, 4.0}};
}

}  // namespace palpate::tools
