// SPDX-License-Identifier: MIT

#include "validation/certificate/certificate.hpp"

#include <cmath>
#include <thread>

#include "tests/check.hpp"
#include "tests/model/sample_scenes.hpp"

namespace {

using namespace palpate::certificate;
using namespace palpate;
using palpate::certificate::miss_probability_upper;

TEST("after no miss the limit is 1 - 0.05^(1/n), some 3/n") {
  CHECK_NEAR(miss_probability_upper(0, 60000), 1.0 - std::pow(0.05, 1.0 / 60000.0), 1e-15);
  CHECK_NEAR(60000.0 * miss_probability_upper(0, 60000), 3.0, 0.01);
  CHECK_NEAR(miss_probability_upper(0, 1), 0.95, 1e-15);
}

TEST("one miss of two has its limit where both missing has the chance 0.95") {
  // P(X <= 1) = 1 - p^2 = 0.05
  CHECK_NEAR(miss_probability_upper(1, 2), std::sqrt(0.95), 1e-12);
}

TEST("more misses mean a higher limit, more ticks a lower one") {
  for (long misses = 0; misses < 50; ++misses) {
    CHECK(miss_probability_upper(misses, 1000) < miss_probability_upper(misses + 1, 1000));
    CHECK(miss_probability_upper(misses, 2000) < miss_probability_upper(misses, 1000));
  }
}

TEST("the limit lies above the share that was seen, for a day at 1 kHz too") {
  for (const long misses : {1L, 10L, 1000L, 1000000L, 86399999L}) {
    const double limit = miss_probability_upper(misses, 86400000);
    CHECK(limit > static_cast<double>(misses) / 86400000.0);
    CHECK(limit <= 1.0);
  }
}

TEST("where all missed, or nothing ran, nothing contradicts a probability of one") {
  CHECK_NEAR(miss_probability_upper(3, 3), 1.0, 0.0);
  CHECK_NEAR(miss_probability_upper(0, 0), 1.0, 0.0);
}

constexpr double deadline = 1e-3;

void fill(Phase& phase, long ticks, long misses) {
  for (long n = 0; n < ticks; ++n) {
    const double due = 1e-3 * static_cast<double>(n);
    phase.record.add({.due = due, .begin = due, .end = due + (n < misses ? 2.0 : 0.5) * deadline},
                     {});
  }
}

Certificate clean(long control_misses = 0, long scene_misses = 0) {
  Certificate all;
  all.claim = {.rate = 1000.0, .deadline = deadline, .duration = 1.0};
  all.budget.probes = {{.name = "first tick", .processor = 0.4 * deadline}};
  LoadResult& load = all.loads.emplace_back("idle", deadline);
  fill(load.control, 1000, control_misses);
  fill(load.scene, 1000, scene_misses);
  return all;
}

TEST("no miss at all is certified, with the limit that so many ticks support") {
  const Outcome outcome = outcome_of(clean());
  CHECK(outcome.status == Status::pass);
  CHECK_CONTAINS(outcome.reason(), "No tick of 1000 missed");
  CHECK_NEAR(clean().worst()->miss_probability_upper(), 1.0 - std::pow(0.05, 1e-3), 1e-15);
}

TEST("a single miss of the scene is not certified") {
  const Outcome outcome = outcome_of(clean(0, 1));
  CHECK(outcome.status == Status::fail);
  CHECK_CONTAINS(outcome.reason(), "1 of 1000 deadlines");
}

TEST("where the empty loop missed, nothing is said against the scene, whatever it did") {
  CHECK(outcome_of(clean(1, 0)).status == Status::inconclusive);
  CHECK(outcome_of(clean(1, 500)).status == Status::inconclusive);
}

TEST("without the rights nothing is certified, however well it went") {
  Certificate all = clean();
  all.rights.fifo = "Operation not permitted";
  CHECK(outcome_of(all).status == Status::inconclusive);
  CHECK_CONTAINS(outcome_of(all).reason(), "SCHED_FIFO (Operation not permitted)");
  all.rights = {.memory = "Cannot allocate memory"};
  CHECK(outcome_of(all).status == Status::inconclusive);
}

TEST("a provoked tick beyond the deadline is enough, though none was met while the loop ran") {
  Certificate all = clean();
  all.budget.probes = {{.name = "cold caches", .processor = 1.01 * deadline}};
  CHECK(outcome_of(all).status == Status::fail);
  CHECK_CONTAINS(outcome_of(all).reason(), "cold caches");
  all.budget.probes.front().processor = std::nan("");
  CHECK(outcome_of(all).status == Status::fail);
}

TEST("one load that fails is enough, and it is the one that is shown") {
  Certificate all = clean();
  LoadResult& load = all.loads.emplace_back("memory", deadline);
  fill(load.control, 1000, 0);
  fill(load.scene, 1000, 2);
  CHECK(outcome_of(all).status == Status::fail);
  CHECK(all.worst()->load == "memory");
}

TEST("a loop that was given up is no good one, even if it counted no miss") {
  Certificate all = clean();
  all.loads.front().scene.hopeless = true;
  CHECK(outcome_of(all).status == Status::fail);
  all.loads.front().control.hopeless = true;
  CHECK(outcome_of(all).status == Status::inconclusive);
}

TEST("a scene that diverges is not certified anywhere") {
  Certificate all = clean(5, 5);
  all.budget.diverged_at = 0.25;
  CHECK(outcome_of(all).status == Status::fail);
}

TEST("interrupted before the scene ran: nothing is known") {
  Certificate all = clean();
  all.loads.clear();
  CHECK(outcome_of(all).status == Status::inconclusive);
  fill(all.loads.emplace_back("idle", deadline).control, 10, 0);
  CHECK(outcome_of(all).status == Status::inconclusive);
}

TEST("who stole the time is named by what was counted") {
  Phase phase(deadline);
  CHECK(suspects(phase).empty());
  phase.times.stolen = 0.25;
  phase.counts.involuntary_switches = 3;
  CHECK_CONTAINS(suspects(phase), "hypervisor took");
  CHECK_CONTAINS(suspects(phase), "3 times");
}

TEST("the computation is told whatever the environment") {
  CHECK_CONTAINS(budget_text(clean(1000, 0)), "40 % of the deadline");
}

Scene short_scene() {
  Scene scene = layered_scene();
  scene.simulation = {.duration = 0.05, .step = 1e-3};
  return scene;
}

/// Runs on its own thread, as the procedure requires, and in virtual time.
Certificate certified(const Scene& scene, CertifyPlan plan) {
  device::VirtualClock time;
  plan.clock = &time;
  Certificate result;
  std::thread([&] { result = certify(scene, plan); }).join();
  return result;
}

TEST(
    "every load has its empty loop and its scene, for the same number of ticks; a short scene "
    "begins again") {
  const Certificate all =
      certified(short_scene(),
                {.claim = {.duration = 0.12}, .loads = {"idle", "cpu"}, .cache_bytes = 1U << 20U});
  CHECK(all.loads.size() == 2);
  for (const LoadResult& load : all.loads) {
    CHECK(load.control.record.ticks() == 120);
    CHECK(load.scene.record.ticks() == 120);
    CHECK(load.scene.restarts == 2);
    CHECK(load.control.restarts == 0);
    CHECK_CONTAINS(load.tail.refusal, "too few ticks");
  }
  CHECK(!all.interrupted);
  REQUIRE(all.notes.empty());
}

TEST("without asking for the rights nothing is certified") {
  const Certificate all =
      certified(short_scene(),
                {.claim = {.duration = 0.05}, .cache_bytes = 1U << 20U, .ask_for_rights = false});
  CHECK(!all.rights.all());
  CHECK(outcome_of(all).status == Status::inconclusive);
}

TEST("a scene that is longer than the loop is noted") {
  const Certificate all =
      certified(short_scene(), {.claim = {.duration = 0.02}, .cache_bytes = 1U << 20U});
  REQUIRE(all.notes.size() == 1);
  CHECK_CONTAINS(all.notes.front(), "first 20 of the scene's 50 ticks");
}

TEST("Ctrl-C leaves a certificate for what ran") {
  const std::atomic<bool> stop{true};
  const Certificate all = certified(short_scene(), {.stop = &stop});
  CHECK(all.interrupted);
  REQUIRE(all.loads.empty());
  CHECK(outcome_of(all).status == Status::inconclusive);
}

TEST("a tool without a device has the bound of the tissue's stiffness") {
  Scene scene = short_scene();
  const Certificate all = certified(
      scene, {.claim = {.duration = 0.02}, .cache_bytes = 1U << 20U, .tissue_stiffness = 1500.0});
  CHECK(all.missed_tick);
  CHECK(!all.missed_tick->measured);
  CHECK_NEAR(all.missed_tick->bound, 0.5 * 1500.0 * 0.02 * 0.02 * 1e-6, 1e-12);  // 20 mm/s for 1 ms
}

TEST("the system's own counters are asked before and after each loop") {
  int asked = 0;
  const Certificate all = certified(
      short_scene(),
      {.claim = {.duration = 0.02}, .cache_bytes = 1U << 20U, .processor_times = [&](int) {
         return ProcessorTimes{.stolen = 1.0 * ++asked};
       }});
  CHECK(asked == 4);
  CHECK_NEAR(all.loads.front().scene.times.stolen, 1.0, 0.0);
}

}  // namespace
