// SPDX-License-Identifier: MIT

#include "model/stepping/simulation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <string>

#include "model/stepping/integrator.hpp"
#include "model/tissue/scene_check.hpp"
#include "tests/check.hpp"
#include "tests/model/sample_scenes.hpp"

namespace {

using namespace palpate;
using Eigen::VectorXd;

struct Final {
  VectorXd position;
  VectorXd velocity;
  std::vector<double> row;
};

Final after(const Scene& scene, int ticks, bool skip = true) {
  Simulation simulation(scene, skip);
  for (int n = 0; n < ticks; ++n) { (void)simulation.tick(); }
  Final end{VectorXd(simulation.problem().dof()), VectorXd(simulation.problem().dof()),
            std::vector<double>(simulation.columns().size())};
  simulation.coordinates(end.position);
  simulation.velocities(end.velocity);
  simulation.sample(end.row);
  return end;
}

TEST("computing what a scene does not need changes no bit, for any scheme and precision") {
  for (const IntegratorInfo* scheme : integrators()) {
    for (const Precision precision : {Precision::double_precision, Precision::single_precision}) {
      for (const double viscosity : {0.0, 0.05}) {
        Scene scene = moving_scene(scheme->name, precision);
        scene.tissue.lattice.viscosity = viscosity;
        scene.tissue.gravity.setZero();
        scene.simulation.substeps = 5;
        constexpr int ticks = check::sanitized ? 8 : 40;
        const Final lean = after(scene, ticks);
        const Final full = after(scene, ticks, false);
        CHECK((lean.position.array() == full.position.array()).all());
        CHECK((lean.velocity.array() == full.velocity.array()).all());
        CHECK(lean.row == full.row);
      }
    }
  }
}

TEST("the same scene gives the same bits again") {
  const Final one = after(moving_scene("auto"), 100);
  const Final two = after(moving_scene("auto"), 100);
  CHECK((one.position.array() == two.position.array()).all());
  CHECK(one.row == two.row);
}

TEST("sampling changes nothing of the motion") {
  for (const IntegratorInfo* scheme : integrators()) {
    Simulation watched(moving_scene(scheme->name));
    Simulation alone(moving_scene(scheme->name));
    std::vector<double> row(watched.columns().size());
    VectorXd q(watched.problem().dof());
    VectorXd p(watched.problem().dof());
    for (int n = 0; n < 30; ++n) {
      watched.sample(row);
      (void)watched.energy();
      (void)watched.tick();
      (void)alone.tick();
    }
    watched.coordinates(q);
    alone.coordinates(p);
    CHECK((q.array() == p.array()).all());
  }
}

TEST("float follows double to single precision") {
  for (const IntegratorInfo* scheme : integrators()) {
    const Final d = after(moving_scene(scheme->name), 50);
    const Final f = after(moving_scene(scheme->name, Precision::single_precision), 50);
    // Positions of 0.02 m round to 1e-9 m; some hundred steps, without amplification.
    CHECK_NEAR(f.position, d.position, 2e-7);
  }
}

TEST("columns are named and united as trace files want them, in the order of the scene") {
  const Simulation simulation(moving_scene("auto"));
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

TEST("a recorded position, velocity and force are those of the node") {
  Scene scene = moving_scene("velocity-verlet");
  Simulation simulation(scene);
  for (int n = 0; n < 5; ++n) { (void)simulation.tick(); }
  const auto& problem = dynamic_cast<const NetworkProblem&>(simulation.problem());
  VectorXd q(problem.dof()), v(problem.dof()), f(problem.dof());
  simulation.coordinates(q);
  simulation.velocities(v);
  const double t = simulation.time();
  problem.force(t, t + 1e-9, q, v, f);
  std::vector<double> row(simulation.columns().size());
  simulation.sample(row);
  const Eigen::Index c = problem.coordinate(4);
  for (int n = 0; n < 3; ++n) {
    const auto place = static_cast<std::size_t>(n);
    CHECK(row[place] == q(c + n));
    CHECK(row[3 + place] == v(c + n));
    CHECK_NEAR(row[6 + place], f(c + n), 1e-14);
  }
}

TEST("before the first tick everything is the initial state") {
  Scene scene = moving_scene("leapfrog");
  Simulation simulation(scene);
  VectorXd q(simulation.problem().dof()), v(simulation.problem().dof());
  simulation.coordinates(q);
  simulation.velocities(v);
  CHECK_NEAR(q, simulation.problem().initial_position(), 0.0);
  CHECK_NEAR(v, simulation.problem().initial_velocity(), 0.0);
  CHECK(simulation.time() == 0.0);
  CHECK(simulation.ticks() == 0);
  CHECK(simulation.tick_count() == 1000);
}

TEST("energy is the specification's, without the springs that cannot move") {
  Scene scene = moving_scene("velocity-verlet");
  scene.tissue.fixed = std::vector<Face>{};
  Simulation simulation(scene);
  for (int n = 0; n < 7; ++n) { (void)simulation.tick(); }
  VectorXd q(simulation.problem().dof()), v(simulation.problem().dof());
  simulation.coordinates(q);
  simulation.velocities(v);
  CHECK_NEAR(simulation.energy(), simulation.problem().energy(q, v), 1e-15);
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

TEST("a NaN at the start is divergence at the first tick, for any scheme and precision") {
  for (const IntegratorInfo* scheme : integrators()) {
    for (const Precision precision : {Precision::double_precision, Precision::single_precision}) {
      const Scene scene = moving_scene(scheme->name, precision);
      auto problem = make_problem(scene);
      SpringNetwork network = dynamic_cast<const NetworkProblem&>(*problem).network();
      network.initial_velocity = NodeVectors::Zero(3, network.node_count());
      network.initial_velocity(1, 2) = std::numeric_limits<double>::quiet_NaN();
      Simulation simulation(scene, network);
      CHECK(simulation.tick() == StepStatus::diverged);
    }
  }
}

TEST("a NaN in a mass or a stiffness is divergence at the first tick too") {
  for (const IntegratorInfo* scheme : integrators()) {
    for (const bool in_mass : {true, false}) {
      const Scene scene = moving_scene(scheme->name);
      SpringNetwork network = dynamic_cast<const NetworkProblem&>(*make_problem(scene)).network();
      constexpr double none = std::numeric_limits<double>::quiet_NaN();
      if (in_mass) {
        network.mass(4) = none;
      } else {
        network.springs.edit([](std::vector<Spring>& all) { all[7].stiffness = none; });
      }
      Simulation simulation(scene, network);
      CHECK(simulation.tick() == StepStatus::diverged);
    }
  }
}

TEST("node positions hold the fixed nodes in their places") {
  Simulation simulation(moving_scene("auto"));
  for (int n = 0; n < 20; ++n) { (void)simulation.tick(); }
  const NodeVectors all = simulation.node_positions();
  const auto& problem = dynamic_cast<const NetworkProblem&>(simulation.problem());
  CHECK_NEAR(NodeVectors(all.rightCols(9)),
             NodeVectors(problem.network().rest_position.rightCols(9)), 0.0);
  CHECK((all.leftCols(9) - problem.network().rest_position.leftCols(9)).norm() > 1e-6);
}

TEST("a network given in memory moves as the same scene does") {
  const Scene scene = moving_scene("rk4");
  const auto problem = make_problem(scene);
  Simulation given(scene, dynamic_cast<const NetworkProblem&>(*problem).network());
  for (int n = 0; n < 25; ++n) { (void)given.tick(); }
  VectorXd q(given.problem().dof());
  given.coordinates(q);
  CHECK((q.array() == after(scene, 25).position.array()).all());
}

TEST("below the normal range a tick counts zero, and what follows it does not") {
  Scene scene;
  scene.tissue.source = Source::oscillator;
  scene.tissue.oscillator.displacement = 1e-310;
  scene.tissue.oscillator.velocity = 1e-310;
  Simulation simulation(scene);
  (void)simulation.tick();
  VectorXd x(1), v(1);
  simulation.coordinates(x);
  simulation.velocities(v);
  CHECK(x(0) == 0.0);
  CHECK(v(0) == 0.0);
  volatile double small = 1e-310;
  CHECK(small * 0.5 > 0.0);
}

// Scenes with random features. The same seed gives the same scene on every machine.

/// Optional features of a scene.
struct SceneFeatures {
  bool damping = false;
  bool gravity = false;
  bool loads = false;
  bool records = false;
  bool side_faces = false;  ///< fixed, besides the bottom
  bool inclusion = false;
  bool needle = false;
  bool single = false;
  bool two_threads = false;

  static constexpr std::size_t count = 9;
  [[nodiscard]] std::array<bool, count> all() const {
    return {damping, gravity, loads, records, side_faces, inclusion, needle, single, two_threads};
  }
};

struct RandomScene {
  SceneFeatures features{};
  Scene scene{};
};

SceneFeatures features(Random& random) {
  const auto coin = [&] { return random(0.0, 1.0) < 0.5; };
  SceneFeatures chosen;
  for (bool* one :
       {&chosen.damping, &chosen.gravity, &chosen.loads, &chosen.records, &chosen.side_faces,
        &chosen.inclusion, &chosen.needle, &chosen.single, &chosen.two_threads}) {
    *one = coin();
  }
  return chosen;
}

int whole(Random& random, int low, int high) {
  return static_cast<int>(std::floor(random(low, high + 1.0)));
}

void add_tissue(const SceneFeatures& features, Random& random, Scene& scene) {
  if (features.needle) {
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
    material.damping_ratio = features.damping ? random(0.1, 0.7) : 0.0;
  }
  scene.tissue.fixed = std::vector<Face>{Face::z_max};
  if (features.side_faces) {
    scene.tissue.fixed->insert(scene.tissue.fixed->end(), {Face::x_min, Face::x_max});
  }
  if (features.inclusion) {
    scene.tissue.inclusions = {
        {.centre = {0.002, 0.0, 0.006}, .size = {0.006, 0.006, 0.006}, .material = "firm"}};
  }
}

/// Schemes in turn, except two with half-step velocities, which do not support a tool.
std::string scheme_of(const SceneFeatures& features, std::uint64_t seed) {
  const auto schemes = integrators();
  const std::string name(schemes[seed % schemes.size()]->name);
  return features.needle && (name == "leapfrog" || name == "feynman-newton") ? "auto" : name;
}

RandomScene random_scene(std::uint64_t seed) {
  Random random(seed);
  RandomScene made{.features = features(random)};
  const SceneFeatures& features = made.features;
  Scene& scene = made.scene;
  add_tissue(features, random, scene);
  scene.simulation = {
      .duration = 0.03,
      .step = 1e-3,
      .integrator = scheme_of(features, seed),
      .precision = features.single ? Precision::single_precision : Precision::double_precision,
      .threads = features.two_threads ? 2 : 1};
  if (!features.damping && scene.simulation.integrator == "euler") {
    scene.simulation.substeps = 50;
  }
  if (features.gravity) { scene.tissue.gravity = {random(-1.0, 1.0), 0.0, 9.81}; }
  if (features.loads) {
    scene.loads = {{.nodes = {whole(random, 0, 8)},
                    .force = {random(-0.01, 0.01), 0.0, random(0.0, 0.02)},
                    .start = random(0.0, 0.01),
                    .end = random(0.015, 0.025),
                    .profile = Profile::half_sine}};
  }
  if (features.records) {
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
  double moved = 0.0;  ///< largest way of any coordinate [m]
};

void append(const Eigen::VectorXd& values, Story& story) {
  story.numbers.insert(story.numbers.end(), values.begin(), values.end());
}

Story story_of(const Scene& scene, bool skip) {
  Simulation simulation(scene, skip);
  Story story{.skipped = simulation.plan().skipped.size()};
  Eigen::VectorXd q(simulation.problem().dof());
  Eigen::VectorXd v(simulation.problem().dof());
  simulation.coordinates(q);
  const Eigen::VectorXd start = q;
  std::vector<double> row(simulation.columns().size());
  for (long n = 0; n < simulation.tick_count(); ++n) {
    story.numbers.push_back(simulation.tick() == StepStatus::ok ? 1.0 : 0.0);
    simulation.sample(row);
    story.numbers.insert(story.numbers.end(), row.begin(), row.end());
    simulation.coordinates(q);
    simulation.velocities(v);
    append(q, story);
    append(v, story);
    story.moved = std::max(story.moved, (q - start).cwiseAbs().maxCoeff());
  }
  return story;
}

/// Compares bits, so NaN equals NaN of the same bits.
bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

TEST(
    "in 20 scenes whose features are on or off by chance, skipping changes no bit of anything "
    "told") {
  int moving = 0;
  for (std::uint64_t seed = 1; seed <= scenes; ++seed) {
    const Scene scene = random_scene(seed).scene;
    for (const Violation& broken : check_scene(scene)) {
      std::printf("  seed %d: %s %s\n", static_cast<int>(seed), broken.key.c_str(),
                  broken.message.c_str());
    }
    CHECK(check_scene(scene).empty());
    const Story lean = story_of(scene, true);
    const Story full = story_of(scene, false);
    if (!same_bits(lean.numbers, full.numbers)) {
      std::printf("  seed %d, %s\n", static_cast<int>(seed), scene.simulation.integrator.c_str());
    }
    CHECK(same_bits(lean.numbers, full.numbers));
    CHECK(lean.skipped > 0);
    CHECK(full.skipped == 0);
    moving += lean.moved > 1e-7 ? 1 : 0;
  }
  CHECK(moving >= 15);  // at rest everything agrees: three of four have weight, a load or a needle
}

TEST("every feature is on in some of the 20 and off in others, and every integrator takes part") {
  std::array<int, SceneFeatures::count> on{};
  std::map<std::string, int> uses;
  for (std::uint64_t seed = 1; seed <= scenes; ++seed) {
    const RandomScene made = random_scene(seed);
    const auto features = made.features.all();
    for (std::size_t f = 0; f < features.size(); ++f) { on[f] += features[f] ? 1 : 0; }
    ++uses[made.scene.simulation.integrator];
  }
  for (const int count : on) {
    CHECK(count >= 4);
    CHECK(count <= 16);
  }
  for (const IntegratorInfo* scheme : integrators()) { CHECK(uses[std::string(scheme->name)] > 0); }
}

}  // namespace
