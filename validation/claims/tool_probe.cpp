// SPDX-License-Identifier: MIT
/// Probes: continuum solutions, palpation of bone, sliding along the skin.

#include <functional>
#include <numbers>

#include "model/problem/needle_path.hpp"
#include "model/tissue/network_builder.hpp"
#include "reference/static_equilibrium.hpp"
#include "validation/claims/groups.hpp"
#include "validation/claims/tool_fixture.hpp"
#include "validation/number_text.hpp"
#include "validation/palpation_map.hpp"
#include "validation/signal.hpp"

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

/// A finger that presses fat over a spinous process that begins 12 mm below the skin, to 10 mm.
void measure_monotonic(const CaseContext& context, Outcome& outcome) {
  Scene scene = palpated_scene();
  scene.materials[0].poissons_ratio = 0.45;
  scene.materials[0].damping_ratio = 0.0;
  scene.materials[0].retardation_time = 1e-3;
  scene.tissue.inclusions[0].centre.z() = 0.020;
  scene.drive = Drive{.speed = 0.05, .depth = 0.010};
  scene.simulation = {.duration = 0.2, .step = 1e-3, .integrator = "implicit-euler"};
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

// Continuum: a rigid disc on gel, in steps that end at rest.

constexpr double gel_modulus = 1e4;
constexpr double disc = 0.0075;  ///< radius [m]

constexpr double skin_modulus = 1e6;
constexpr double skin_nu = 0.48;

/// Disc on a block of gel that is bonded to a rigid base, with free sides.
struct Gel {
  double nu = 0.25;
  double thickness = 0.012;
  double half_width = 0.036;
  double skin = 0.0;  ///< thickness of the part of it that is skin [m]
};

Scene disc_on_gel(const Gel& gel, double spacing) {
  const auto cells = [&](double length) { return static_cast<int>(std::lround(length / spacing)); };
  const int across = 2 * cells(gel.half_width) + 1;
  Scene scene;
  scene.tissue.source = Source::lattice;
  scene.tissue.fixed = {Face::z_max};
  scene.tissue.lattice = {
      .nodes = {across, across, cells(gel.thickness) + 1}, .spacing = spacing, .material = "gel"};
  scene.materials = {tissue_of("gel", gel_modulus, 1.0, 0.0)};
  scene.materials[0].poissons_ratio = gel.nu;
  scene.materials[0].damping_ratio = 0.0;
  scene.materials[0].retardation_time = 1e-3;
  if (gel.skin > 0.0) {
    scene.materials.push_back(scene.materials[0]);
    scene.materials[1].name = "skin";
    scene.materials[1].youngs_modulus = skin_modulus;
    scene.materials[1].poissons_ratio = skin_nu;
    scene.tissue.source = Source::layers;
    scene.tissue.block = {.nodes = {across, across}, .spacing = spacing};
    scene.tissue.layers = {{"skin", "skin", gel.skin}, {"gel", "gel", gel.thickness - gel.skin}};
  }
  scene.probe = Probe{.size = {2.0 * disc, 2.0 * disc}};
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
  // A face twice as long as wide, along x and along y of a square block.
  Scene gel = disc_on_gel({}, 0.006);
  constexpr double depth = 1e-4;
  gel.drive = Drive{.speed = depth / 0.1, .depth = depth, .hold = 1.0};
  gel.simulation = {.duration = 0.4, .step = 0.1, .integrator = "implicit-euler"};
  const auto force = [&](double along_x, double along_y) {
    gel.probe = Probe{.shape = Probe::Shape::ultrasound, .size = {along_x, along_y}};
    return insert(context, gel).tool.back().forces.total;
  };
  outcome.judge_near("force_of_a_turned_face_over_unturned",
                     force(0.024, 0.012) / force(0.012, 0.024), 1.0, 1e-10,
                     "symmetry: x and y of a square block are alike; rounding of a solve whose "
                     "condition number is below 1e6");
}

/// Force over insertion of a face that rests on gel at a thousandth of the radius of the disc.
double face_stiffness(const CaseContext& context, const Gel& gel, double spacing,
                      const Probe& face) {
  Scene scene = disc_on_gel(gel, spacing);
  scene.probe = face;
  constexpr double depth = 1e-3 * disc;
  scene.drive = Drive{.speed = depth / 0.1, .depth = depth, .hold = 1.0};
  // Ticks that are long against the periods of the gel: each reduces the motion to a hundredth.
  scene.simulation = {.duration = 0.4, .step = 0.1, .integrator = "implicit-euler"};
  return insert(context, scene).tool.back().forces.total / depth;
}

double disc_stiffness(const CaseContext& context, const Gel& gel, double spacing) {
  return face_stiffness(context, gel, spacing, Probe{.size = {2.0 * disc, 2.0 * disc}});
}

/// A square face of the area of a disc against the disc, on a deep block. The pressure is that of
/// the charge of a plate, whose capacitance is 0.36679 times its side (F. H. Read, J. Comput. Phys.
/// 133, 1, 1997) and 2 / pi times the radius of a disc.
void judge_square(const CaseContext& context, const Gel& gel, double spacing, double of_disc,
                  Outcome& outcome) {
  const double side = disc * std::sqrt(std::numbers::pi);
  const Probe square{.shape = Probe::Shape::ultrasound, .size = {side, side}};
  outcome.judge_near("stiffness_of_a_square_face_over_a_disc",
                     face_stiffness(context, gel, spacing, square) / of_disc, 1.0212, 0.01,
                     "continuum: a rigid square punch has 1.0212 times the stiffness of a disc of "
                     "its area (capacitance of a square plate, Read 1997); 1 % by the grid");
}

/// Disc of uniform pressure against the rigid disc on the same grid, for which grid and sides are
/// alike.
void judge_uniform(const CaseContext& context, const Gel& gel, double spacing, double of_disc,
                   Outcome& outcome) {
  const std::vector<reference::PunchLayer> layer{{gel.thickness, gel_modulus, gel.nu}};
  const reference::PunchFactor uniform = reference::uniform_pressure_on_layers(disc, layer);
  const reference::PunchFactor rigid = reference::punch_on_layers(disc, layer);
  const Probe face{.size = {2.0 * disc, 2.0 * disc}, .face = Probe::FaceKind::uniform};
  const double found = face_stiffness(context, gel, spacing, face);
  outcome.judge({.name = "error_of_the_stiffness_of_uniform_pressure_over_a_rigid_disc",
                 .value = found / of_disc * rigid.kappa / uniform.kappa - 1.0,
                 .lower = -0.01,
                 .upper = 0.01,
                 .bound_from =
                     "continuum: mean displacement under a uniform pressure (3 pi^2 E a / "
                     "(16 (1 - nu^2)) on a half space) over Hayes et al. 1972, both for "
                     "this depth; 1 % by the grid",
                 .uncertainty = uniform.uncertainty + rigid.uncertainty});
}

// Spherical fingertip, flat enough for small strains.

constexpr double tip_radius = 100.0 * disc;
constexpr int dents = 3;  ///< the last with the whole face in contact
constexpr double dent_step = 0.4 * disc * disc / tip_radius;

/// Forces of a fingertip that rests at one, two and three steps of the dent [N].
std::vector<double> sphere_forces(const CaseContext& context, const Gel& gel, double spacing) {
  Scene scene = disc_on_gel(gel, spacing);
  scene.probe->tip_radius = tip_radius;
  scene.drive = Drive{.technique = Drive::Technique::intermittent,
                      .speed = dent_step / 0.1,
                      .advance = dent_step,
                      .pause = 0.6,
                      .depth = dents * dent_step};
  scene.simulation = {.duration = 0.7 * dents, .step = 0.1, .integrator = "implicit-euler"};
  const std::vector<ToolReport> tool = insert(context, scene).tool;
  std::vector<double> forces;
  for (std::size_t n = 1; n <= dents; ++n) { forces.push_back(tool.at(7 * n).forces.total); }
  return forces;
}

/// Compares a fingertip with the sphere of Hayes et al. on grids whose rigid disc has the stiffness
/// `of_disc`.
void judge_sphere(const CaseContext& context, const Gel& gel, const std::vector<double>& spacings,
                  const std::vector<double>& of_disc, double sides, Table& table,
                  Outcome& outcome) {
  const std::vector<reference::PunchLayer> layer{{gel.thickness, gel_modulus, gel.nu}};
  const double plane = gel_modulus / (1.0 - gel.nu * gel.nu);
  const double punch = reference::punch_on_layers(disc, layer).kappa * 2.0 * plane * disc;
  Largest worst;
  Largest apart;
  Largest uncertainty;
  std::vector<reference::SphereForce> truth;
  for (int k = 1; k <= dents; ++k) {
    truth.push_back(reference::sphere_on_layers(k * dent_step,
                                                {.radius = disc, .tip_radius = tip_radius}, layer));
    uncertainty.add(truth.back().uncertainty);
  }
  for (std::size_t n = 0; n < spacings.size(); ++n) {
    const std::vector<double> found = sphere_forces(context, gel, spacings[n]);
    for (std::size_t k = 0; k < found.size(); ++k) {
      const double dent = static_cast<double>(k + 1) * dent_step;
      const double hertz = 4.0 / 3.0 * plane * std::sqrt(tip_radius) * std::pow(dent, 1.5);
      const double error = found[k] / truth[k].force - 1.0;
      worst.add(std::abs(error));
      apart.add(std::abs((1.0 + error) * punch / of_disc[n] - 1.0));
      table.rows.push_back({gel.nu, 1e3 * spacings[n], 1e6 * dent, truth[k].contact_radius / disc,
                            1e3 * hertz, 1e3 * truth[k].force, 1e3 * found[k], 100.0 * error});
    }
  }
  const std::string name = "_nu_" + plain_number(gel.nu, 2);
  outcome.judge({.name = "largest_error_of_a_sphere" + name,
                 .value = worst.value(),
                 .upper = 0.05,
                 .bound_from = "continuum: a sphere by the equation of Hayes et al. 1972, on every "
                               "grid and at every dent; uncertainty: its quadrature and the free "
                               "sides of the block",
                 .uncertainty = uncertainty.value() + sides});
  outcome.judge_at_most("largest_difference_of_a_sphere_from_the_disc" + name, apart.value(), 0.02,
                        "wanted: grid and sides change the force of a sphere as that of a disc, "
                        "whose errors are divided out");
}

/// Compares the stiffness of a disc on a ladder of spacings with Hayes' layer. Bounds are relative
/// to the truth.
void judge_ladder(const Gel& gel, const std::vector<double>& spacings,
                  const std::vector<double>& found, double sides, Table& table, Outcome& outcome) {
  const reference::PunchFactor factor = reference::punch_on_layer(disc / gel.thickness, gel.nu);
  const double half_space = 2.0 * gel_modulus * disc / (1.0 - gel.nu * gel.nu);
  const double truth = factor.kappa * half_space;
  for (std::size_t n = 0; n < spacings.size(); ++n) {
    table.rows.push_back({gel.nu, 1e3 * spacings[n], 2.0 * disc / spacings[n], half_space, truth,
                          found[n], 100.0 * (found[n] / truth - 1.0)});
  }
  const std::string name = "_nu_" + plain_number(gel.nu, 2);
  Largest worst;
  for (const double stiffness : found) { worst.add(std::abs(stiffness / truth - 1.0)); }
  outcome.judge({.name = "largest_error" + name,
                 .value = worst.value(),
                 .upper = 0.05,
                 .bound_from = "continuum: Hayes et al. 1972, on every grid; uncertainty: its "
                               "quadrature and the free sides of the block",
                 .uncertainty = factor.uncertainty / factor.kappa + sides});
  const double index = grid_convergence(spacings, found).index;
  outcome.judge_at_most("error_on_the_finest_grid" + name, std::abs(found.back() / truth - 1.0),
                        index + sides + 1e-3,
                        "theory: the grid convergence index of three grids, the free sides, and "
                        "0.1 % for a pressure of few terms");
  outcome.judge_at_most("grid_convergence_index" + name, index, 0.03,
                        "wanted: forces that no longer depend on the grid");
}

/// A disc on stiff skin over gel: its pressure concentrates at the rim.
void judge_skin(const CaseContext& context, Outcome& outcome) {
  const Gel gel{.nu = 0.49, .skin = 0.001};
  const reference::PunchFactor factor = reference::punch_on_layers(
      disc, {{gel.skin, skin_modulus, skin_nu}, {gel.thickness - gel.skin, gel_modulus, gel.nu}});
  const double truth = factor.kappa * 2.0 * skin_modulus * disc / (1.0 - skin_nu * skin_nu);
  Largest worst;
  for (const double spacing : {0.004, 0.003, 0.002}) {
    if (context.quick && spacing < 0.003) { continue; }
    worst.add(std::abs(disc_stiffness(context, gel, spacing) / truth - 1.0));
  }
  Gel wide = gel;
  wide.half_width *= 5.0 / 3.0;
  const double sides =
      2.0 *
      std::abs(disc_stiffness(context, wide, 0.004) / disc_stiffness(context, gel, 0.004) - 1.0);
  outcome.judge({.name = "largest_error_on_skin",
                 .value = worst.value(),
                 .upper = 0.02,
                 .bound_from = "continuum: Hayes' integral equation for layers, on every grid, to "
                               "less than half of the 4.7 % that a skin 20 % softer changes; "
                               "uncertainty: its quadrature and the free sides of the block",
                 .uncertainty = factor.uncertainty / factor.kappa + sides});
}

void measure_disc(const CaseContext& context, Outcome& outcome, bool thin) {
  Table& table = outcome.table(
      "grids", "Stiffness of a rigid disc on gel",
      "Disc of 15 mm, E = 10 kPa; truth: W. C. Hayes et al., J. Biomech. 5, 541, 1972, solved anew "
      "for this ratio of radius to thickness.",
      {"nu", "spacing (mm)", "cells across the disc", "half space (N/m)", "truth (N/m)",
       "found (N/m)", "error (%)"});
  Table& spheres = outcome.table(
      "spheres", "Force of a spherical fingertip on gel",
      "Sphere of 0.75 m with a face of 15 mm; truth: the sphere of Hayes et al. 1972 for this "
      "thickness. Hertz's force is that of a half space, without an end of the face.",
      {"nu", "spacing (mm)", "dent (um)", "contact radius over the face's", "Hertz (mN)",
       "truth (mN)", "found (mN)", "error (%)"});
  for (const double nu : {0.25, 0.49}) {
    Gel gel{.nu = nu};
    std::vector<double> spacings{0.006, 0.004, 0.003, 0.002};
    if (!thin) {
      gel = {.nu = nu, .thickness = 0.045, .half_width = 0.0675};
      spacings = {0.01125, 0.0075, 0.005625, 0.0045};
    }
    if (context.quick) { spacings.pop_back(); }
    std::vector<double> found;
    for (const double spacing : spacings) {
      found.push_back(disc_stiffness(context, gel, spacing));
    }
    // The free sides: twice the change with two thirds more width, on the coarsest grid.
    Gel wide = gel;
    wide.half_width *= 5.0 / 3.0;
    const double sides =
        2.0 * std::abs(disc_stiffness(context, wide, spacings[0]) / found[0] - 1.0);
    judge_ladder(gel, spacings, found, sides, table, outcome);
    const double finest = spacings.back();
    outcome.report("effect_of_the_sides_nu_" + plain_number(nu, 2), sides);
    const std::size_t spheres_on = context.quick ? 2 : spacings.size();  // the coarsest
    spacings.resize(spheres_on);
    judge_sphere(context, gel, spacings, found, sides, spheres, outcome);
    if (!thin && nu == 0.25) {
      judge_square(context, gel, finest, found.back(), outcome);
      judge_uniform(context, gel, spacings.front(), found.front(), outcome);
    }
  }
  if (thin) { judge_skin(context, outcome); }
}

// Sliding: the face moves along the skin at a depth of 1 mm.

/// Force of a probe that is at its depth, at each tick of its slide.
struct Slide {
  std::vector<double> x{};  ///< [m]
  std::vector<double> force{};
};

Slide slide(const CaseContext& context, Scene scene, const Eigen::Vector2d& from,
            const Eigen::Vector2d& to) {
  constexpr double speed = 0.02;
  const double begin = 0.1;
  const double end = begin + (to - from).norm() / speed;
  scene.probe->path = {{begin, from.x(), from.y()}, {end, to.x(), to.y()}};
  scene.drive = Drive{.speed = 0.05, .depth = 1e-3, .hold = 10.0};
  scene.simulation = {.duration = end, .step = 5e-3, .integrator = "implicit-euler"};
  const Trace trace = roll_out(context, scene, {.tool = true});
  Slide found;
  for (std::size_t n = 0; n < trace.rows(); ++n) {
    if (trace.time[n] < begin - 1e-9) { continue; }
    found.x.push_back(trace.at("probe.x_m", n));
    found.force.push_back(trace.at("tool.force_n", n));
  }
  return found;
}

void measure_slide(const CaseContext& context, Outcome& outcome) {
  constexpr double spacing = 0.004;
  const Scene scene = disc_on_gel({.nu = 0.45, .half_width = 0.052}, spacing);
  const Eigen::Vector2d from(-0.009, -0.003);
  const Eigen::Vector2d to(0.009, 0.003);
  const Slide there = slide(context, scene, from, to);
  // The compliance that the grid lacks is that of the first place; the grid's own compliance under
  // the face depends on its place between nodes.
  Largest most;
  Smallest least;
  for (int n = 0; n < 16; ++n) {
    Scene still = scene;
    still.probe->entry = spacing / 6.0 * Eigen::Vector2d(n % 4, n / 4);
    const SpringNetwork network = build_network(still);
    const TipCompliance tip = NeedlePath(still, network).tip_compliance(still, network);
    most.add(tip.grid / tip.continuum);
    least.add(tip.grid / tip.continuum);
  }
  const double spread = most.value() - least.value();
  double mean = 0.0;
  for (const double force : there.force) {
    mean += force / static_cast<double>(there.force.size());
  }
  Largest away;
  Largest jump;
  for (std::size_t n = 0; n < there.force.size(); ++n) {
    away.add(std::abs(there.force[n] / mean - 1.0));
    if (n > 0) { jump.add(std::abs(there.force[n] - there.force[n - 1]) / mean); }
  }
  outcome.report("spread_of_the_grid_compliance", spread);
  outcome.judge_at_most("largest_change_of_force", away.value(), spread + 2e-3,
                        "theory: the spread of the grid's compliance over the places of the face "
                        "between nodes; 0.2 % for inertia and the free sides");
  const double step = (there.x[1] - there.x[0]) / spacing * std::hypot(1.0, 1.0 / 3.0);
  outcome.judge_at_most("largest_jump_of_force", jump.value(), 2.0 * spread * 3.1416 * step + 2e-4,
                        "theory: weights change in proportion to the way; twice the steepest slope "
                        "of a wave of that spread and of a spacing's length");
  // Symmetry: the mirrored path gives the same force, and a shift by a spacing only moves the face
  // nearer to a side, of a layer of 12 mm that is 104 mm wide.
  const Slide mirrored = slide(context, scene, -from, -to);
  const Slide shifted = slide(context, scene, from + Eigen::Vector2d(spacing, 0.0),
                              to + Eigen::Vector2d(spacing, 0.0));
  Largest mirror;
  Largest shift;
  for (std::size_t n = 0; n < there.force.size(); ++n) {
    mirror.add(std::abs(mirrored.force[n] - there.force[n]) / mean);
    shift.add(std::abs(shifted.force[n] - there.force[n]) / mean);
  }
  outcome.judge_at_most("difference_on_the_mirrored_path", mirror.value(), 1e-9,
                        "symmetry; tolerance of the solver");
  outcome.judge_at_most("difference_on_a_path_shifted_by_a_spacing", shift.value(), 2e-3,
                        "invariance; the sides of the block");

  // Over bone under fat: the process, 8 mm wide along x, is at x = 0.
  const Slide over = slide(context, palpated_scene(), {-0.022, 0.0}, {0.022, 0.0});
  const double top = *std::ranges::max_element(over.force);
  const double bottom = std::max(over.force.front(), over.force.back());
  double weight = 0.0;
  double moment = 0.0;
  double width = 0.0;
  for (std::size_t n = 1; n < over.force.size(); ++n) {
    const double excess = std::max(0.0, over.force[n] - 0.5 * (top + bottom));
    weight += excess;
    moment += excess * over.x[n];
    if (excess > 0.0) { width += over.x[n] - over.x[n - 1]; }
  }
  outcome.judge_at_least("force_over_bone_to_beside_it", top / bottom, 1.2,
                         "a finger resolves a tenth to a fifth of stiffness");
  outcome.judge_at_most("distance_of_the_felt_from_the_true_middle", std::abs(moment / weight),
                        1e-4, "the scene is symmetric, and the tissue follows the probe by 0.1 mm",
                        "m");
  outcome.judge_between("width_of_what_is_felt", width, 0.008, 0.008 + 0.010 + 0.008,
                        "between the bone, and the bone, the face and two spacings", "m");
  Figure& figure = outcome.plot("slide", "Force of a probe that slides over a spinous process",
                                "At 1 mm depth and 20 mm/s; bone, 8 mm wide, begins 10 mm below "
                                "the skin.",
                                {"x (mm)"}, {"force (N)"});
  Series& line = figure.add("over bone under fat");
  for (std::size_t n = 0; n < over.x.size(); ++n) { line.add(1e3 * over.x[n], over.force[n]); }
}

}  // namespace

std::vector<Case> probe_cases() {
  return {
      {"probe/half-space", "accuracy",
       "A rigid disc on a deep block has the stiffness of a flat punch, 2 E a / (1 - nu^2) times "
       "Hayes' factor for its depth, on every grid; a uniform pressure and a sphere have theirs.",
       std::bind(measure_disc, std::placeholders::_1, std::placeholders::_2, false), 20.0},
      {"probe/slide", "accuracy",
       "A probe that slides over homogeneous gel at constant depth has a constant force, and bone "
       "below fat is felt where it lies.",
       measure_slide, 4.0},
      {"probe/layer", "accuracy",
       "A rigid disc on a layer over rigid ground, also with a stiff skin, has the stiffness of "
       "Hayes et al. 1972, on every grid, and a sphere its force.",
       std::bind(measure_disc, std::placeholders::_1, std::placeholders::_2, true), 10.0},
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
