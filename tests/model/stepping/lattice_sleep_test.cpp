// SPDX-License-Identifier: MIT

#include <algorithm>
#include <cmath>
#include <string>

#include "model/kernels/lattice_network.hpp"
#include "model/stepping/simulation.hpp"
#include "model/tissue/lattice.hpp"
#include "reference/static_equilibrium.hpp"
#include "tests/check.hpp"
#include "tests/model/sample_scenes.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using Eigen::Vector3d;
using Eigen::VectorXd;

struct Pull {
  int n = 10;
  const char* integrator = "euler-cromer";
  double sleep_force = 0.0;  ///< [N]
  Precision precision = Precision::double_precision;
  Profile profile = Profile::constant;
  double duration = 0.1;  ///< [s]
  bool skip = true;
};

/// Cube of docs/bench.md: fixed at z-max, pulled at the middle of the free face.
Scene scene_of(const Pull& pull) {
  Scene scene;
  scene.simulation = {.duration = pull.duration,
                      .step = 1e-3,
                      .substeps = 1,
                      .integrator = pull.integrator,
                      .precision = pull.precision,
                      .sleep_force = pull.sleep_force};
  scene.tissue.source = Source::lattice;
  scene.tissue.lattice = uniform_cube(pull.n);
  scene.loads = {{.nodes = {(pull.n / 2) * pull.n + pull.n / 2},
                  .force = {0.0, 0.0, -0.1},
                  .end = pull.profile == Profile::constant ? std::numeric_limits<double>::infinity()
                                                           : pull.duration,
                  .profile = pull.profile}};
  return scene;
}

struct Path {
  std::vector<Vector3d> place{};  ///< position of the pulled node after every tick [m]
  double awake_share = 0.0;
};

Path path_of(const Pull& pull) {
  const Scene scene = scene_of(pull);
  Simulation simulation(scene, pull.skip);
  Path path;
  for (long n = 0; n < simulation.tick_count(); ++n) {
    (void)simulation.tick();
    path.place.emplace_back(simulation.node_positions().col(scene.loads[0].nodes[0]));
  }
  path.awake_share = simulation.awake_share();
  return path;
}

double largest_distance(const Path& a, const Path& b) {
  double largest = 0.0;
  for (std::size_t n = 0; n < a.place.size(); ++n) {
    const double apart = (a.place[n] - b.place[n]).norm();
    if (!(apart <= largest)) { largest = apart; }  // NaN is never lost
  }
  return largest;
}

/// Static compliance of the nodes of a scene [m/N].
class Compliance {
 public:
  explicit Compliance(const Scene& scene) : problem_(make_problem(scene)), response_(*problem_) {}
  [[nodiscard]] double along(int node, int axis) const {
    const auto& network = dynamic_cast<const NetworkProblem&>(*problem_);
    return response_.compliance(VectorXd::Unit(network.dof(), network.coordinate(node) + axis));
  }
  [[nodiscard]] double largest(int node) const {
    return std::max({along(node, 0), along(node, 1), along(node, 2)});
  }

 private:
  std::unique_ptr<Problem> problem_;
  reference::StaticResponse response_;
};

/// sqrt(C_ii C_jj) of the pulled node and of the softest node, a corner of the free face [m/N].
double shared_compliance() {
  static const double found = [] {
    const Compliance compliance(scene_of({}));
    const int pulled = scene_of({}).loads[0].nodes[0];
    return std::sqrt(compliance.largest(pulled) * compliance.largest(0));
  }();
  return found;
}

TEST("sleep moves the pulled node by no more than the withheld force allows, less with less") {
  const double compliance = shared_compliance();
  for (const char* integrator : {"euler-cromer", "velocity-verlet", "rk4"}) {
    const Path full = path_of({.integrator = integrator});
    double before = std::numeric_limits<double>::infinity();
    for (const double sleep_force :
         check::sanitized ? std::vector{1e-2, 1e-4} : std::vector{1e-2, 1e-3, 1e-4, 1e-6}) {
      const Path path = path_of({.integrator = integrator, .sleep_force = sleep_force});
      const double off = largest_distance(path, full);
      CHECK_NEAR(off, 0.0, 2.0 * sleep_force * compliance);
      CHECK(off < before);
      before = off;
    }
  }
}

TEST("a load that grows slowly wakes what it reaches") {
  const double compliance = shared_compliance();
  const double duration = 0.5;
  const Path full = path_of({.profile = Profile::ramp, .duration = duration});
  const Path path = path_of({.sleep_force = 1e-4, .profile = Profile::ramp, .duration = duration});
  CHECK_NEAR(largest_distance(path, full), 0.0, 2.0 * 1e-4 * compliance);
  CHECK(path.awake_share > 0.5);
}

