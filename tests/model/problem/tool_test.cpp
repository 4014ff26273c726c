// SPDX-License-Identifier: MIT

#include "model/problem/tool.hpp"

#include <cmath>
#include <numeric>

#include "model/problem/needle_path.hpp"
#include "model/problem/scene.hpp"
#include "model/tissue/network_builder.hpp"
#include "tests/check.hpp"
#include "tests/model/sample_scenes.hpp"

namespace {

using namespace palpate;

TEST("needle gauges have the outer diameters of the Stubs needle scale") {
  CHECK_NEAR(diameter_of_gauge(16).value(), 0.065 * 0.0254, 1e-6);  // the scale is in inches;
  CHECK_NEAR(diameter_of_gauge(17).value(), 0.058 * 0.0254, 1e-6);  // rounded to a micrometre
  CHECK_NEAR(diameter_of_gauge(18).value(), 0.050 * 0.0254, 1e-6);
  CHECK_NEAR(diameter_of_gauge(27).value(), 0.01625 * 0.0254, 1e-6);
  CHECK_NEAR(Needle{}.diameter, diameter_of_gauge(16).value(), 1e-15);
}

TEST("needles get thinner from gauge 14 to 27, and no other gauge is made") {
  for (int gauge = 14; gauge < 27; ++gauge) {
    CHECK(diameter_of_gauge(gauge + 1).value() < diameter_of_gauge(gauge).value());
  }
  for (const int gauge : {-16, 0, 13, 28, 2147483647, -2147483647 - 1}) {
    CHECK(!diameter_of_gauge(gauge));
  }
}

TEST("a role is what the material states, else what its name says") {
  const auto named = [](const char* name) { return role_of({.name = name}); };
  CHECK(named("fat") == TissueRole::tissue);
  CHECK(named("") == TissueRole::tissue);
  CHECK(named("epidural-space") == TissueRole::epidural_space);  // though it contains "dura"
  CHECK(named("soft-dura") == TissueRole::dura);
  CHECK(named("cortical-bone") == TissueRole::bone);
  CHECK(role_of({.name = "bone", .role = TissueRole::tissue}) == TissueRole::tissue);
}

TEST("air fills a syringe with more compliance, less resistance and the same full pressure") {
  const Syringe saline;
  const Syringe air = air_syringe();
  CHECK(air.compliance > 10.0 * saline.compliance);
  CHECK(air.tissue_resistance < saline.tissue_resistance);
  CHECK(air.thumb_force == saline.thumb_force);
  CHECK(air.plunger_area == saline.plunger_area);
}

double weight_sum(const NeedlePath& path, const NeedlePath::Knot& knot) {
  double sum = 0.0;
  for (const auto& s : path.supports(knot)) { sum += s.weight; }
  return sum;
}

TEST("knots lie where the line meets the planes of nodes, with weights that find the point again") {
  Scene scene = layered_scene(0.002);
  scene.needle->entry = {0.0013, -0.0021};
  scene.needle->direction = {0.25, 0.1, 1.0};
  const SpringNetwork network = build_network(scene);
  const NeedlePath path = NeedlePath::of_needle(scene, network);
  CHECK(path.knots().size() > 4);
  for (const NeedlePath::Knot& knot : path.knots()) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const auto& s : path.supports(knot)) {
      mean += s.weight * network.rest_position.col(s.node);
    }
    CHECK_NEAR(weight_sum(path, knot), 1.0, 1e-14);
    CHECK_NEAR(mean, path.origin() + knot.depth * path.direction(), 1e-15);
  }
}

TEST("no node belongs to two knots") {
  Scene scene = layered_scene(0.002);
  scene.needle->entry = {0.0013, -0.0021};
  scene.needle->direction = {0.5, -0.3, 1.0};
  const SpringNetwork network = build_network(scene);
  const NeedlePath path = NeedlePath::of_needle(scene, network);
  std::vector<int> times(static_cast<std::size_t>(network.node_count()), 0);
  for (const NeedlePath::Knot& knot : path.knots()) {
    for (const auto& s : path.supports(knot)) { ++times[static_cast<std::size_t>(s.node)]; }
  }
  CHECK(std::ranges::max(times) == 1);
}

TEST("a line that leaves the block ends there") {
  Scene scene = layered_scene(0.002);
  scene.needle->entry = {0.0039, 0.0};
  scene.needle->direction = {1.0, 0.0, 1.0};
  const NeedlePath path = NeedlePath::of_needle(scene, build_network(scene));
  CHECK(path.knots().size() == 1);
}

TEST("intervals are the layers, longer for a slanting needle") {
  Scene scene = layered_scene(0.002);
  const double sixty = std::sqrt(3.0);
  scene.needle->direction = {sixty, 0.0, 1.0};
  const NeedlePath path = NeedlePath::of_needle(scene, build_network(scene));
  CHECK(path.intervals().size() == 3);
  CHECK_NEAR(path.intervals()[1].begin, 2.0 * 0.004, 1e-15);
  CHECK(path.intervals()[1].label == "ligament");
  CHECK(path.interval_at(0.0079) == 0);
  CHECK(path.interval_at(0.0081) == 1);
  CHECK(path.interval_at(1.0) == 2);
  CHECK(path.intervals()[2].role == TissueRole::epidural_space);
}

