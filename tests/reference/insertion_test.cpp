// SPDX-License-Identifier: MIT
#include "reference/insertion.hpp"

#include <algorithm>

#include "tests/reference/insertion_samples.hpp"
#include "tests/check.hpp"

using namespace palpate;
using namespace palpate::reference;
using Kind = InsertionEvent::Kind;

namespace {

constexpr Tolerance tight{.relative = 1e-9};
}  // namespace

TEST("a chain resists with k_eff s + c_eff v, is punctured at F_c and then resists with F_c") {
  const sample::Chain chain;
  const double v = 0.02;
  const double stiffness = chain.stiffness / chain.springs;
  const double viscosity = chain.viscosity / chain.springs;
  const Scene scene = sample::needle_scene(chain.network(), {{1.0, 0.2, 0.0}}, {.speed = v});
  const Insertion run = sample::solve(scene, 0.4, 400);
  for (const InsertionInstant& now : run.instants) {
    if (now.time > 0.15 && now.time < 0.2445) {  // the impact has died out to exp(-28)
      CHECK_NEAR(now.stiffness, stiffness * v * now.time + viscosity * v, 1e-9);
      CHECK_NEAR(now.total, now.stiffness, 0.0);
    }
    if (now.time > 0.2455) { CHECK_NEAR(now.cutting, 0.2, 0.0); }
    CHECK_NEAR(now.applied, now.total, 0.0);
  }
  const auto* contact = sample::first_of(run, Kind::contact);
  const auto* puncture = sample::first_of(run, Kind::puncture);
  CHECK(contact != nullptr && contact->time == 0.0);
  CHECK(puncture != nullptr);
  if (puncture == nullptr) { return; }
  CHECK_NEAR(puncture->time, (0.2 - viscosity * v) / (stiffness * v), 1e-9);
  CHECK_NEAR(puncture->depth, 0.0, 0.0);
}

TEST("the tip reaches the skin when its trajectory does, and rests before its start") {
  const Scene scene = sample::needle_scene(sample::Chain{}.network(), {{1.0, 0.2, 0.0}},
                                           {.start = 0.1, .from = -0.004, .speed = 0.02});
  const Insertion run = sample::solve(scene, 0.4, 40);
  const auto* contact = sample::first_of(run, Kind::contact);
  CHECK(contact != nullptr);
  if (contact != nullptr) { CHECK_NEAR(contact->time, 0.3, 1e-9); }
  for (const InsertionInstant& now : run.instants) {
    if (now.time < 0.1) { CHECK_NEAR(now.place, -0.004, 0.0); }
    if (now.time < 0.3) { CHECK_NEAR(now.total, 0.0, 0.0); }
  }
}

TEST("the plastic impact at contact makes the skin as fast as the tip and loses half m v^2") {
  const sample::Chain chain;
  const Scene scene =
      sample::needle_scene(chain.network(), {{1.0, 0.2, 0.0}}, {.speed = 0.02});
  const Insertion run = sample::solve(scene, 0.1, 1);
  CHECK_NEAR(run.instants[0].velocities(2), 0.02, 1e-15);
  CHECK_NEAR(run.instants[0].energy.impacts, 0.5 * chain.mass * 0.02 * 0.02, 1e-18);
  CHECK_NEAR(run.instants[0].energy.hand, chain.mass * 0.02 * 0.02, 1e-18);
}

TEST("each layer that resists more stops the tip at its beginning until T reaches its F_c") {
  const Scene scene =
      sample::needle_scene(sample::Chain{}.network(), sample::three_layers, {.speed = 0.02});
  const Insertion run = sample::solve(scene, 2.4, 100);
  double stopped = -1.0;
  int punctures = 0;
  for (const InsertionEvent& event : run.events) {
    if (event.kind == Kind::stopped && stopped < 0.0) { stopped = event.depth; }
    if (event.kind != Kind::puncture) { continue; }
    CHECK_NEAR(event.depth, punctures == 0 ? 0.0 : punctures == 1 ? 0.012 : 0.022, 1e-11);
    CHECK(event.layer == "layer " + std::to_string(punctures));
    ++punctures;
  }
  CHECK_NEAR(stopped, 0.012, 1e-11);
  CHECK(punctures == 3);
  for (const InsertionInstant& now : run.instants) {
    if (now.cutting > 0.0) {
      const double strength = now.cut < 0.012 ? 0.2 : now.cut < 0.022 ? 0.5 : 0.1;
      CHECK_NEAR(now.cutting, strength, 0.0);
      const double shaft = 10.0 * std::min(now.cut, 0.012) +
                           15.0 * std::clamp(now.cut - 0.012, 0.0, 0.01) +
                           5.0 * std::max(now.cut - 0.022, 0.0);
      CHECK(std::abs(now.friction) <= shaft + 2e-9);
    }
  }
}

TEST("the epidural space is a loss of resistance and dura is a dural puncture") {
  const Scene scene =
      sample::needle_scene(sample::Chain{}.network(),
                           {{0.01, 0.3, 0.0},
                            {0.005, 0.0, 0.0, TissueRole::epidural_space},
                            {0.1, 0.1, 0.0, TissueRole::dura}},
                           {.speed = 0.02});
  const Insertion run = sample::solve(scene, 1.5, 10);
  const auto* loss = sample::first_of(run, Kind::loss_of_resistance);
  const auto* dura = sample::first_of(run, Kind::dural_puncture);
  CHECK(loss != nullptr && dura != nullptr);
  if (loss != nullptr) { CHECK_NEAR(loss->depth, 0.01, 1e-11); }
  if (dura != nullptr) { CHECK_NEAR(dura->depth, 0.015, 1e-11); }
}

