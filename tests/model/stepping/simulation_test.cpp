// SPDX-License-Identifier: MIT

#include "model/stepping/simulation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <string>

#include "model/stepping/integrator.hpp"
#include "model/tissue/scene_check.hpp"
#include "tests/check.hpp"
#include "tests/model/sample_scenes.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using Eigen::VectorXd;

Simulation after(const Scene& scene, int ticks) {
  Simulation simulation(scene);
  for (int n = 0; n < ticks; ++n) { (void)simulation.tick(); }
  return simulation;
}

VectorXd position_of(const Simulation& simulation) {
  VectorXd q(simulation.problem().dof());
  simulation.coordinates(q);
  return q;
}

VectorXd velocity_of(Simulation& simulation) {
  VectorXd v(simulation.problem().dof());
  simulation.velocities(v);
  return v;
}

std::vector<double> row_of(Simulation& simulation) {
  std::vector<double> row(simulation.columns().size());
  simulation.sample(row);
  return row;
}

TEST("the same scene gives the same bits again, whether it is sampled or not") {
  for (const IntegratorInfo* scheme : integrators()) {
    Simulation watched(moving_scene(scheme->name));
    for (int n = 0; n < 30; ++n) {
      (void)row_of(watched);
      (void)watched.energy();
      (void)watched.tick();
    }
    Simulation alone = after(moving_scene(scheme->name), 30);
    CHECK(position_of(watched) == position_of(alone));
    CHECK(row_of(watched) == row_of(alone));
  }
}

TEST("float follows double to single precision") {
  for (const IntegratorInfo* scheme : integrators()) {
    Simulation d = after(moving_scene(scheme->name), 50);
    Simulation f = after(moving_scene(scheme->name, Precision::single_precision), 50);
    // Positions of 0.02 m round to 1e-9 m; some hundred steps, without amplification.
    CHECK_NEAR(position_of(f), position_of(d), 2e-7);
  }
}

TEST("columns have the names and units of trace files, in the order of the scene") {
  Simulation simulation(moving_scene("auto"));
  const auto& columns = simulation.columns();
  REQUIRE(columns.size() == 12);
  CHECK(columns[0].name == "top.x_m");
  CHECK(columns[0].unit == "m");
  CHECK(columns[3].name == "top.vx_m_per_s");
  CHECK(columns[3].unit == "m/s");
  CHECK(columns[8].name == "top.fz_n");
  CHECK(columns[8].unit == "N");
  CHECK(columns[11].name == "near.z_m");
}

/// Checks the record of node 4 against the equation of motion.
void check_records(Simulation& simulation) {
  const auto& problem = dynamic_cast<const NetworkProblem&>(simulation.problem());
  const VectorXd q = position_of(simulation);
  const VectorXd v = velocity_of(simulation);
  VectorXd f(problem.dof());
  problem.force(simulation.time(), simulation.time() + 1e-9, q, v, f);
  const std::vector<double> row = row_of(simulation);
  const Eigen::Map<const Eigen::Matrix3d> recorded(row.data());
  const Eigen::Index c = problem.coordinate(4);
  CHECK_NEAR(recorded.col(0), q.segment<3>(c), 0.0);
  CHECK_NEAR(recorded.col(1), v.segment<3>(c), 0.0);
  CHECK_NEAR(recorded.col(2), f.segment<3>(c), 1e-14);
}

TEST("a recorded position, velocity and force are those of the node") {
  Simulation springs = after(moving_scene("velocity-verlet"), 5);
  Scene scene = moving_scene("velocity-verlet");
  scene.materials = {{.name = "gel", .youngs_modulus = 5e3, .poissons_ratio = 0.45}};
  scene.tissue.lattice.weights = LatticeWeights::cell;
  scene.tissue.lattice.material = "gel";
  Simulation cells = after(scene, 5);
  for (Simulation* each : {&springs, &cells}) { check_records(*each); }
}

TEST("before the first tick everything is the initial state") {
  Simulation simulation(moving_scene("leapfrog"));
  CHECK_NEAR(position_of(simulation), simulation.problem().initial_position(), 0.0);
  CHECK_NEAR(velocity_of(simulation), simulation.problem().initial_velocity(), 0.0);
  CHECK(simulation.time() == 0.0);
  CHECK(simulation.ticks() == 0);
  CHECK(simulation.tick_count() == 1000);
}