TEST("a bone across the line ends what a needle may do") {
  Scene scene = layered_scene(0.002);
  scene.materials.push_back({.name = "bone", .youngs_modulus = 1e6, .role = TissueRole::bone});
  scene.tissue.inclusions.push_back({.shape = Inclusion::Shape::sphere,
                                     .centre = {0.0, 0.0, 0.008},
                                     .size = {0.004, 0.004, 0.004},
                                     .material = "bone"});
  const NeedlePath path = NeedlePath::of_needle(scene, build_network(scene));
  CHECK_NEAR(path.bone(), 0.006, 1e-15);
  CHECK(std::isinf(path.intervals()[path.interval_at(0.0061)].cutting_force));
}

TEST("a box hides the layers that it covers and lets them go on behind it") {
  Scene scene = layered_scene(0.002);
  scene.materials.push_back({.name = "implant", .youngs_modulus = 1e4, .cutting_force = 9.0});
  scene.tissue.inclusions.push_back({.shape = Inclusion::Shape::box,
                                     .centre = {0.0, 0.0, 0.005},
                                     .size = {0.01, 0.01, 0.004},
                                     .material = "implant"});
  const NeedlePath path = NeedlePath::of_needle(scene, build_network(scene));
  const char* expected[] = {"skin", "implant", "ligament", "epidural space"};
  const double begins[] = {0.0, 0.003, 0.007, 0.010};
  CHECK(path.intervals().size() == 4);
  for (std::size_t n = 0; n < 4; ++n) {
    CHECK(path.intervals()[n].label == expected[n]);
    CHECK_NEAR(path.intervals()[n].begin, begins[n], 1e-15);
  }
}

TEST("friction of a shaft is the integral over its length, whatever the spacing") {
  for (const double spacing : {0.001, 0.002, 0.004}) {
    Scene scene = layered_scene(spacing);
    const NeedlePath path = NeedlePath::of_needle(scene, build_network(scene));
    std::vector<double> share(path.knots().size());
    for (const double depth : {0.0, 0.0007, 0.004, 0.0055, 0.011}) {
      const double exact =
          2.0 * std::min(depth, 0.004) + 5.0 * std::clamp(depth - 0.004, 0.0, 0.006);
      CHECK_NEAR(path.friction(depth, share), exact, 1e-15);
      CHECK_NEAR(std::accumulate(share.begin(), share.end(), 0.0), exact, 1e-15);
    }
  }
}

TEST("shares of friction and tip move on continuously with the depth") {
  const Scene scene = layered_scene(0.002);
  const NeedlePath path = NeedlePath::of_needle(scene, build_network(scene));
  std::vector<double> before(path.knots().size());
  std::vector<double> after(path.knots().size());
  const double step = 1e-7;
  for (double depth = 0.0; depth < 0.011; depth += 9.7e-5) {
    path.friction(depth, before);
    path.friction(depth + step, after);
    for (std::size_t k = 0; k < before.size(); ++k) {
      CHECK(std::abs(after[k] - before[k]) <= 1.0000001 * 5.0 * step);
    }
  }
}

TEST("the knots of a bare chain are its nodes") {
  const Scene scene = chain_scene();
  const NeedlePath path = NeedlePath::of_needle(scene, scene.tissue.network);
  CHECK(path.knots().size() == static_cast<std::size_t>(scene.tissue.network.node_count()));
  for (std::size_t k = 0; k < path.knots().size(); ++k) {
    CHECK_NEAR(path.knots()[k].depth, 0.002 * static_cast<double>(k), 1e-15);
    CHECK(path.knots()[k].count == 1);
  }
}

TEST("a probe's footprint counts nodes by their area beneath it") {
  Scene scene = layered_scene(0.002);
  scene.needle.reset();
  scene.probe = Probe{.shape = Probe::Shape::ultrasound, .size = {0.004, 0.002}};
  const SpringNetwork network = build_network(scene);
  const NeedlePath path = NeedlePath::of_probe(scene, network);
  CHECK(path.knots().size() == 1);
  double sum = 0.0;
  for (const auto& s : path.supports(path.knots().front())) {
    const Eigen::Vector3d at = network.rest_position.col(s.node);
    CHECK(at.z() == 0.0);
    // 4 mm x 2 mm over squares of 2 mm: one row of three nodes, the outer ones half covered.
    CHECK_NEAR(s.weight, std::abs(at.x()) < 1e-9 ? 0.5 : 0.25, 1e-12);
    sum += s.weight;
  }
  CHECK_NEAR(sum, 1.0, 1e-15);
}

TEST("a needle far from every node is refused") {
  Scene scene = chain_scene();
  scene.needle->entry = {1.0, 0.0};
  CHECK_THROWS(NeedlePath::of_needle(scene, scene.tissue.network), "no node lies near");
}

