// SPDX-License-Identifier: MIT

#include "model/problem/tool.hpp"

#include <cmath>
#include <numeric>

#include "model/problem/needle_path.hpp"
#include "model/problem/scene.hpp"
#include "model/tissue/network_builder.hpp"
#include "tests/check.hpp"
#include "tests/model/sample_scenes.hpp"

namespace PALPATE_FILE {

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

TEST("a role is that of the material, else it follows from its name") {
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

NeedlePath path_of(const Scene& scene) { return NeedlePath(scene, build_network(scene)); }

TEST("contact points lie where the line meets the planes of nodes, none of which serves two") {
  Scene scene = layered_scene(0.002);
  scene.needle->entry = {0.0013, -0.0021};
  for (const Eigen::Vector3d& direction : {Eigen::Vector3d(0.25, 0.1, 1.0), {0.5, -0.3, 1.0}}) {
    scene.needle->direction = direction;
    const SpringNetwork network = build_network(scene);
    const NeedlePath path(scene, network);
    CHECK(path.knots().size() > (direction.x() < 0.3 ? 4U : 2U));  // the oblique line ends early
    std::vector<int> uses(static_cast<std::size_t>(network.node_count()), 0);
    for (const NeedlePath::Knot& knot : path.knots()) {
      Eigen::Vector3d mean = Eigen::Vector3d::Zero();
      double sum = 0.0;
      for (const auto& s : path.supports(knot)) {
        mean += s.weight * network.rest_position.col(s.node);
        sum += s.weight;
        ++uses[static_cast<std::size_t>(s.node)];
      }
      CHECK_NEAR(sum, 1.0, 1e-14);
      CHECK_NEAR(mean, path.origin() + knot.depth * path.direction(), 1e-15);
    }
    CHECK(std::ranges::max(uses) == 1);
  }
}

TEST("a line that leaves the block ends there, and a needle far from every node is refused") {
  Scene scene = layered_scene(0.002);
  scene.needle->entry = {0.0039, 0.0};
  scene.needle->direction = {1.0, 0.0, 1.0};
  CHECK(path_of(scene).knots().size() == 1);
  Scene far = chain_scene();
  far.needle->entry = {1.0, 0.0};
  CHECK_THROWS(path_of(far), "no node lies near");
}

TEST("a needle whose contact points are all fixed is refused") {
  Scene scene = layered_scene(0.002);
  scene.tissue.block.nodes = {2, 2};
  scene.tissue.fixed = {Face::x_min, Face::x_max};
  CHECK_THROWS(path_of(scene), "no free node lies along the needle");
}

TEST("intervals are the layers, longer for a slanting needle") {
  Scene scene = layered_scene(0.002);
  const double sixty = std::sqrt(3.0);
  scene.needle->direction = {sixty, 0.0, 1.0};
  const NeedlePath path = path_of(scene);
  REQUIRE(path.intervals().size() == 3);
  CHECK_NEAR(path.intervals()[1].begin, 2.0 * 0.004, 1e-15);
  CHECK(path.intervals()[1].label == "ligament");
  CHECK(path.interval_at(0.0079) == 0);
  CHECK(path.interval_at(0.0081) == 1);
  CHECK(path.interval_at(1.0) == 2);
  CHECK(path.intervals()[2].role == TissueRole::epidural_space);
}

TEST("a needle cannot pass a bone across its line") {
  Scene scene = layered_scene(0.002);
  scene.materials.push_back({.name = "bone", .youngs_modulus = 1e6, .role = TissueRole::bone});
  scene.tissue.inclusions.push_back({.shape = Inclusion::Shape::sphere,
                                     .centre = {0.0, 0.0, 0.008},
                                     .size = {0.004, 0.004, 0.004},
                                     .material = "bone"});
  const NeedlePath path = path_of(scene);
  CHECK_NEAR(path.bone(), 0.006, 1e-15);
  CHECK(std::isinf(path.intervals()[path.interval_at(0.0061)].cutting_force));
}

TEST("a box replaces the layers that it covers, which continue behind it") {
  Scene scene = layered_scene(0.002);
  scene.materials.push_back({.name = "implant", .youngs_modulus = 1e4, .cutting_force = 9.0});
  scene.tissue.inclusions.push_back({.shape = Inclusion::Shape::box,
                                     .centre = {0.0, 0.0, 0.005},
                                     .size = {0.01, 0.01, 0.004},
                                     .material = "implant"});
  const NeedlePath path = path_of(scene);
  const char* expected[] = {"skin", "implant", "ligament", "epidural space"};
  const double begins[] = {0.0, 0.003, 0.007, 0.010};
  REQUIRE(path.intervals().size() == 4);
  for (std::size_t n = 0; n < 4; ++n) {
    CHECK(path.intervals()[n].label == expected[n]);
    CHECK_NEAR(path.intervals()[n].begin, begins[n], 1e-15);
  }
}

TEST("friction of a shaft is the integral over its length, and its shares change continuously") {
  for (const double spacing : {0.001, 0.002, 0.004}) {
    const NeedlePath path = path_of(layered_scene(spacing));
    std::vector<double> share(path.knots().size());
    for (const double depth : {0.0, 0.0007, 0.004, 0.0055, 0.011}) {
      const double exact =
          2.0 * std::min(depth, 0.004) + 5.0 * std::clamp(depth - 0.004, 0.0, 0.006);
      CHECK_NEAR(path.friction(depth, share), exact, 1e-15);
      CHECK_NEAR(std::accumulate(share.begin(), share.end(), 0.0), exact, 1e-15);
    }
    std::vector<double> after = share;
    const double step = 1e-7;
    for (double depth = 0.0; depth < 0.011; depth += 9.7e-5) {
      path.friction(depth, share);
      path.friction(depth + step, after);
      for (std::size_t k = 0; k < share.size(); ++k) {
        CHECK(std::abs(after[k] - share[k]) <= 1.0000001 * 5.0 * step);
      }
    }
  }
}

TEST("the contact points of a bare chain are its nodes") {
  const Scene scene = chain_scene();
  const NeedlePath path(scene, scene.tissue.network);
  CHECK(path.knots().size() == static_cast<std::size_t>(scene.tissue.network.node_count()));
  for (std::size_t k = 0; k < path.knots().size(); ++k) {
    CHECK_NEAR(path.knots()[k].depth, 0.002 * static_cast<double>(k), 1e-15);
    CHECK(path.knots()[k].count == 1);
  }
}

TEST("a probe's face presses nodes with the pressure of a rigid face") {
  Scene scene = layered_scene(0.002);
  scene.needle.reset();
  scene.probe = Probe{.shape = Probe::Shape::ultrasound, .size = {0.004, 0.002}};
  const SpringNetwork network = build_network(scene);
  const NeedlePath path(scene, network);
  CHECK(path.knots().size() == 1);
  double sum = 0.0;
  double square = 0.0;  // mean of x^2 over the pressure
  for (const auto& s : path.supports(path.knots().front())) {
    const Eigen::Vector3d at = network.rest_position.col(s.node);
    CHECK(at.z() == 0.0);
    sum += s.weight;
    square += s.weight * at.x() * at.x();
  }
  CHECK_NEAR(sum, 1.0, 1e-14);
  // b^2 / 2 under a flat punch and b^2 / 4 times the factor of T_2(x), b = 2 mm. Bilinear weights
  // on a spacing h add the mean of f (1 - f) h^2, at most h^2 / 4.
  constexpr int second = 5;  // of face_terms()
  const double factor = path.face_pressure()(second);
  CHECK(factor != 0.0);
  const double mean = 2e-6 + factor * 1e-6;
  CHECK(square > mean);
  CHECK(square < mean + 1e-6);
}

TEST("a trajectory whose advance is lost to rounding rests instead of having vertices for ever") {
  CHECK(Trajectory({.from = -0.001, .speed = 1e-30}, 2.0).place(1.0) == -0.001);
  CHECK(Trajectory({.from = -9e18, .speed = 0.01}, 2.0).place(1.0) == -9e18);
  const Drive steps{.technique = Drive::Technique::intermittent, .from = -9e18, .speed = 0.01};
  CHECK(Trajectory(steps, 2.0).place(1.0) == -9e18);
}

TEST("a continuous trajectory moves at its speed to its depth, holds, and comes back") {
  const Trajectory path({.start = 0.1, .from = -0.001, .speed = 0.005}, 2.0);
  CHECK(path.place(0.0) == -0.001);
  CHECK(path.place(0.1) == -0.001);
  CHECK_NEAR(path.place(1.1), -0.001 + 0.005, 1e-15);
  CHECK_NEAR(path.place(2.0), -0.001 + 0.0095, 1e-15);
  Drive drive{.from = -0.002, .speed = 0.01, .depth = 0.008, .hold = 0.5, .withdraw_speed = 0.02};
  const Trajectory back(drive, 10.0);
  CHECK_NEAR(back.place(1.0), 0.008, 1e-15);
  CHECK_NEAR(back.place(1.49), 0.008, 1e-15);
  CHECK_NEAR(back.place(1.6), 0.006, 1e-15);
  CHECK_NEAR(back.place(5.0), -0.002, 1e-15);
  CHECK_NEAR(Trajectory({.speed = 0.01, .depth = 0.008}, 10.0).place(9.0), 0.008, 1e-15);
  CHECK(Trajectory({.from = 0.001, .speed = 0.0}, 1.0).place(0.7) == 0.001);
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

TEST("the hand's force rises, holds and turns round; intermittent pushes come and go") {
  const Drive drive{.start = 0.5, .hold = 1.0, .force = 4.0, .rise = 2.0, .withdraw_force = 1.5};
  CHECK(hand_force(drive, 0.4) == 0.0);
  CHECK_NEAR(hand_force(drive, 1.5), 2.0, 1e-15);
  CHECK(hand_force(drive, 3.0) == 4.0);
  CHECK(hand_force(drive, 4.0) == -1.5);
  Drive pushes{.technique = Drive::Technique::intermittent, .pause = 0.3, .force = 4.0};
  pushes.rise = 0.0;
  pushes.push = 0.2;
  CHECK(hand_force(pushes, 0.1) == 4.0);
  CHECK(hand_force(pushes, 0.3) == 0.0);
  CHECK(hand_force(pushes, 0.6) == 4.0);
}

const Syringe syringe{};
const double limit = syringe.thumb_force / syringe.plunger_area;

SyringePressure pressed(int steps, double step, bool in_tissue = true) {
  SyringePressure p(syringe);
  const double resistance = p.resistance(in_tissue, TissueRole::tissue, {});
  for (int n = 0; n < steps; ++n) { p.advance(step, resistance, syringe.thumb_force); }
  return p;
}

TEST("the pressure rises in ligament to what the thumb holds, in air hardly, at any step") {
  const SyringePressure p = pressed(20000, 1e-3);
  CHECK_NEAR(p.pressure(), limit, 1e-9 * limit);
  CHECK_NEAR(p.thumb(), syringe.thumb_force, 1e-9);
  CHECK_NEAR(pressed(1, 0.05).pressure(), pressed(500, 1e-4).pressure(), 1e-9 * limit);
  CHECK_NEAR(pressed(1000, 1e-3, false).pressure(), syringe.thumb_flow * syringe.open_resistance,
             1e-6);
}

TEST("loss of resistance is a decay with R C to the pressure of the thumb's flow") {
  SyringePressure p(syringe);
  while (p.pressure() < limit) { p.advance(1e-3, syringe.tissue_resistance, syringe.thumb_force); }
  const double end = syringe.thumb_flow * syringe.epidural_resistance;
  const double rc = syringe.epidural_resistance * syringe.compliance;
  double t = 0.0;
  for (int n = 0; n < 50; ++n) {
    p.advance(1e-3, p.resistance(true, TissueRole::epidural_space, {}), syringe.thumb_force);
    t += 1e-3;
    CHECK_NEAR(p.pressure(), end + (limit - end) * std::exp(-t / rc), 1e-9 * limit);
  }
}

TEST("a thumb that drives the needle carries the reaction through the pressure, less friction") {
  Syringe driven{.thumb = Syringe::Thumb::drives, .hand_share = 0.25, .plunger_friction = 0.5};
  SyringePressure p(driven);
  CHECK(p.thumb_limit(-3.0, false) == 0.0);
  CHECK(p.thumb_limit(1e3, false) == driven.thumb_force);
  for (int n = 0; n < 20000; ++n) {
    p.advance(1e-3, driven.tissue_resistance, p.thumb_limit(8.0, false));
  }
  CHECK_NEAR(p.pressure() * driven.plunger_area, 6.0, 1e-9);
  CHECK_NEAR(p.thumb(), 6.5, 1e-9);
}

TEST("a thumb that tests presses while the needle rests, and the pressure falls in between") {
  const Syringe tested{.thumb = Syringe::Thumb::tests, .plunger_friction = 0.5};
  SyringePressure p(tested);
  const double resistance = 1e11;
  for (int n = 0; n < 6000; ++n) { p.advance(1e-3, resistance, p.thumb_limit(8.0, true)); }
  const double held =
      std::min(tested.thumb_flow * resistance, (tested.thumb_force - 0.5) / tested.plunger_area);
  CHECK_NEAR(p.pressure(), held, 1e-6 * held);
  // The plunger is driven back to what its friction holds, and the fluid leaks.
  p.advance(1e-3, resistance, p.thumb_limit(8.0, false));
  CHECK(p.pressure() <= 0.5 / tested.plunger_area);
  const double before = p.pressure();
  for (int n = 0; n < 100; ++n) { p.advance(1e-3, resistance, 0.0); }
  CHECK_NEAR(p.pressure(), before * std::exp(-0.1 / (resistance * tested.compliance)),
             1e-9 * before);
}

}  // namespace PALPATE_FILE