TEST("energy is the specification's, without the springs that cannot move") {
  Scene scene = moving_scene("velocity-verlet");
  scene.tissue.fixed = std::vector<Face>{};
  Simulation simulation = after(scene, 7);
  CHECK_NEAR(simulation.energy(),
             simulation.problem().energy(position_of(simulation), velocity_of(simulation)), 1e-15);
}

TEST("a step beyond the limit is reported as divergence before anything overflows the report") {
  Scene scene = moving_scene("euler-cromer");
  scene.simulation.substeps = 1;
  scene.simulation.step = 1.0;
  scene.simulation.duration = 1000.0;
  Simulation simulation(scene);
  StepStatus status = StepStatus::ok;
  for (int n = 0; n < 1000 && status == StepStatus::ok; ++n) { status = simulation.tick(); }
  CHECK(status == StepStatus::diverged);
  CHECK(simulation.ticks() < 100);
}

TEST("node positions hold the fixed nodes in their places") {
  Simulation simulation = after(moving_scene("auto"), 20);
  const auto& problem = dynamic_cast<const NetworkProblem&>(simulation.problem());
  const NodeVectors moved = simulation.node_positions() - problem.network().rest_position;
  CHECK(moved.rightCols(9).norm() == 0.0);
  CHECK(moved.leftCols(9).norm() > 1e-6);
}

TEST("a network given in memory moves as the same scene does") {
  const Scene scene = moving_scene("rk4");
  const auto problem = make_problem(scene);
  Simulation given(scene, dynamic_cast<const NetworkProblem&>(*problem).network());
  for (int n = 0; n < 25; ++n) { (void)given.tick(); }
  Simulation built = after(scene, 25);
  CHECK(position_of(given) == position_of(built));
}

TEST("values below the normal range become zero in a tick, and the processor's mode is restored") {
  Scene scene;
  scene.tissue.source = Source::oscillator;
  scene.tissue.oscillator.displacement = 1e-310;
  scene.tissue.oscillator.velocity = 1e-310;
  Simulation simulation = after(scene, 1);
  CHECK(position_of(simulation)(0) == 0.0);
  CHECK(velocity_of(simulation)(0) == 0.0);
  volatile double small = 1e-310;
  CHECK(small * 0.5 > 0.0);
}

// Scenes with random features. The same seed gives the same scene on every machine.

/// Optional features of a scene; `side_faces` are fixed besides the bottom.
enum Feature {
  damping,
  gravity,
  loads,
  records,
  side_faces,
  inclusion,
  needle,
  single,
  two_threads
};
using Features = std::array<bool, 9>;

struct RandomScene {
  Features features{};
  Scene scene{};
};

int whole(Random& random, int low, int high) {
  return static_cast<int>(std::floor(random(low, high + 1.0)));
}

void add_tissue(const Features& features, Random& random, Scene& scene) {
  if (features[needle]) {
    scene = layered_scene();
    scene.drive->speed = random(0.01, 0.04);
  } else {
    scene.materials = tool_materials();
    scene.tissue.lattice = {
        .nodes = {whole(random, 3, 9), whole(random, 3, 5), whole(random, 4, 5)},
        .spacing = 0.004,
        .connectivity = std::array{6, 18, 26}[static_cast<std::size_t>(whole(random, 0, 2))],
        .material = "soft"};
  }
  for (Material& material : scene.materials) {
    material.damping_ratio = features[damping] ? random(0.1, 0.7) : 0.0;
    if (features[gravity] && scene.tissue.lattice.connectivity != 6) {
      material.poissons_ratio = 0.4;
    }
  }
  scene.tissue.fixed = std::vector<Face>{Face::z_max};
  if (features[side_faces]) {
    scene.tissue.fixed->insert(scene.tissue.fixed->end(), {Face::x_min, Face::x_max});
  }
  if (features[inclusion]) {
    scene.tissue.inclusions = {
        {.centre = {0.002, 0.0, 0.006}, .size = {0.006, 0.006, 0.006}, .material = "firm"}};
  }
}