TEST("a continuous trajectory goes on at its speed from the start") {
  const Trajectory path({.start = 0.1, .from = -0.001, .speed = 0.005}, 2.0);
  CHECK(path.place(0.0) == -0.001);
  CHECK(path.place(0.1) == -0.001);
  CHECK_NEAR(path.place(1.1), -0.001 + 0.005, 1e-15);
  CHECK_NEAR(path.place(2.0), -0.001 + 0.0095, 1e-15);
}

TEST("it ends at its depth, holds, and comes back to where it began") {
  const Trajectory path(
      {.from = -0.002, .speed = 0.01, .depth = 0.008, .hold = 0.5, .withdraw_speed = 0.02}, 10.0);
  CHECK_NEAR(path.place(1.0), 0.008, 1e-15);
  CHECK_NEAR(path.place(1.49), 0.008, 1e-15);
  CHECK_NEAR(path.place(1.6), 0.006, 1e-15);
  CHECK_NEAR(path.place(5.0), -0.002, 1e-15);
}

TEST("without a withdrawal it stays") {
  const Trajectory path({.speed = 0.01, .depth = 0.008}, 10.0);
  CHECK_NEAR(path.place(9.0), 0.008, 1e-15);
}

TEST("an intermittent trajectory advances, pauses, advances") {
  const Trajectory path({.technique = Drive::Technique::intermittent,
                         .speed = 0.01,
                         .advance = 0.002,
                         .pause = 0.3,
                         .depth = 0.005},
                        10.0);
  CHECK_NEAR(path.place(0.1), 0.001, 1e-15);
  CHECK_NEAR(path.place(0.4), 0.002, 1e-15);
  CHECK_NEAR(path.place(0.6), 0.003, 1e-15);
  CHECK_NEAR(path.place(0.9), 0.004, 1e-15);
  CHECK_NEAR(path.place(1.05), 0.0045, 1e-15);
  CHECK_NEAR(path.place(3.0), 0.005, 1e-15);
}

TEST("a speed of zero never moves the tool") {
  const Trajectory path({.from = 0.001, .speed = 0.0}, 1.0);
  CHECK(path.place(0.7) == 0.001);
}

TEST("the hand's force rises, holds and turns round") {
  const Drive drive{.start = 0.5, .hold = 1.0, .force = 4.0, .rise = 2.0, .withdraw_force = 1.5};
  CHECK(hand_force(drive, 0.4) == 0.0);
  CHECK_NEAR(hand_force(drive, 1.5), 2.0, 1e-15);
  CHECK(hand_force(drive, 3.0) == 4.0);
  CHECK(hand_force(drive, 4.0) == -1.5);
}

TEST("intermittent pushes come and go") {
  const Drive drive{.technique = Drive::Technique::intermittent,
                    .pause = 0.3,
                    .force = 4.0,
                    .rise = 0.0,
                    .push = 0.2};
  CHECK(hand_force(drive, 0.1) == 4.0);
  CHECK(hand_force(drive, 0.3) == 0.0);
  CHECK(hand_force(drive, 0.6) == 4.0);
}

const Syringe syringe{};
const double limit = syringe.thumb_force / syringe.plunger_area;

TEST("in ligament the pressure rises to what the thumb can hold") {
  SyringePressure p(syringe);
  for (int n = 0; n < 20000; ++n) { p.advance(1e-3, true, TissueRole::tissue); }
  CHECK_NEAR(p.pressure(), limit, 1e-9 * limit);
  CHECK_NEAR(p.thumb(), syringe.thumb_force, 1e-9);
}

TEST("loss of resistance is a decay with R C to what the thumb's flow keeps up") {
  SyringePressure p(syringe);
  while (p.pressure() < limit) { p.advance(1e-3, true, TissueRole::tissue); }
  const double end = syringe.thumb_flow * syringe.epidural_resistance;
  const double rc = syringe.epidural_resistance * syringe.compliance;
  double t = 0.0;
  for (int n = 0; n < 50; ++n) {
    p.advance(1e-3, true, TissueRole::epidural_space);
    t += 1e-3;
    CHECK_NEAR(p.pressure(), end + (limit - end) * std::exp(-t / rc), 1e-9 * limit);
  }
}

TEST("the decay does not depend on the step") {
  SyringePressure coarse(syringe);
  SyringePressure fine(syringe);
  coarse.advance(0.05, true, TissueRole::tissue);
  for (int n = 0; n < 500; ++n) { fine.advance(1e-4, true, TissueRole::tissue); }
  CHECK_NEAR(coarse.pressure(), fine.pressure(), 1e-9 * limit);
}

TEST("a tip in open air holds almost no pressure") {
  SyringePressure p(syringe);
  for (int n = 0; n < 1000; ++n) { p.advance(1e-3, false, TissueRole::tissue); }
  CHECK_NEAR(p.pressure(), syringe.thumb_flow * syringe.open_resistance, 1e-6);
}

}  // namespace
