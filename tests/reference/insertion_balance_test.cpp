// SPDX-License-Identifier: MIT
// What must hold for every insertion: momentum, energy, constraints, convergence.
#include <algorithm>

#include "tests/reference/insertion_samples.hpp"
#include "reference/insertion.hpp"
#include "tests/check.hpp"

using namespace palpate;
using namespace palpate::reference;
using Kind = InsertionEvent::Kind;

namespace {

constexpr Tolerance tight{.relative = 1e-9};

/// M a - f(q, v) of the free nodes: what the needle does to them. a by a central difference.
Eigen::VectorXd needle_force(const Scene& scene, const InsertionInstant& before,
                             const InsertionInstant& now, const InsertionInstant& after) {
  const NetworkProblem problem(build_network(scene));
  const Eigen::VectorXd acceleration =
      (after.velocities - before.velocities) / (after.time - before.time);
  Eigen::VectorXd f(problem.dof());
  problem.force(now.time, now.time, now.position, now.velocities, f);
  return problem.mass().cwiseProduct(acceleration) - f;
}

}  // namespace

TEST("the needle's forces on the nodes sum to F_r and lie at its knots") {
  const Scene scene = sample::block_scene(5, sample::two_layers, {.speed = 0.02});
  for (const double at : {0.05, 0.2, 0.7, 0.83, 1.2}) {
    const Insertion run =
        solve_insertion(scene, build_network(scene), {0.0, at - 1e-5, at, at + 1e-5}, tight);
    const Eigen::VectorXd force =
        needle_force(scene, run.instants[1], run.instants[2], run.instants[3]);
    double along = 0.0;
    double beside = 0.0;
    for (Eigen::Index i = 0; i < force.size() / 3; ++i) {
      const bool on_line = i % 25 == 12;
      along += on_line ? force(3 * i + 2) : 0.0;
      if (!on_line) { beside = std::max(beside, force.segment<3>(3 * i).norm()); }
    }
    CHECK_NEAR(along, run.instants[2].total, 1e-6);  // h^2 / 6 of the third derivative of v
    CHECK_NEAR(beside, 0.0, 1e-6);
  }
}

TEST("knots that the tip has passed stay where they are across an oblique needle") {
  Scene scene = sample::block_scene(5, sample::two_layers, {.speed = 0.02, .depth = 0.03});
  scene.needle->entry = {0.0012, 0.0007};
  scene.needle->direction = {0.1, 0.05, 1.0};
  const Insertion run = sample::solve(scene, 1.4, 70);
  const Eigen::Vector3d n = scene.needle->direction.normalized();
  const auto weights_of = [&](double z) {  // bilinear, about the node below the left corner
    const double x = (0.0012 + z * n.x() / n.z() + 0.01) / 0.005;
    const double y = (0.0007 + z * n.y() / n.z() + 0.01) / 0.005;
    return std::pair{x, y};
  };
  const auto mean_of = [&](const InsertionInstant& now, int plane) {
    const auto [x, y] = weights_of(plane * 0.005);
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (int i = 0; i < 25; ++i) {
      const double w = std::max(0.0, 1.0 - std::abs(x - i % 5)) *
                       std::max(0.0, 1.0 - std::abs(y - i / 5));
      mean += w * now.position.segment<3>(3 * (25 * plane + i));
    }
    return mean;
  };
  double lateral = 0.0;
  for (const InsertionEvent& event : run.events) {
    if (event.kind != Kind::knot_passed) { continue; }
    const int plane = static_cast<int>(std::lround(event.depth * n.z() / 0.005));
    Eigen::Vector3d first = Eigen::Vector3d::Constant(1e9);
    for (const InsertionInstant& now : run.instants) {
      if (now.time < event.time + 1e-9) { continue; }
      if (first.x() > 1.0) { first = mean_of(now, plane); }
      const Eigen::Vector3d moved = mean_of(now, plane) - first;
      CHECK_NEAR((moved - n.dot(moved) * n).eval(), Eigen::Vector3d::Zero().eval(), 1e-11);
      CHECK_NEAR(now.lateral.dot(n), 0.0, 1e-14);
      lateral = std::max(lateral, now.lateral.norm());
    }
  }
  CHECK(lateral > 1e-3);
}

