// SPDX-License-Identifier: MIT
#include "reference/quasi_static_insertion.hpp"

#include "tests/reference/insertion_samples.hpp"
#include "reference/solution.hpp"
#include "tests/reference/sample_problems.hpp"
#include "tests/check.hpp"

using namespace palpate;
using namespace palpate::reference;

namespace {

constexpr double k = 200.0;  // of the sample chain's five springs [N/m]

/// Compliance of the chain at a depth: knots in series, hat functions between them.
double chain_compliance(double depth) {
  const int knot = static_cast<int>(depth / 0.01);
  const double h = depth / 0.01 - knot;
  const double here = (5 - knot) / k;
  const double next = (4 - knot) / k;
  return (1 - h) * (1 - h) * here + (2 * h * (1 - h) + h * h) * next;
}

Scene chain_scene(const std::vector<sample::Stratum>& strata, const Drive& drive) {
  return sample::needle_scene(sample::Chain{}.network(), strata, drive);
}

}  // namespace

TEST("a chain yields by its springs in series, linearly weighted between knots") {
  const Scene scene = chain_scene({{1.0, 0.2, 0.0}}, {});
  const SpringNetwork network = build_network(scene);
  for (const double depth : {0.0, 0.004, 0.01, 0.012, 0.035, 0.04}) {
    CHECK_NEAR(static_compliance(scene, network, depth), chain_compliance(depth), 1e-15);
  }
  CHECK_NEAR(static_compliance(scene, network, 0.05), 0.0, 0.0);
}

TEST("the force-depth curve sticks, cuts, sticks at more and drops at less") {
  const Scene scene = chain_scene({{0.012, 0.2, 0.0}, {0.01, 0.5, 0.0}, {0.1, 0.1, 0.0}}, {});
  const auto curve = force_depth_curve(scene, build_network(scene), 0.04);
  const std::vector<ForceDepthVertex> expected{
      {0.0, 0.0},
      {chain_compliance(0.0) * 0.2, 0.2},
      {0.012 + chain_compliance(0.012) * 0.2, 0.2},
      {0.012 + chain_compliance(0.012) * 0.5, 0.5},
      {0.022 + chain_compliance(0.022) * 0.5, 0.5},
      {0.022 + chain_compliance(0.022) * 0.5, 0.1},
      {0.04, 0.1}};
  CHECK(curve.size() == expected.size());
  for (std::size_t n = 0; n < std::min(curve.size(), expected.size()); ++n) {
    CHECK_NEAR(curve[n].place, expected[n].place, 1e-15);
    CHECK_NEAR(curve[n].force, expected[n].force, 0.0);
  }
  CHECK_NEAR(force_at(curve, 0.0025), 0.1, 1e-15);
  CHECK_NEAR(force_at(curve, expected[4].place), 0.1, 0.0);
}

TEST("a slow insertion follows the quasi-static curve") {
  const double speed = 1e-3;
  const Scene scene =
      chain_scene({{0.012, 0.2, 0.0}, {0.01, 0.5, 0.0}, {0.1, 0.1, 0.0}}, {.speed = speed});
  const SpringNetwork network = build_network(scene);
  const auto curve = force_depth_curve(scene, network, 0.028);
  const auto run = solve_insertion(scene, network, sample::instants(28.0, 560), {.relative = 1e-8});
  for (const auto& now : run.instants) {
    if (now.time < 0.1) { continue; }  // the impact at contact dies out
    // Dampers carry c v / springs at the skin and up to c v / 3 below, where fewer springs bear it.
    CHECK_NEAR(now.total, force_at(curve, now.place), 2.0 * speed);
  }
}

TEST("tissue that can move freely is refused") {
  Scene scene = chain_scene({{1.0, 0.2, 0.0}}, {});
  scene.tissue.network.fixed.back() = 0;
  CHECK_THROWS(static_compliance(scene, build_network(scene), 0.0), "definite");
}