/// Schemes in turn, except two with half-step velocities, which do not support a tool.
std::string scheme_of(const Features& features, std::uint64_t seed) {
  const auto schemes = integrators();
  const std::string name(schemes[seed % schemes.size()]->name);
  return features[needle] && (name == "leapfrog" || name == "feynman-newton") ? "auto" : name;
}

RandomScene random_scene(std::uint64_t seed) {
  Random random(seed);
  RandomScene made;
  for (bool& on : made.features) { on = random(0.0, 1.0) < 0.5; }
  const Features& features = made.features;
  Scene& scene = made.scene;
  add_tissue(features, random, scene);
  scene.simulation = {
      .duration = 0.03,
      .step = 1e-3,
      .integrator = scheme_of(features, seed),
      .precision = features[single] ? Precision::single_precision : Precision::double_precision,
      .threads = features[two_threads] ? 2 : 1};
  if (!features[damping] && scene.simulation.integrator == "euler") {
    scene.simulation.substeps = 50;
  }
  if (features[gravity]) { scene.tissue.gravity = {random(-1.0, 1.0), 0.0, 9.81}; }
  if (features[loads]) {
    scene.loads = {{.nodes = {whole(random, 0, 8)},
                    .force = {random(-0.01, 0.01), 0.0, random(0.0, 0.02)},
                    .start = random(0.0, 0.01),
                    .end = random(0.015, 0.025),
                    .profile = Profile::half_sine}};
  }
  if (features[records]) {
    scene.records = {
        {"somewhere",
         whole(random, 0, 20),
         {RecordedQuantity::position, RecordedQuantity::velocity, RecordedQuantity::force}}};
  }
  return made;
}

// Skipping unused features does not change any bit of the result.

constexpr std::uint64_t scenes = 20;

/// Complete output of a simulation, tick by tick.
struct Story {
  std::vector<double> numbers{};
  std::size_t skipped = 0;
  double moved = 0.0;  ///< largest displacement of any coordinate [m]
};

Story story_of(const Scene& scene, bool skip) {
  Simulation simulation(scene, skip);
  Story story{.skipped = simulation.plan().skipped.size()};
  const VectorXd start = position_of(simulation);
  const auto append = [&](const auto& values) {
    story.numbers.insert(story.numbers.end(), values.begin(), values.end());
  };
  for (long n = 0; n < simulation.tick_count(); ++n) {
    story.numbers.push_back(simulation.tick() == StepStatus::ok ? 1.0 : 0.0);
    append(row_of(simulation));
    append(position_of(simulation));
    append(velocity_of(simulation));
    const VectorXd moved = position_of(simulation) - start;
    story.moved = std::max(story.moved, moved.cwiseAbs().maxCoeff());
  }
  return story;
}

/// Compares bits, so NaN equals NaN of the same bits.
bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

TEST("in 20 scenes with random features skipping changes no bit of any output") {
  int moving = 0;
  for (std::uint64_t seed = 1; seed <= scenes; ++seed) {
    const Scene scene = random_scene(seed).scene;
    check::row = "seed " + std::to_string(seed) + ", " + scene.simulation.integrator;
    CHECK(check_scene(scene).empty());
    const Story lean = story_of(scene, true);
    const Story full = story_of(scene, false);
    CHECK(same_bits(lean.numbers, full.numbers));
    CHECK(lean.skipped > 0);
    CHECK(full.skipped == 0);
    moving += lean.moved > 1e-7 ? 1 : 0;
  }
  CHECK(moving >= 15);  // at rest everything agrees: three of four have weight, a load or a needle
}

TEST("every feature is on in some of the 20 and off in others, and every integrator takes part") {
  std::array<int, std::tuple_size_v<Features>> on{};
  std::map<std::string, int> uses;
  for (std::uint64_t seed = 1; seed <= scenes; ++seed) {
    const RandomScene made = random_scene(seed);
    for (std::size_t f = 0; f < on.size(); ++f) { on[f] += made.features[f] ? 1 : 0; }
    ++uses[made.scene.simulation.integrator];
  }
  for (const int count : on) {
    CHECK(count >= 4);
    CHECK(count <= 16);
  }
  for (const IntegratorInfo* scheme : integrators()) { CHECK(uses[std::string(scheme->name)] > 0); }
}

}  // namespace PALPATE_FILE