TEST("what the hand gives is stored or lost, in a chain and in a block, there and back") {
  const Drive drive{.speed = 0.02, .depth = 0.025, .hold = 0.2, .withdraw_speed = 0.03};
  const SpringNetwork chain = sample::Chain{}.network();
  std::vector<Scene> scenes{sample::needle_scene(chain, sample::three_layers, drive)};
  if (!check::sanitized) { scenes.push_back(sample::block_scene(5, sample::two_layers, drive)); }
  for (const Scene& scene : scenes) {
    const Insertion run = sample::solve(scene, 2.0, 20, 1e-9, sample::with_energy);
    const double hand = run.instants.back().energy.hand;
    CHECK(hand > 1e-3);
    CHECK_NEAR(sample::imbalance(run), 0.0, 1e-7 * hand);
    CHECK_NEAR(run.largest_drift, 0.0, 1e-11);
    CHECK_NEAR(run.largest_slip, 0.0, 1e-10);  // the tolerance of velocities
    CHECK(check::sanitized || run.seconds < 20.0);
  }
}

TEST("a needle pushed by a force obeys its own equation and gives its energy away") {
  Drive drive{.kind = Drive::Kind::force, .force = 0.7, .withdraw_force = 0.3,
              .hand_viscosity = 5.0};
  const Scene scene = sample::needle_scene(sample::Chain{}.network(), sample::three_layers, drive);
  const Insertion run = sample::solve(scene, 2.0, 200, 1e-9, sample::with_energy);
  CHECK_NEAR(sample::imbalance(run), 0.0, 1e-6 * run.instants.back().energy.hand);
  CHECK(sample::first_of(run, Kind::withdrawn) != nullptr);
  const Insertion fine = solve_insertion(scene, build_network(scene),
                                         {0.0, 0.6 - 1e-5, 0.6, 0.6 + 1e-5}, tight);
  const auto& at = fine.instants;
  const double acceleration = (at[3].velocity - at[1].velocity) / 2e-5;
  CHECK_NEAR(scene.needle->mass * acceleration, at[2].applied - at[2].total, 1e-7);
}

TEST("forces and instants of events converge with the tolerance") {
  const Scene scene = sample::block_scene(5, sample::two_layers, {.speed = 0.02});
  const Insertion coarse = sample::solve(scene, 1.2, 12, 1e-8);
  const Insertion fine = sample::solve(scene, 1.2, 12, 1e-10);
  CHECK(coarse.events.size() == fine.events.size());
  for (std::size_t n = 0; n < std::min(coarse.events.size(), fine.events.size()); ++n) {
    CHECK(coarse.events[n].kind == fine.events[n].kind);
    CHECK_NEAR(coarse.events[n].time, fine.events[n].time, 2e-8);
  }
  for (std::size_t n = 0; n < fine.instants.size(); ++n) {
    CHECK_NEAR(coarse.instants[n].total, fine.instants[n].total, 1e-7);
    CHECK_NEAR(coarse.instants[n].cut, fine.instants[n].cut, 1e-9);
    CHECK_NEAR(coarse.instants[n].position, fine.instants[n].position, 1e-9);
  }
}

TEST("an intermittent needle keeps its energy whether jumps strike the shaft or let it slip") {
  using ShaftImpact = InsertionOptions::ShaftImpact;
  const Scene scene = sample::needle_scene(
      sample::Chain{}.network(), sample::three_layers,
      {.technique = Drive::Technique::intermittent, .speed = 0.02, .advance = 0.004,
       .pause = 0.1, .depth = 0.026, .hold = 0.1, .withdraw_speed = 0.02});
  double impacts = 0.0;
  for (const ShaftImpact impact : {ShaftImpact::slips, ShaftImpact::plastic}) {
    InsertionOptions options = sample::with_energy;
    options.shaft_impact = impact;
    const Insertion run = sample::solve(scene, 3.0, 10, 1e-9, options);
    CHECK_NEAR(sample::imbalance(run), 0.0, 1e-7 * run.instants.back().energy.hand);
    CHECK(run.instants.back().energy.impacts > impacts);
    impacts = run.instants.back().energy.impacts;
  }
}