TEST("friction alone: F = f xi on the way in, -f xi on the way out, stuck in between") {
  const double f = 5.0;
  const sample::Chain chain;
  const Scene scene =
      sample::needle_scene(chain.network(), {{1.0, 0.0, f}},
                           {.from = -0.001, .speed = 0.005, .depth = 0.03, .hold = 0.2,
                            .withdraw_speed = 0.005});
  const double turn = 0.031 / 0.005 + 0.2;
  const Insertion run = sample::solve(scene, 12.0, 1200);
  double slips_back = 0.0;
  for (const InsertionEvent& event : run.events) {
    if (event.kind == Kind::shaft_slips && slips_back == 0.0 && event.time > turn + 0.05) {
      slips_back = event.time;
    }
  }
  CHECK(slips_back > turn);
  double in = 0.0;
  for (const InsertionInstant& now : run.instants) {
    if (now.time > 1.0 && now.time < turn - 0.21) {
      CHECK_NEAR(now.friction, f * now.depth, 1e-12);
      in = now.friction;
    }
    if (now.time > slips_back && now.depth > 1e-4) {
      CHECK_NEAR(now.friction, -f * now.depth, 1e-12);
    }
    CHECK_NEAR(now.total, now.friction, 0.0);
  }
  // The shaft follows the tissue until its load has turned: 2 L c, c of the l_k / L in the chain.
  // The tip moves in its track meanwhile (l_k changes a little) and dampers lag: hence 5 %.
  Eigen::VectorXd share = Eigen::VectorXd::Zero(6);
  const double depth = in / f;
  for (int k = 0; k < 6; ++k) {
    constexpr int parts = 100000;
    for (int n = 0; n < parts; ++n) {
      const double xi = (n + 0.5) * depth / parts;
      share(k) += std::max(0.0, 1.0 - std::abs(xi / chain.spacing - k)) / parts;
    }
  }
  double compliance = 0.0;
  for (int a = 0; a < 6; ++a) {
    for (int b = 0; b < 6; ++b) {
      compliance += share(a) * share(b) * (5 - std::max(a, b)) / chain.stiffness;
    }
  }
  CHECK_NEAR(0.005 * (slips_back - turn), 2.0 * in * compliance, 0.05 * 2.0 * in * compliance);
}

TEST("bone stops the tip exactly and the hand pulls it by the grip") {
  const Scene scene = sample::needle_scene(
      sample::Chain{}.network(), {{0.02, 0.1, 0.0}, {0.1, 0.0, 0.0, TissueRole::bone}},
      {.speed = 0.02, .depth = 0.022, .hold = 0.2, .withdraw_speed = 0.02,
       .grip_stiffness = 1000.0});
  const Insertion run = sample::solve(scene, 1.5, 150, 1e-9, sample::with_energy);
  const auto* bone = sample::first_of(run, Kind::bone_contact);
  const auto* left = sample::first_of(run, Kind::bone_left);
  CHECK(bone != nullptr && left != nullptr);
  if (bone == nullptr || left == nullptr) { return; }
  CHECK_NEAR(bone->time, 1.0, 1e-9);
  CHECK_NEAR(left->time, 1.4, 1e-9);
  for (const InsertionInstant& now : run.instants) {
    CHECK(now.place <= 0.02 + 2e-12);  // the band of roots, and the last rounding
    if (now.time > 1.1 && now.time < 1.3) {
      CHECK_NEAR(now.applied, now.cutting + now.friction + now.stiffness, 0.0);
      CHECK(now.stiffness >= 1000.0 * 0.002 - 1e-9);
    }
  }
  CHECK_NEAR(sample::imbalance(run), 0.0, 1e-7 * run.instants.back().energy.hand);
}

TEST("a probe never cuts: it sinks in by its force over the stiffness and lets the skin go") {
  Scene scene = sample::needle_scene({}, {{0.03, 0.05, 1.0}},
                                     {.speed = 0.01, .depth = 0.002, .withdraw_speed = 0.01});
  scene.tissue.source = Source::layers;
  scene.tissue.block = {.nodes = {5, 5}, .spacing = 0.005};
  scene.needle.reset();
  scene.probe = Probe{};
  const Insertion run = sample::solve(scene, 1.0, 50);
  double largest = 0.0;
  for (const InsertionInstant& now : run.instants) {
    largest = std::max(largest, now.total);
    CHECK_NEAR(now.cut, 0.0, 0.0);
    CHECK_NEAR(now.cutting + std::abs(now.friction), 0.0, 0.0);
  }
  CHECK(largest > 0.05);
  CHECK(sample::first_of(run, Kind::withdrawn) != nullptr);
}

TEST("times that do not ascend and a tip that begins in the tissue are refused") {
  const Scene scene = sample::needle_scene(sample::Chain{}.network(), sample::three_layers, {});
  CHECK_THROWS(solve_insertion(scene, build_network(scene), {0.0, 0.2, 0.1}, tight), "ascend");
  Scene inside = scene;
  inside.drive->from = 0.001;
  CHECK_THROWS(solve_insertion(inside, build_network(inside), {0.0, 0.1}, tight), "inside");
  Scene none = scene;
  none.needle.reset();
  CHECK_THROWS(solve_insertion(none, build_network(none), {0.0, 0.1}, tight), "neither");
}
