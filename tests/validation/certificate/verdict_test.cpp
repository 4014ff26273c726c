// SPDX-License-Identifier: MIT
#include "validation/certificate/verdict.hpp"

#include <cmath>

#include "tests/check.hpp"

namespace {

using namespace palpate::certificate;

constexpr double deadline = 1e-3;

void fill(Phase& phase, long ticks, long misses) {
  for (long n = 0; n < ticks; ++n) {
    const double due = 1e-3 * static_cast<double>(n);
    phase.record.add({.due = due, .begin = due, .end = due + (n < misses ? 2.0 : 0.5) * deadline}, {});
  }
}

Certificate clean(long control_misses = 0, long scene_misses = 0) {
  Certificate all;
  all.claim = {.rate = 1000.0, .deadline = deadline, .duration = 1.0};
  all.budget.provocations = {{.name = "first tick", .processor = 0.4 * deadline}};
  LoadResult& load = all.loads.emplace_back("idle", deadline);
  fill(load.control, 1000, control_misses);
  fill(load.scene, 1000, scene_misses);
  return all;
}

TEST("no miss at all is certified, with the limit that so many ticks support") {
  const Judgement judgement = judge(clean());
  CHECK(judgement.verdict == Verdict::certified);
  CHECK(judgement.reason.find("No tick of 1000 missed") != std::string::npos);
  CHECK_NEAR(clean().worst()->miss_probability_upper(), 1.0 - std::pow(0.05, 1e-3), 1e-15);
}

TEST("a single miss of the scene is not certified") {
  const Judgement judgement = judge(clean(0, 1));
  CHECK(judgement.verdict == Verdict::not_certified);
  CHECK(judgement.reason.find("1 of 1000 deadlines") != std::string::npos);
}

TEST("where the empty loop missed, nothing is said against the scene, whatever it did") {
  CHECK(judge(clean(1, 0)).verdict == Verdict::not_qualified);
  CHECK(judge(clean(1, 500)).verdict == Verdict::not_qualified);
}

TEST("without the rights nothing is certified, however well it went") {
  Certificate all = clean();
  all.rights.fifo = "Operation not permitted";
  CHECK(judge(all).verdict == Verdict::not_qualified);
  CHECK(judge(all).reason.find("SCHED_FIFO (Operation not permitted)") != std::string::npos);
  all.rights = {.memory = "Cannot allocate memory"};
  CHECK(judge(all).verdict == Verdict::not_qualified);
}

TEST("a provoked tick beyond the deadline is enough, though none was met while the loop ran") {
  Certificate all = clean();
  all.budget.provocations = {{.name = "cold caches", .processor = 1.01 * deadline}};
  CHECK(judge(all).verdict == Verdict::not_certified);
  CHECK(judge(all).reason.find("cold caches") != std::string::npos);
  all.budget.provocations.front().processor = std::nan("");
  CHECK(judge(all).verdict == Verdict::not_certified);
}

TEST("one load that fails is enough, and it is the one that is shown") {
  Certificate all = clean();
  LoadResult& load = all.loads.emplace_back("memory", deadline);
  fill(load.control, 1000, 0);
  fill(load.scene, 1000, 2);
  CHECK(judge(all).verdict == Verdict::not_certified);
  CHECK(all.worst()->load == "memory");
}

TEST("a loop that was given up is no good one, even if it counted no miss") {
  Certificate all = clean();
  all.loads.front().scene.hopeless = true;
  CHECK(judge(all).verdict == Verdict::not_certified);
  all.loads.front().control.hopeless = true;
  CHECK(judge(all).verdict == Verdict::not_qualified);
}

TEST("a scene that diverges is not certified anywhere") {
  Certificate all = clean(5, 5);
  all.budget.diverged_at = 0.25;
  CHECK(judge(all).verdict == Verdict::not_certified);
}

TEST("interrupted before the scene ran: nothing is known") {
  Certificate all = clean();
  all.loads.clear();
  CHECK(judge(all).verdict == Verdict::not_qualified);
  fill(all.loads.emplace_back("idle", deadline).control, 10, 0);
  CHECK(judge(all).verdict == Verdict::not_qualified);
}

TEST("who stole the time is named by what was counted") {
  Phase phase(deadline);
  CHECK(suspects(phase).empty());
  phase.times.stolen = 0.25;
  phase.counts.involuntary_switches = 3;
  CHECK(suspects(phase).find("hypervisor took") != std::string::npos);
  CHECK(suspects(phase).find("3 times") != std::string::npos);
}

TEST("the computation is told whatever the environment") {
  CHECK(budget_words(clean(1000, 0)).find("40 % of the deadline") != std::string::npos);
}

}  // namespace
