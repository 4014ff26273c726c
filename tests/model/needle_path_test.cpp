// SPDX-License-Identifier: MIT
#include "model/dynamics/needle_path.hpp"

#include <cmath>
#include <numeric>

#include "model/dynamics/network_builder.hpp"
#include "tests/check.hpp"
#include "tests/model/tool_scenes.hpp"

namespace {

using namespace palpate;

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
  scene.materials.push_back(
      {.name = "bone", .youngs_modulus = 1e6, .role = TissueRole::bone});
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
      const double exact = 2.0 * std::min(depth, 0.004) +
                           5.0 * std::clamp(depth - 0.004, 0.0, 0.006);
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

}  // namespace