TEST("a wave wakes no more than it can have reached, and in time everything") {
  // An explicit scheme propagates motion by at most one node per step.
  const int n = 24;
  for (const int ticks : {1, 3, 6}) {
    const Path path = path_of({.n = n, .sleep_force = 1e-9, .duration = 1e-3 * ticks});
    const double rows = std::min(n, 2 * ticks + 1) * std::min(n, ticks + 1);
    CHECK(path.awake_share > 0.0);
    CHECK(path.awake_share <= rows / (n * (n - 1.0)));
  }
  CHECK(path_of({.n = 8, .sleep_force = 1e-9, .duration = 0.2}).awake_share == 1.0);
}

TEST("float sleeps too") {
  const Path full = path_of({.precision = Precision::single_precision});
  const Path path = path_of({.sleep_force = 1e-3, .precision = Precision::single_precision});
  CHECK_NEAR(largest_distance(path, full), 0.0, 2.0 * 1e-3 * shared_compliance());
}

TEST("without skipping nothing sleeps, and the bits are those of a scene without sleep") {
  const Path path = path_of({.sleep_force = 1e-3, .skip = false});
  CHECK(path.awake_share == 1.0);
  CHECK(largest_distance(path, path_of({})) == 0.0);
}

TEST("what is displaced, moves or is loaded is awake from the beginning") {
  const Scene scene = scene_of({.sleep_force = 1e-3});
  SpringNetwork network = uniform_lattice({{10, 10, 10}, 0.01, 26}, 50.0, 0.05, 1e-3);
  CHECK(Simulation(scene, network).awake_share() == 0.01);  // the loaded row of a hundred
  network.initial_displacement = NodeVectors::Zero(3, 1000);
  network.initial_displacement(1, 555) = 1e-4;
  network.initial_velocity = NodeVectors::Zero(3, 1000);
  network.initial_velocity(2, 999) = 1e-2;
  CHECK(Simulation(scene, network).awake_share() == 0.03);
}

/// Needle that presses on the skin of a soft block without cutting.
Scene pressed_block(double sleep_force) {
  Scene scene;
  scene.simulation = {.duration = 0.1,
                      .step = 1e-3,
                      .substeps = 8,
                      .integrator = "velocity-verlet",
                      .sleep_force = sleep_force};
  scene.tissue.source = Source::layers;
  scene.tissue.block = {.nodes = {11, 11}, .spacing = 0.004, .connectivity = 26};
  scene.materials = {{.name = "soft",
                      .youngs_modulus = 10e3,
                      .damping_ratio = 0.5,
                      .cutting_force = 1e3,
                      .role = TissueRole::tissue}};
  scene.tissue.layers = {{"soft", "soft", 0.04}};
  scene.needle = Needle{};
  scene.drive = Drive{.speed = 0.02};
  return scene;
}

std::vector<double> needle_forces(const Scene& scene, double& awake_at_first) {
  Simulation simulation(scene);
  awake_at_first = simulation.awake_share();
  std::vector<double> forces;
  for (long n = 0; n < simulation.tick_count(); ++n) {
    (void)simulation.tick();
    forces.push_back(simulation.tool().forces.total);
  }
  return forces;
}

TEST("beside a needle rows are awake, and what sleeps changes its force by less than the bound") {
  const Compliance compliance(pressed_block(0.0));
  // The softest node is a corner of the skin.
  const double lever = std::sqrt(compliance.largest(0) / compliance.along(5 * 11 + 5, 2));
  double awake = 0.0;
  const std::vector<double> full = needle_forces(pressed_block(0.0), awake);
  CHECK(awake == 1.0);
  CHECK(full.back() > 0.03);
  for (const double sleep_force :
       check::sanitized ? std::vector{1e-3} : std::vector{1e-2, 1e-3, 1e-4}) {
    const std::vector<double> forces = needle_forces(pressed_block(sleep_force), awake);
    CHECK(awake < 0.3);  // three rows of 11 in each plane carry the needle's disc
    double off = 0.0;
    for (std::size_t n = 0; n < full.size(); ++n) {
      off = std::max(off, std::abs(forces[n] - full[n]));
    }
    CHECK(off > 0.0);
    CHECK_NEAR(off, 0.0, 2.0 * sleep_force * lever);
  }
}

TEST("where sleep is impossible the plan has the reason") {
  Scene heavy = scene_of({.sleep_force = 1e-3});
  heavy.tissue.gravity = {0.0, 0.0, 9.81};
  Scene implicit = scene_of({.integrator = "implicit-euler", .sleep_force = 1e-3});
  for (const Scene& scene : {heavy, implicit}) {
    const Simulation simulation(scene);
    CHECK(simulation.plan().sleep_force == 0.0);
    CHECK(std::ranges::any_of(simulation.plan().warnings, [](const std::string& w) {
      return w.starts_with("nothing sleeps: ");
    }));
  }
  Scene shared = scene_of({.sleep_force = 1e-3});
  shared.simulation.threads = 2;
  CHECK(Simulation(shared).plan().threads == 1);
}

}  // namespace PALPATE_FILE
