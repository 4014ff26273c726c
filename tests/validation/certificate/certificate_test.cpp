// SPDX-License-Identifier: MIT

#include "validation/certificate/certificate.hpp"

#include <functional>
#include <thread>

#include "tests/check.hpp"
#include "tests/validation/insertion_scenes.hpp"

namespace {

using namespace palpate::certificate;
using namespace palpate;
TEST("the limit of the probability of a miss is that of Clopper and Pearson") {
  // After no miss 1 - 0.05^(1/n).
  CHECK_NEAR(miss_probability_upper(0, 60000), 1.0 - std::pow(0.05, 1.0 / 60000.0), 1e-15);
  CHECK_NEAR(miss_probability_upper(0, 1), 0.95, 1e-15);
  CHECK_NEAR(miss_probability_upper(1, 2), std::sqrt(0.95), 1e-12);  // P(X <= 1) = 1 - p^2 = 0.05
  // If all ticks missed, or none ran, a probability of one cannot be excluded.
  CHECK_NEAR(miss_probability_upper(3, 3), 1.0, 0.0);
  CHECK_NEAR(miss_probability_upper(0, 0), 1.0, 0.0);
  for (long misses = 0; misses < 50; ++misses) {
    CHECK(miss_probability_upper(misses, 1000) < miss_probability_upper(misses + 1, 1000));
    CHECK(miss_probability_upper(misses, 2000) < miss_probability_upper(misses, 1000));
  }
  constexpr long day = 86400000;  // ticks at 1 kHz
  for (const long misses : {1L, 10L, 1000L, 1000000L, day - 1}) {
    const double limit = miss_probability_upper(misses, day);
    CHECK(limit > static_cast<double>(misses) / day);
    CHECK(limit <= 1.0);
  }
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

struct Row {
  const char* what;
  std::function<void(Certificate&)> change;
  Status status;
  const char* reason = "";
};

TEST("only a scene without a miss, in an environment without a miss, is certified") {
  CHECK_NEAR(clean().worst()->miss_probability_upper(), 1.0 - std::pow(0.05, 1e-3), 1e-15);
  CHECK(outcome_of(clean(0, 1)).status == Status::fail);
  CHECK_CONTAINS(outcome_of(clean(0, 1)).reason(), "1 of 1000 deadlines");
  // If the empty loop missed its deadline, the scene cannot be judged.
  CHECK(outcome_of(clean(1, 0)).status == Status::inconclusive);
  CHECK(outcome_of(clean(1, 500)).status == Status::inconclusive);
  using enum Status;
  const Row rows[] = {
      {"no change", [](auto&) {}, pass, "No tick of 1000 missed"},
      {"no real-time priority", [](auto& c) { c.rights.fifo = "Operation not permitted"; },
       inconclusive, "SCHED_FIFO (Operation not permitted)"},
      {"memory not locked", [](auto& c) { c.rights = {.memory = "Cannot allocate"}; },
       inconclusive},
      {"late probe",
       [](auto& c) { c.budget.probes = {{.name = "cold caches", .processor = 1.01e-3}}; }, fail,
       "cold caches"},
      {"probe that is not a number",
       [](auto& c) { c.budget.probes.front().processor = std::nan(""); }, fail},
      {"scene abandoned", [](auto& c) { c.loads.front().scene.hopeless = true; }, fail},
      {"empty loop abandoned", [](auto& c) { c.loads.front().control.hopeless = true; },
       inconclusive},
      {"divergence, whatever the environment",
       [](auto& c) {
         c = clean(5, 5);
         c.budget.diverged_at = 0.25;
       },
       fail},
      {"no load", [](auto& c) { c.loads.clear(); }, inconclusive},
      {"interrupted before the scene ran",
       [](auto& c) {
         c.loads.clear();
         fill(c.loads.emplace_back("idle", deadline).control, 10, 0);
       },
       inconclusive},
  };
  for (const Row& row : rows) {
    Certificate all = clean();
    row.change(all);
    const Outcome outcome = outcome_of(all);
    check::row = row.what;
    CHECK(outcome.status == row.status);
    CHECK_CONTAINS(outcome.reason(), row.reason);
  }
}

TEST("one load that fails is enough, and it is shown") {
  Certificate all = clean();
  LoadResult& load = all.loads.emplace_back("memory", deadline);
  fill(load.control, 1000, 0);
  fill(load.scene, 1000, 2);
  CHECK(outcome_of(all).status == Status::fail);
  CHECK(all.worst()->load == "memory");
}

TEST("suspects of lost time follow from the counters; the budget is a share of the deadline") {
  Phase phase(deadline);
  CHECK(suspects(phase).empty());
  phase.times.stolen = 0.25;
  phase.counts.involuntary_switches = 3;
  CHECK_CONTAINS(suspects(phase), "hypervisor took", "3 times");
  CHECK_CONTAINS(budget_text(clean(1000, 0)), "40 % of the deadline");
}

/// Runs on its own thread, as the procedure requires, and in virtual time.
Certificate certified(CertifyPlan plan) {
  device::VirtualClock time;
  plan.clock = &time;
  plan.cache_bytes = 1U << 20U;
  Certificate result;
  std::thread([&] { result = certify(insertion_scene(0.05), plan); }).join();
  return result;
}

TEST("each load runs the empty loop and the scene, a short one repeatedly, for equal ticks") {
  const Certificate all = certified({.claim = {.duration = 0.12}, .loads = {"idle", "cpu"}});
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

TEST("without real-time rights nothing is certified") {
  const Certificate all = certified({.claim = {.duration = 0.05}, .ask_for_rights = false});
  CHECK(!all.rights.all());
  CHECK(outcome_of(all).status == Status::inconclusive);
}

TEST("Ctrl-C leaves a certificate of the loads that ran") {
  const std::atomic<bool> stop{true};
  const Certificate all = certified({.stop = &stop});
  CHECK(all.interrupted);
  REQUIRE(all.loads.empty());
  CHECK(outcome_of(all).status == Status::inconclusive);
}

TEST("a loop shorter than its scene has a note, counters and the bound of a missed tick") {
  int reads = 0;
  const Certificate all = certified(
      {.claim = {.duration = 0.02}, .tissue_stiffness = 1500.0, .processor_times = [&](int) {
         return ProcessorTimes{.stolen = 1.0 * ++reads};
       }});
  REQUIRE(all.notes.size() == 1);
  CHECK_CONTAINS(all.notes.front(), "first 20 of the scene's 50 ticks");
  CHECK(reads == 4);  // before and after each loop
  CHECK_NEAR(all.loads.front().scene.times.stolen, 1.0, 0.0);
  // A tool without a device has the bound of the tissue's stiffness.
  REQUIRE(all.missed_tick.has_value());
  CHECK(!all.missed_tick->measured);
  CHECK_NEAR(all.missed_tick->bound, 0.5 * 1500.0 * 0.02 * 0.02 * 1e-6, 1e-12);  // 20 mm/s for 1 ms
}

}  // namespace
