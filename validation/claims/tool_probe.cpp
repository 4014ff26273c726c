// SPDX-License-Identifier: MIT
/// Probes: continuum solutions, palpation of bone, sliding along the skin.

#include "model/problem/needle_path.hpp"
#include "model/tissue/network_builder.hpp"
#include "validation/claims/groups.hpp"
#include "validation/claims/tool_fixture.hpp"
#include "validation/palpation_map.hpp"

namespace palpate::tools {

namespace {

// Palpation: a blunt probe distributes its force, does not cut, and detects bone under fat.

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
  Figure& figure = outcome.plot("palpation-map", "Palpation map over a spinous process",
                                "Stiffness under a fingertip 10 mm wide: the process, 8 mm x 24 mm "
                                "of bone 10 mm under the skin, is felt through the fat.",
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

  // One site pressed in time must agree with its solve.
  scene.probe->entry = {0.0, 0.0};
  scene.drive = Drive{.speed = 1e-3, .depth = 1e-5};
  scene.simulation = {.duration = 1.0, .step = 1e-3};
  const auto [run, tool] = insert(context, scene, {.every = 1000, .energy = true});
  outcome.judge_near("pressed_stiffness_over_solved",
                     tool.back().forces.total / 1e-5 / (1e3 * over), 1.0, 2e-3,
                     "theory: the same springs; 10 um deep, strains of 1e-3");
}

/// A finger that presses fat over a spinous process that begins 10 mm below the skin, to 8 mm.
void measure_monotonic(const CaseContext& context, Outcome& outcome) {
  Scene scene = palpated_scene();
  scene.materials[0].poissons_ratio = 0.45;
  scene.materials[0].damping_ratio = 0.0;
  scene.materials[0].retardation_time = 1e-3;
  scene.drive = Drive{.speed = 0.05, .depth = 0.008};
  scene.simulation = {.duration = 0.16, .step = 1e-3, .integrator = "implicit-euler"};
  const SpringNetwork network = build_network(scene);
  const Trace trace = roll_out(context, scene, &network, {.every = 8, .cells = &network});
  const std::vector<double>& force = trace.values("tool.force_n");
  double least_rise = unbounded;
  for (std::size_t n = 1; n < force.size(); ++n) {
    least_rise = std::min(least_rise, force[n] - force[n - 1]);
  }
  outcome.judge_at_least("least_rise_in_8_ms", least_rise, 0.0,
                         "law: pressing tissue harder against bone never feels softer", "N");
  outcome.judge_at_least("smallest_corner_jacobian", trace.smallest_jacobian, 1e-3,
                         "law: no cell turns inside out");
}

}  // namespace

std::vector<Case> probe_cases() {
  return {
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
