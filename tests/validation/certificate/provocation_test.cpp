// SPDX-License-Identifier: MIT
#include "validation/certificate/provocation.hpp"

#include <algorithm>

#include "tests/check.hpp"
#include "tests/model/tool_scenes.hpp"
#include "validation/certificate/timed_passes.hpp"

namespace {

using namespace palpate;
using namespace palpate::certificate;

Scene insertion() {
  Scene scene = layered_scene();
  scene.syringe = Syringe{};
  scene.drive->speed = 0.05;
  scene.simulation = {.duration = 0.3, .step = 1e-3};
  return scene;
}

const Provocation* named(const ComputeBudget& budget, std::string_view name) {
  const auto found = std::ranges::find(budget.provocations, name, &Provocation::name);
  return found == budget.provocations.end() ? nullptr : &*found;
}

TEST("every event of a scene, its first tick and all special ones are provoked, costliest first") {
  const ComputeBudget budget = provoke(insertion(), {.cache_bytes = 1U << 20U, .enough = 0.0});
  for (const char* name : {"first tick", "costliest tick", "contact: skin", "puncture: skin",
                           "puncture: ligament", "loss-of-resistance: epidural space", "nothing skipped",
                           "denormal numbers", "cold caches", "faults on the lines"}) {
    const Provocation* found = named(budget, name);
    if (found == nullptr) { std::printf("  missing: %s\n", name); }
    CHECK(found != nullptr && found->processor > 0.0 && found->repetitions >= 3);
  }
  CHECK(std::ranges::is_sorted(budget.provocations, std::ranges::greater{}, &Provocation::processor));
  CHECK(!budget.worst_instructions && !budget.diverged_at);
  CHECK_NEAR(budget.largest_speed, 0.05, 1e-9);
}

TEST("the costliest tick is found among all and among a few") {
  const Scene scene = insertion();
  const TimedPasses passes =
      time_passes({.make = [&] { return std::make_unique<SceneLoop>(scene, 1000.0); }, .most_ticks = 20},
                  {.most_repetitions = 5});
  CHECK(passes.passes >= 3 && passes.ticks.size() == 20);
  for (const TimedTick& tick : passes.ticks) { CHECK(tick.processor > 0.0 && tick.wall > 0.0); }
  TimedPasses changed = passes;
  changed.ticks[7].processor = 1.0;
  CHECK(changed.costliest(0, 20) == 7 && changed.costliest({3, 7, 9}) == 7);
  CHECK(changed.costliest(8, 20) >= 8);
}

TEST("a scene that diverges says when, and provokes nothing") {
  Scene scene = insertion();
  scene.simulation.integrator = "euler-cromer";
  scene.simulation.substeps = 1;
  scene.simulation.step = 0.02;
  scene.simulation.duration = 20.0;
  const ComputeBudget budget = provoke(scene, {.rate = 50.0, .enough = 0.0});
  CHECK(budget.diverged_at.has_value() && budget.provocations.empty());
}

TEST("an oscillator has its ticks provoked too") {
  Scene scene;
  scene.tissue.source = Source::oscillator;
  scene.simulation = {.duration = 1.0, .step = 1e-2};
  const ComputeBudget budget = provoke(scene, {.rate = 100.0, .cache_bytes = 1U << 20U, .enough = 0.0});
  CHECK(named(budget, "denormal numbers") != nullptr && named(budget, "first tick") != nullptr);
}

TEST("Ctrl-C ends it at once") {
  const std::atomic<bool> stop{true};
  CHECK(provoke(insertion(), {.stop = &stop}).provocations.empty());
}

}  // namespace
