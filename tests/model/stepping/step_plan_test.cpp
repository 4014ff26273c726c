// SPDX-License-Identifier: MIT

#include "model/stepping/step_plan.hpp"

#include <algorithm>
#include <cmath>

#include "model/kernels/spring_kernels.hpp"
#include "model/stepping/simulation.hpp"
#include "model/stepping/stability.hpp"
#include "model/tissue/network_builder.hpp"
#include "tests/check.hpp"
#include "tests/model/sample_scenes.hpp"

namespace PALPATE_FILE {

using namespace palpate;

StepPlan plan_of(const Scene& scene, bool skip = true) {
  return plan_steps(scene, *make_problem(scene), skip);
}

bool mentions(const std::vector<std::string>& lines, std::string_view part) {
  return std::ranges::any_of(
      lines, [&](const std::string& line) { return line.find(part) != std::string::npos; });
}

TEST("auto picks velocity Verlet with enough substeps for soft tissue") {
  const StepPlan plan = plan_of(moving_scene("auto"));
  CHECK(plan.integrator->name == "velocity-verlet");
  CHECK(plan.h <= stability_margin * plan.stable_step.at("velocity-verlet"));
  CHECK_NEAR(plan.h * plan.substeps, 1e-3, 1e-18);
  CHECK_CONTAINS(plan.integrator_reason, "second order, explicit");
  CHECK_CONTAINS(plan.substeps_reason, "h stays below 0.5 of the stable step");
}

TEST("auto selects the implicit midpoint rule where explicit schemes need over 200 substeps") {
  Scene scene = moving_scene("auto");
  scene.tissue.lattice.stiffness = 1e8;
  const StepPlan plan = plan_of(scene);
  CHECK(plan.integrator->name == "implicit-midpoint");
  CHECK(plan.substeps == 1);
  CHECK_CONTAINS(plan.integrator_reason, "explicit schemes would need");
  CHECK(plan.substeps_reason == "an implicit scheme needs one");
}

TEST("auto takes more explicit substeps for many nodes than for few") {
  for (const bool many : {false, true}) {
    Scene scene;
    scene.tissue.lattice.nodes = {21, 21, many ? 21 : 3};
    scene.tissue.lattice.material = "stiff";
    scene.materials = {
        {.name = "stiff", .youngs_modulus = 60e6, .density = 1100.0, .damping_ratio = 0.5}};
    const NetworkProblem problem(build_network(scene));
    const StepPlan plan = plan_steps(scene, problem);
    CHECK(plan.integrator->implicit != many);
    CHECK(many == (plan.substeps > 200));
  }
}

TEST("a modulus below that of any tissue is warned of, because it was probably given in kPa") {
  Scene scene = moving_scene("auto");
  scene.materials.push_back({.name = "fat", .youngs_modulus = 24.0, .density = 950.0});
  const std::vector<std::string> warnings = plan_of(scene).warnings;
  CHECK(std::ranges::count(warnings,
                           "youngs_modulus of fat is 24 Pa, less than that of any "
                           "tissue; 1 kPa is 1000") == 1);
  scene.materials.back().youngs_modulus = 300.0;
  CHECK(plan_of(scene).warnings.size() == warnings.size() - 1);
}

TEST("a tool that moves past a tenth of a layer in a step is warned of, with enough substeps") {
  Scene scene = layered_scene();
  scene.simulation = {.duration = 1.0, .step = 0.1, .integrator = "implicit-euler"};
  scene.drive = Drive{.speed = 0.005, .depth = 0.03};
  const std::vector<std::string> warnings = plan_of(scene).warnings;
  const auto found = std::ranges::find_if(warnings, [](const std::string& line) {
    return line.starts_with("the tool moves by 0.5 mm in a step");
  });
  REQUIRE((found != warnings.end()));
  scene.simulation.substeps = std::stoi(found->substr(found->find("substeps = ") + 11));
  CHECK(!mentions(plan_of(scene).warnings, "the tool moves by"));
}

TEST("a speed and a depth beyond those of a hand are warned of, because they were probably in mm") {
  Scene scene = layered_scene();
  scene.drive = Drive{.speed = 0.005, .depth = 0.03};
  const std::size_t others = plan_of(scene).warnings.size();
  scene.drive = Drive{.speed = 5.0, .depth = 30.0};
  const std::vector<std::string> warnings = plan_of(scene).warnings;
  CHECK(warnings.size() == others + 2);
  CHECK(std::ranges::count(warnings,
                           "drive.speed is 5 m/s, more than a hand moves a needle; 1 mm/s is "
                           "0.001") == 1);
  CHECK(std::ranges::count(
            warnings, "drive.depth is 30 m, more than a hand moves a needle; 1 mm is 0.001") == 1);
}

TEST(
    "a skin that is dented deeper than it is thick gets the law of a large dent, or a "
    "warning") {
  Scene scene = layered_scene();
  scene.tissue.layers[0].thickness = 0.002;
  scene.materials[0].youngs_modulus = 1.5e6;
  scene.materials[0].cutting_force = 3.0;
  scene.materials[1].youngs_modulus = 20e3;
  scene.simulation.integrator = "implicit-euler";
  const Simulation simulation(scene);
  const DentTable& large = simulation.plan().tip.tables.at(0);
  CHECK(!mentions(simulation.plan().warnings, "is dented by about"));
  REQUIRE(large.linear_force.size() == 9);
  for (std::size_t n = 1; n < 9; ++n) { CHECK(large.linear_force[n] > large.linear_force[n - 1]); }
  CHECK(large.dent[8] < 0.9 * large.step * 8.0 * simulation.plan().tip.continuum);
  // Explicit schemes have the same law.
  scene.simulation.integrator = "velocity-verlet";
  const Simulation explicit_one(scene);
  const DentTable& same = explicit_one.plan().tip.tables.at(0);
  REQUIRE(same.linear_force.size() == 9);
  CHECK_NEAR(same.linear_force[8], large.linear_force[8], 1e-5 * large.linear_force[8]);
  const auto law_of = [&] {
    const std::vector<DentTable> tables = plan_of(scene).tip.tables;
    return tables.empty() ? 0 : tables.front().dent.size();
  };
  CHECK(law_of() == 9);
  scene.materials[0].cutting_force = 0.1;  // cut before the dent is as deep
  CHECK(law_of() == 0);
  CHECK(!mentions(plan_of(scene).warnings, "is dented by about"));
  scene.materials[0].cutting_force = 3.0;
  scene.materials[0].indentation_toe = 1e-3;  // a measured dent
  CHECK(law_of() == 0);
  scene.materials[0].indentation_toe = 0.0;
  scene.materials[0].youngs_modulus = 2.9 * scene.materials[1].youngs_modulus;
  CHECK(law_of() == 0);
  CHECK(mentions(plan_of(scene).warnings, "skin (2 mm) is dented by about"));
  scene.materials[0].youngs_modulus = 1.5e6;
  scene.materials[0].cutting_force = 300.0;  // would pierce layers as stiff as these
  CHECK(law_of() == 0);
  CHECK(mentions(plan_of(scene).warnings, "skin (2 mm) is dented by about"));
}

TEST("a thin membrane between softer layers gets the law of a large dent") {
  Scene scene = layered_scene();
  scene.materials = {{.name = "soft", .youngs_modulus = 2.4e3, .cutting_force = 0.01},
                     {.name = "membrane", .youngs_modulus = 12.2e6, .cutting_force = 2.0},
                     {.name = "bed", .youngs_modulus = 2.4e3, .cutting_force = 0.01}};
  scene.tissue.layers = {
      {"soft", "soft", 0.006}, {"membrane", "membrane", 0.0007}, {"bed", "bed", 0.0133}};
  scene.simulation.integrator = "implicit-euler";
  const auto laws = [&] { return plan_of(scene).tip.tables; };
  const Simulation simulation(scene);
  REQUIRE(simulation.plan().tip.tables.size() == 1);
  const DentTable& table = simulation.plan().tip.tables[0];
  const PathInterval layer = NeedlePath(scene, build_network(scene)).intervals()[table.interval];
  CHECK(layer.label == "membrane");
  CHECK_NEAR(layer.begin, 0.006, 1e-12);
  CHECK_NEAR(layer.end, 0.0067, 1e-12);
  CHECK(table.linear_force.size() == 9);
  scene.materials[1].stiffening = Stiffening{.rate = 4.0, .largest = 20.0};
  CHECK(laws().empty());
  scene.materials[1].stiffening = {};
  scene.materials[2].youngs_modulus = 5e6;  // no bed that gives way
  CHECK(laws().empty());
  scene.materials[2].youngs_modulus = 2.4e3;
  scene.materials[0].youngs_modulus = 5e6;
  CHECK(laws().empty());
  scene.materials[0].youngs_modulus = 2.4e3;
  scene.materials[1].cutting_force = 0.05;  // cut before the dent is as deep
  CHECK(laws().empty());
  scene.materials[1].cutting_force = 2.0;
  CHECK(laws().size() == 1);
  scene.tissue.layers[1].thickness = 1.1 * scene.tissue.block.spacing;  // the grid resolves it
  CHECK(laws().empty());
}

TEST("the number of substeps is the smallest that keeps the margin") {
  for (const char* name : {"euler-cromer", "leapfrog", "rk4", "velocity-verlet"}) {
    Scene scene = moving_scene(name);
    scene.tissue.lattice.stiffness = 2e4;
    const StepPlan plan = plan_of(scene);
    const double limit = plan.stable_step.at(name);
    CHECK(plan.substeps > 1);
    CHECK(1e-3 / plan.substeps <= stability_margin * limit);
    CHECK(1e-3 / (plan.substeps - 1) > stability_margin * limit);
  }
}

TEST("a given integrator and substeps are used, with a warning when they cannot be stable") {
  Scene scene = moving_scene("leapfrog");
  scene.simulation.substeps = 3;
  const StepPlan fine = plan_of(scene);
  CHECK(fine.substeps == 3);
  CHECK(fine.integrator->name == "leapfrog");
  CHECK(fine.integrator_reason == "set by the scene");
  CHECK(fine.warnings.empty());
  scene.tissue.lattice.stiffness = 1e7;
  CHECK(mentions(plan_of(scene).warnings, "is above the stable step"));
}

TEST("undamped Euler takes one step a tick, with the reason that none is stable and a warning") {
  Scene scene = moving_scene("euler");
  scene.simulation.substeps.reset();
  scene.tissue.lattice.viscosity = 0.0;
  const StepPlan plan = plan_of(scene);
  CHECK(plan.substeps == 1);
  CHECK(plan.substeps_reason == "no step is stable; one a tick");
  CHECK(mentions(plan.warnings, "expect divergence"));
}

TEST("implicit Euler says how it damps the first mode, with substeps that end the warning") {
  Scene scene = moving_scene("implicit-euler");
  scene.tissue.fixed = std::vector<Face>{Face::z_max};
  scene.tissue.lattice.viscosity = 0.01;
  const StepPlan plan = plan_of(scene);
  REQUIRE(plan.first_mode.has_value());
  CHECK_CONTAINS(plan.integrator_reason, "set by the scene; the tissue's first mode");
  CHECK(plan.stepped_damping_ratio > 2.0 * plan.first_mode->damping_ratio);
  REQUIRE(mentions(plan.warnings, "vibrations end too soon"));
  const std::string& text = plan.warnings.back();
  scene.simulation.substeps = std::stoi(text.substr(text.find("substeps = ") + 11));
  CHECK(!mentions(plan_of(scene).warnings, "vibrations end too soon"));
  --*scene.simulation.substeps;
  CHECK(mentions(plan_of(scene).warnings, "vibrations end too soon"));
  const StepPlan midpoint = plan_of(moving_scene("implicit-midpoint"));
  CHECK(!midpoint.first_mode.has_value());
  CHECK(midpoint.warnings.empty());
}

TEST("cells are compared with the force that cuts them, not with that of deeper tissue") {
  Scene scene = layered_scene();
  const std::string_view warning = "the tip presses the first cells";
  for (Material& material : scene.materials) { material.cutting_force = 1e-3; }
  CHECK(!mentions(plan_of(scene).warnings, warning));
  const auto cut = [&scene](const std::string& name, double force) {
    std::ranges::find(scene.materials, name, &Material::name)->cutting_force = force;
  };
  cut(scene.tissue.layers.back().material, 100.0);
  CHECK(!mentions(plan_of(scene).warnings, warning));
  cut(scene.tissue.layers.front().material, 100.0);
  CHECK(mentions(plan_of(scene).warnings, warning));
}

TEST("a plan warns of deep dents in tissue that hardly resists collapse") {
  Scene scene;
  scene.tissue.lattice = {.nodes = {7, 7, 7}, .spacing = 0.005, .material = "gel"};
  scene.materials = {{.name = "gel", .youngs_modulus = 1e4, .density = 1e3, .cutting_force = 0.09}};
  scene.needle = Needle{};
  scene.drive = Drive{.speed = 0.01, .depth = 0.01};
  const std::string_view warning = "its cells hardly resist collapse";
  Material& gel = scene.materials[0];
  CHECK(mentions(plan_of(scene).warnings, warning));
  gel.poissons_ratio = 0.45;
  CHECK(!mentions(plan_of(scene).warnings, warning));
  gel.poissons_ratio = 0.25;
  scene.drive->depth = 0.001;  // less than the needle's diameter
  CHECK(!mentions(plan_of(scene).warnings, warning));
  scene.drive->depth = 0.01;
  gel.youngs_modulus = 1e5;
  CHECK(!mentions(plan_of(scene).warnings, warning));
  scene.needle.reset();
  scene.probe = Probe{.size = {0.006, 0.006}};
  CHECK(mentions(plan_of(scene).warnings, warning));
  scene.drive->depth = 0.001;
  CHECK(!mentions(plan_of(scene).warnings, warning));
}

TEST("a plan warns of a spherical tip on a tissue whose materials are unknown") {
  Scene scene;
  scene.tissue.lattice = {.nodes = {7, 7, 7}, .spacing = 0.005, .material = "gel"};
  scene.materials = {{.name = "gel", .youngs_modulus = 1e4, .density = 1e3}};
  scene.probe = Probe{.size = {0.006, 0.006}, .tip_radius = 0.005};
  CHECK(!mentions(plan_of(scene).warnings, "probe.tip_radius has no effect"));
  CHECK(!plan_of(scene).tip.is_linear());
  scene.tissue.lattice.weights = LatticeWeights::uniform;
  scene.tissue.lattice.material.clear();
  CHECK(mentions(plan_of(scene).warnings, "probe.tip_radius has no effect"));
  CHECK(plan_of(scene).tip.is_linear());
}

TEST("a plan warns of layers that whole cells make deeper, and of thin bodies under a probe") {
  Scene scene = layered_scene();
  const std::string_view deeper = "mm deep and their";
  const std::string_view thin = "less than 2 cells";
  double depth = 0.0;
  for (const Layer& layer : scene.tissue.layers) { depth += layer.thickness; }
  scene.tissue.block.spacing = depth / 4.0;
  CHECK(!mentions(plan_of(scene).warnings, deeper));
  scene.tissue.block.spacing = depth / 4.3;  // four cells are 7 % less
  CHECK(mentions(plan_of(scene).warnings, deeper));
  scene.needle.reset();
  scene.probe = Probe{};
  const double spacing = scene.tissue.block.spacing;
  scene.tissue.inclusions = {{.shape = Inclusion::Shape::box,
                              .centre = {0.0, 0.0, 0.5 * depth},
                              .size = {1.9 * spacing, 3.0 * spacing, 3.0 * spacing},
                              .material = scene.materials[0].name}};
  Inclusion& body = scene.tissue.inclusions[0];
  CHECK(mentions(plan_of(scene).warnings, thin));
  body.size.x() = 2.1 * spacing;
  CHECK(!mentions(plan_of(scene).warnings, thin));
  body.shape = Inclusion::Shape::sphere;
  body.size.x() = 3.9 * spacing;
  CHECK(mentions(plan_of(scene).warnings, "less than 4 cells"));
  body.size.x() = 4.0 * spacing;
  CHECK(!mentions(plan_of(scene).warnings, "inclusion"));
}

TEST("a plan warns of a spherical tip that is pressed deep against its radius") {
  Scene scene = layered_scene();
  scene.needle.reset();
  scene.probe = Probe{.size = {0.012, 0.012}, .tip_radius = 0.01};
  scene.drive = Drive{.speed = 0.01, .depth = 0.0024};
  const std::string_view warning = "more than a quarter of probe.tip_radius";
  CHECK(!mentions(plan_of(scene).warnings, warning));
  scene.drive->depth = 0.0026;
  CHECK(mentions(plan_of(scene).warnings, warning));
  scene.probe->tip_radius = 0.013;  // its whole face is small against it
  CHECK(!mentions(plan_of(scene).warnings, warning));
}

TEST("a plan warns of a box under a probe whose faces lie between planes of nodes") {
  const std::string_view between = "of its edge from the next plane of nodes";
  Scene scene = layered_scene();
  scene.needle.reset();
  scene.probe = Probe{};
  const double spacing = scene.tissue.block.spacing;
  scene.tissue.block.nodes = {9, 9};
  scene.tissue.inclusions = {{.shape = Inclusion::Shape::box,
                              .centre = {0.0, 0.0, 3.0 * spacing},
                              .size = {4.0 * spacing, 4.0 * spacing, 4.0 * spacing},
                              .material = scene.materials[0].name}};
  Inclusion& body = scene.tissue.inclusions[0];
  CHECK(!mentions(plan_of(scene).warnings, between));
  body.centre.x() = 0.3 * spacing;  // 7.5 % of the edge
  CHECK(!mentions(plan_of(scene).warnings, between));
  body.centre.x() = 0.5 * spacing;
  CHECK(mentions(plan_of(scene).warnings, between));
  body.size.x() = 40.5 * spacing;  // ends outside the block
  CHECK(!mentions(plan_of(scene).warnings, between));
}

TEST("a plan warns of tissue whose stiffening makes the force of a dent depend on the spacing") {
  const auto dent_in = [](double rate, double spacing, double largest = 12.0) {
    Scene scene;
    scene.simulation = {
        .duration = 1.2, .step = 0.1, .integrator = "implicit-euler", .solver_tolerance = 1e-3};
    const int across = static_cast<int>(std::lround(0.016 / spacing)) + 1;
    scene.tissue.source = Source::layers;
    scene.tissue.block = {.nodes = {across, across}, .spacing = spacing};
    scene.tissue.fixed = {Face::z_max, Face::x_min, Face::x_max, Face::y_min, Face::y_max};
    scene.materials = {{.name = "m",
                        .youngs_modulus = 2e6,
                        .poissons_ratio = 0.45,
                        .retardation_time = 2e-3,
                        .stiffening = Stiffening{.rate = rate, .largest = largest},
                        .cutting_force = 1e4}};
    scene.tissue.layers = {{"m", "m", 0.008}};
    scene.needle = Needle{};
    scene.drive = Drive{.speed = 1e-3};
    return scene;
  };
  const auto force_of = [](const Scene& scene) {
    Simulation simulation(scene);
    while (simulation.ticks() < simulation.tick_count()) {
      CHECK(simulation.tick() == StepStatus::ok);
    }
    return simulation.tool().forces.total;
  };
  const auto change = [&](double rate, double largest = 12.0) {
    return force_of(dent_in(rate, 0.001, largest)) / force_of(dent_in(rate, 0.004, largest)) - 1.0;
  };
  const auto warned = [&](double rate, double largest = 12.0) {
    return mentions(plan_of(dent_in(rate, 0.004, largest)).warnings, "stiffens so fast");
  };
  CHECK(warned(30.0, 3.0));
  CHECK(!warned(4.0));
  CHECK(!warned(5.8));
  CHECK(warned(9.0));
  if (check::sanitized) { return; }  // compares forces; other tests execute the code
  CHECK_NEAR(change(4.0), 0.0, 0.04);
  CHECK(change(9.0) > 0.1);
  CHECK(change(30.0, 3.0) > 0.1);
}

TEST("the printed form takes Euler-Cromer and one step a tick") {
  Scene scene = moving_scene("auto");
  scene.simulation.printed = PrintedForm::all();
  const StepPlan plan = plan_of(scene);
  CHECK(plan.integrator->name == "euler-cromer");
  CHECK(plan.substeps == 1);
  CHECK(plan.kernel == "springs-printed-double");
}

TEST("the lagged velocity is refused with several forces a step, and so is an unknown scheme") {
  Scene scene = moving_scene("rk4");
  scene.simulation.printed.lagged_velocity = true;
  CHECK_THROWS(plan_of(scene), "lagged_velocity needs");
  scene.simulation.integrator = "feynman-newton";
  CHECK(plan_of(scene).integrator->one_evaluation);
  CHECK_THROWS(plan_of(moving_scene("leapfrogg")), "unknown integrator \"leapfrogg\"");
}

TEST("the plan lists skipped parts with reasons, and skips nothing if skipping is off") {
  Scene scene = moving_scene("auto");
  const std::vector<std::string> loaded = plan_of(scene).skipped;
  CHECK(!mentions(loaded, "dampers"));
  CHECK(!mentions(loaded, "gravity"));
  CHECK(!mentions(loaded, "loads"));
  scene.simulation.integrator = "implicit-midpoint";  // springs in a list
  CHECK(mentions(plan_of(scene).skipped, "stepping of fixed nodes: 9"));
  CHECK(mentions(plan_of(scene).skipped,
                 "springs between fixed nodes: 20"));  // 12 edges, 8 diagonals of 3 x 3
  scene.simulation.integrator = "auto";
  scene.tissue.lattice.viscosity = 0.0;
  scene.tissue.gravity.setZero();
  scene.loads.clear();
  const StepPlan bare = plan_of(scene);
  CHECK(mentions(bare.skipped, "dampers: springs and cells have no viscosity"));
  CHECK(mentions(bare.skipped, "gravity: zero"));
  CHECK(mentions(bare.skipped, "loads: the scene has none"));
  CHECK(bare.kernel.starts_with("lattice-undamped-double-"));
  CHECK(plan_of(scene, false).skipped.empty());
  CHECK(plan_of(scene, false).kernel.starts_with("lattice-damped-double-"));
}

TEST("a list's kernel is named for its dampers, its precision and its instruction set") {
  const std::string in_double = std::string("double-") + adjacency_kernels<double>().front().name;
  const std::string in_float = std::string("float-") + adjacency_kernels<float>().front().name;
  Scene scene = moving_scene("implicit-midpoint");
  CHECK(plan_of(scene).kernel == "springs-damped-" + in_double);
  scene.simulation.precision = Precision::single_precision;
  CHECK(plan_of(scene).kernel == "springs-damped-" + in_float);
  scene.tissue.lattice.viscosity = 0.0;
  CHECK(plan_of(scene).kernel == "springs-undamped-" + in_float);
  CHECK(plan_of(scene, false).kernel == "springs-damped-" + in_float);
}

TEST("a lattice skips springs between rows of fixed nodes and no other work on fixed nodes") {
  Scene scene = moving_scene("velocity-verlet");
  scene.tissue.lattice.nodes = {8, 8, 4};  // rows along x: no axis wastes less
  CHECK(mentions(plan_of(scene).skipped,
                 "springs between fixed nodes: 210"));  // 2 * 56 edges, 2 * 49 diagonals
  CHECK(!mentions(plan_of(scene).skipped, "stepping of fixed nodes"));
  scene.tissue.fixed = std::vector<Face>{Face::x_min};  // one node of every row
  CHECK(!mentions(plan_of(scene).skipped, "springs between fixed nodes"));
}

TEST("threads that cannot share the work are not used, with a warning") {
  Scene scene = moving_scene("euler-cromer");
  scene.tissue.lattice.nodes = {20, 20, 9};  // rows of more than one register
  scene.simulation.threads = 2;
  CHECK(plan_of(scene).threads == 2);
  CHECK(plan_of(scene).kernel.ends_with("-2-threads"));
  scene.simulation.threads = 9;
  const StepPlan fewer = plan_of(scene);
  CHECK(fewer.threads == 4);
  // A machine with fewer than four processors adds a second warning.
  CHECK(mentions(fewer.warnings, "4 of 9 threads"));
  scene.simulation.integrator = "implicit-midpoint";
  const StepPlan implicit = plan_of(scene);
  CHECK(implicit.threads == 1);
  CHECK(mentions(implicit.warnings, "one thread: only a regular lattice"));
}

TEST("a plan warns of tissue that no spring joins to a fixed node") {
  Scene scene = layered_scene();
  scene.tissue.layers = {{"sheet", "soft", 0.004},
                         {.tissue = "air", .thickness = 0.004, .gap = true},
                         {"ground", "firm", 0.008}};
  CHECK(mentions(plan_of(scene).warnings,
                 "18 nodes, the first at z = 0 mm, are joined to no fixed node"));
  scene.tissue.fixed = {Face::x_min, Face::z_max};
  CHECK(!mentions(plan_of(scene).warnings, "joined to no fixed node"));
  scene.tissue.fixed = std::vector<Face>{};  // nothing is meant to be held
  CHECK(!mentions(plan_of(scene).warnings, "joined to no fixed node"));
}

TEST("a plan warns of loads, inclusions and records that lie beside the tissue") {
  Scene scene;
  scene.tissue.source = Source::lattice;
  scene.tissue.lattice = {.nodes = {3, 3, 3}, .spacing = 0.01, .material = "gel"};
  scene.tissue.lattice.weights = LatticeWeights::cell;
  scene.tissue.fixed = {Face::z_max};
  Material gel{.name = "gel"};
  gel.youngs_modulus = 1e4;
  gel.density = 1000.0;
  scene.materials = {gel};
  scene.simulation = {.duration = 0.1, .step = 1e-3};
  scene.loads = {{.face = Face::z_min, .force = {0.0, 0.0, 0.01}}};
  scene.tissue.inclusions = {
      {.centre = {0.0, 0.0, -0.001}, .size = {0.008, 0.0, 0.0}, .material = "gel"}};
  scene.records = {{.name = "tip", .where = Eigen::Vector3d(0.001, 0.0, 0.0)}};
  CHECK(!mentions(plan_of(scene).warnings, "no effect"));
  CHECK(!mentions(plan_of(scene).warnings, "from its point"));

  scene.loads[0].face = Face::z_max;
  CHECK(mentions(plan_of(scene).warnings, "load[0] has no effect: all its nodes are fixed"));
  scene.loads[0] = {.face = Face::z_min, .start = 0.1};
  CHECK(mentions(plan_of(scene).warnings, "load[0] has no effect: it starts at 0.1 s"));
  scene.tissue.inclusions[0].centre.z() = -0.0041;
  CHECK(mentions(plan_of(scene).warnings, "inclusion[0] of gel has no effect"));
  scene.records[0].where = Eigen::Vector3d(0.0, 0.0, 0.5);
  CHECK(mentions(plan_of(scene).warnings, "record \"tip\" is of a node 480 mm from its point"));

  scene.probe = Probe{.size = {0.01, 0.01}};
  scene.falcon = FalconDrive{};
  scene.drive = Drive{.kind = Drive::Kind::recorded,
                      .grip = std::make_shared<const std::vector<GripSample>>(
                          std::vector<GripSample>{{0.0, 0.0, 0.0}, {0.1, 0.0, 0.0}})};
  CHECK(!mentions(plan_of(scene).warnings, "the hand rests from then on"));
  scene.simulation.duration = 0.2;
  CHECK(mentions(plan_of(scene).warnings, "drive.recording ends at 0.1 s, and the run at 0.2 s"));
}

TEST("every registered integrator has its stable step in the plan") {
  const StepPlan plan = plan_of(moving_scene("auto"));
  REQUIRE(plan.stable_step.size() == integrators().size());
  for (const IntegratorInfo* scheme : integrators()) {
    CHECK(plan.stable_step.at(std::string(scheme->name)) == stable_step(*scheme, plan.bounds));
  }
}

#ifndef PALPATE_SANITIZED  // tests accuracy; takes half a minute
/// Fat around a body too stiff for explicit schemes at 1 kHz, loaded for 40 ms.
Scene stiff_body_in_fat() {
  Scene scene;
  scene.simulation = {.duration = 0.06, .step = 1e-3};
  scene.tissue.lattice = {.nodes = {5, 5, 5}, .spacing = 0.004, .material = "fat"};
  scene.materials = {
      {.name = "fat", .youngs_modulus = 2.4e3, .density = 950.0, .damping_ratio = 0.5},
      {.name = "stiff", .youngs_modulus = 40e6, .density = 1130.0, .damping_ratio = 0.5}};
  scene.tissue.inclusions = {{.shape = Inclusion::Shape::box,
                              .centre = {0.0, 0.0, 0.008},
                              .size = {0.009, 0.009, 0.009},
                              .material = "stiff"}};
  scene.loads = {
      {.nodes = {12}, .force = {0.0, 0.0, 0.005}, .end = 0.04, .profile = Profile::half_sine}};
  return scene;
}

/// Displacement of the first layer, ticks as columns [m].
Eigen::MatrixXd motion_of(Scene scene, const std::string& integrator, int substeps) {
  scene.simulation.integrator = integrator;
  scene.simulation.substeps = substeps;
  Simulation simulation(scene);
  Eigen::VectorXd q(simulation.problem().dof());
  Eigen::MatrixXd motion(75, simulation.tick_count());
  simulation.coordinates(q);
  const Eigen::VectorXd start = q;
  for (long n = 0; n < simulation.tick_count(); ++n) {
    CHECK(simulation.tick() == StepStatus::ok);
    simulation.coordinates(q);
    motion.col(n) = (q - start).head(75);
  }
  return motion;
}

TEST("around a stiff body the scheme of auto is nearer to the truth than implicit Euler") {
  const Scene scene = stiff_body_in_fat();
  CHECK(plan_of(scene).integrator->name == "implicit-midpoint");
  const Eigen::MatrixXd truth = motion_of(scene, "velocity-verlet", 512);
  const double peak = truth.cwiseAbs().maxCoeff();
  const auto error = [&](const char* name) {
    return (motion_of(scene, name, 1) - truth).cwiseAbs().maxCoeff() / peak;
  };
  const double midpoint = error("implicit-midpoint");
  const double euler = error("implicit-euler");
  CHECK(midpoint < 0.02);  // accuracy limit of "auto"
  CHECK(midpoint < 0.5 * euler);
}
#endif

TEST("an oscillator says how a step damps it, and warns of few steps a period") {
  Scene scene;
  scene.tissue.source = Source::oscillator;
  scene.tissue.oscillator = {.mass = 1.0, .stiffness = 4.0, .viscosity = 0.2};
  scene.simulation = {.duration = 10.0, .step = 0.1, .integrator = "implicit-euler"};
  const StepPlan damped = plan_of(scene);
  REQUIRE(damped.first_mode.has_value());
  CHECK(damped.first_mode->omega == 2.0);
  CHECK(damped.first_mode->damping_ratio == 0.05);
  CHECK(mentions(damped.warnings, "the oscillator (0.318"));
  scene.simulation.integrator = "implicit-midpoint";
  CHECK(plan_of(scene).warnings.empty());
  scene.simulation.step = 0.5;
  const StepPlan coarse = plan_of(scene);
  REQUIRE(mentions(coarse.warnings, "the motion is not resolved; simulation.substeps = 2"));
  scene.simulation.substeps = 2;
  CHECK(plan_of(scene).warnings.empty());
}

TEST("the stable steps of an oscillator are exact") {
  Scene scene;
  scene.tissue.source = Source::oscillator;
  scene.tissue.oscillator = {.mass = 1.0, .stiffness = 1.0, .viscosity = 1.0};
  scene.simulation.step = 0.1;
  const StepPlan plan = plan_of(scene);
  CHECK_NEAR(plan.stable_step.at("euler"), 1.0, 1e-9);                          // c / k
  CHECK_NEAR(plan.stable_step.at("euler-cromer"), std::sqrt(5.0) - 1.0, 1e-9);  // S = 1/2
}

}  // namespace PALPATE_FILE
