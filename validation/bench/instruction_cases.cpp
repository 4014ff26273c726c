// SPDX-License-Identifier: MIT
/// What a tick costs in instructions, which neither a busy machine nor a faster one changes.
#include "validation/bench/bench_cases.hpp"
#include "validation/bench/workloads.hpp"

namespace palpate::bench {

namespace {

using timing::InstructionCount;
using timing::InstructionCounter;

Table counts_table(const Workload& workload, const InstructionCount& count, double spring_steps) {
  const auto ticks = static_cast<double>(workload.ticks);
  Table table{.id = "instructions",
              .title = "Instructions",
              .caption = "Counted by " + count.counter + " in " + std::to_string(workload.ticks) +
                         " ticks after the first " + std::to_string(workload.before) +
                         ", each time in a process of its own. The kernel is what the processor that it emulates got.",
              .columns = {"time", "kernel", "in all", "a tick", "a spring and step"},
              .timing = true};
  for (std::size_t n = 0; n < count.passes.size(); ++n) {
    const auto all = static_cast<double>(count.passes[n]);
    table.rows.push_back({static_cast<double>(n + 1), count.kernel, all, all / ticks, all / ticks / spring_steps});
  }
  return table;
}

void measure(const Workload& workload, const InstructionCounter& counter, Outcome& outcome) {
  const InstructionCount count = counter(workload.name);
  if (!count.refusal.empty()) {
    outcome.skip("not run: " + count.refusal);
    return;
  }
  const double spring_steps = spring_steps_of_tick(simulation_of(workload));
  const double a_tick = static_cast<double>(count.passes.front()) / static_cast<double>(workload.ticks);
  outcome.claim += " Kernel: " + count.kernel + ".";  // another one is another claim, and no slowdown of this one
  outcome.judge({.name = "difference_on_repeat",
                 .value = static_cast<double>(std::abs(count.passes.back() - count.passes.front())),
                 .unit = "instructions",
                 .lower = 0.0,
                 .upper = 0.0,
                 .bound_from = "the same work from the same start, in a process of its own"});
  outcome.judge({.name = "instructions_per_tick", .value = a_tick, .unit = "instructions"});
  outcome.judge(
      {.name = "instructions_per_spring_step", .value = a_tick / spring_steps, .unit = "instructions/spring-step"});
  outcome.tables.push_back(counts_table(workload, count, spring_steps));
}

}  // namespace

std::vector<Case> instruction_cases(const InstructionCounter& counter) {
  std::vector<Case> cases;
  for (const Workload& workload : workloads()) {
    cases.push_back({.name = "bench/instructions/" + workload.name,
                     .suite = "timing",
                     .claim = "A tick takes the same instructions every time: " + workload.what + ".",
                     .measure = [workload, counter](const CaseContext&,
                                                    Outcome& outcome) { measure(workload, counter, outcome); },
                     .weight = 5.0});
  }
  return cases;
}

}  // namespace palpate::bench
