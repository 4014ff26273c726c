// SPDX-License-Identifier: MIT
#include "validation/certificate/certify.hpp"

#include <thread>

#include "tests/check.hpp"
#include "tests/model/tool_scenes.hpp"
#include "validation/certificate/verdict.hpp"

namespace {

using namespace palpate;
using namespace palpate::certificate;

Scene short_scene() {
  Scene scene = layered_scene();
  scene.simulation = {.duration = 0.05, .step = 1e-3};
  return scene;
}

/// On a thread of its own, as the procedure asks for.
Certificate certified(const Scene& scene, const CertifyPlan& plan) {
  Certificate result;
  std::thread([&] { result = certify(scene, plan); }).join();
  return result;
}

TEST(
    "every load has its empty loop and its scene, for the same number of ticks; a short scene begins again") {
  const Certificate all = certified(
      short_scene(), {.claim = {.duration = 0.12}, .loads = {"idle", "cpu"}, .cache_bytes = 1U << 20U});
  CHECK(all.loads.size() == 2);
  for (const LoadResult& load : all.loads) {
    CHECK(load.control.record.ticks() == 120 && load.scene.record.ticks() == 120);
    CHECK(load.scene.restarts == 2 && load.control.restarts == 0);
    CHECK(load.tail.refusal.find("too few ticks") != std::string::npos);
  }
  CHECK(!all.interrupted && all.notes.empty());
}

TEST("without asking for the rights nothing is certified") {
  const Certificate all = certified(
      short_scene(), {.claim = {.duration = 0.05}, .cache_bytes = 1U << 20U, .ask_for_rights = false});
  CHECK(!all.rights.all());
  CHECK(judge(all).verdict == Verdict::not_qualified);
}

TEST("a scene that is longer than the loop is noted") {
  const Certificate all = certified(short_scene(), {.claim = {.duration = 0.02}, .cache_bytes = 1U << 20U});
  CHECK(all.notes.size() == 1 &&
        all.notes.front().find("first 20 of the scene's 50 ticks") != std::string::npos);
}

TEST("Ctrl-C leaves a certificate for what ran") {
  const std::atomic<bool> stop{true};
  const Certificate all = certified(short_scene(), {.stop = &stop});
  CHECK(all.interrupted && all.loads.empty());
  CHECK(judge(all).verdict == Verdict::not_qualified);
}

TEST("a tool without a device has the bound of the tissue's stiffness") {
  Scene scene = short_scene();
  const Certificate all =
      certified(scene, {.claim = {.duration = 0.02}, .cache_bytes = 1U << 20U, .tissue_stiffness = 1500.0});
  CHECK(all.missed_tick && !all.missed_tick->measured);
  CHECK_NEAR(all.missed_tick->bound, 0.5 * 1500.0 * 0.02 * 0.02 * 1e-6, 1e-12);  // 20 mm/s for 1 ms
}

TEST("the system's own counters are asked before and after each loop") {
  int asked = 0;
  const Certificate all = certified(
      short_scene(), {.claim = {.duration = 0.02}, .cache_bytes = 1U << 20U, .processor_times = [&](int) {
                        return ProcessorTimes{.stolen = 1.0 * ++asked};
                      }});
  CHECK(asked == 4);
  CHECK_NEAR(all.loads.front().scene.times.stolen, 1.0, 0.0);
}

}  // namespace
