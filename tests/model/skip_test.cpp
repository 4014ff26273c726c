// SPDX-License-Identifier: MIT
// Skipping what a scene does not need changes no bit, whatever the scene has or has not.
#include <algorithm>
#include <cstring>
#include <map>

#include "model/dynamics/scene_check.hpp"
#include "model/stepping/simulation.hpp"
#include "tests/check.hpp"
#include "tests/model/random_scene.hpp"

namespace {

using namespace palpate;

constexpr std::uint64_t scenes = 20;

/// All that a simulation tells, tick by tick.
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

/// NaN of the same bits is the same.
bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

TEST("in 20 scenes whose features are on or off by chance, skipping changes no bit of anything told") {
  int moving = 0;
  for (std::uint64_t seed = 1; seed <= scenes; ++seed) {
    const Scene scene = random_scene(seed).scene;
    for (const Violation& broken : check_scene(scene)) {
      std::printf("  seed %d: %s %s\n", static_cast<int>(seed), broken.key.c_str(), broken.message.c_str());
    }
    CHECK(check_scene(scene).empty());
    const Story lean = story_of(scene, true);
    const Story full = story_of(scene, false);
    if (!same_bits(lean.numbers, full.numbers)) {
      std::printf("  seed %d, %s\n", static_cast<int>(seed), scene.simulation.integrator.c_str());
    }
    CHECK(same_bits(lean.numbers, full.numbers));
    CHECK(lean.skipped > 0 && full.skipped == 0);
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
  for (const int count : on) { CHECK(count >= 4 && count <= 16); }
  for (const IntegratorInfo* scheme : integrators()) { CHECK(uses[std::string(scheme->name)] > 0); }
}

}  // namespace
