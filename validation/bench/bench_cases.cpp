// SPDX-License-Identifier: MIT

#include "validation/bench/bench_cases.hpp"

#include <algorithm>
#include <iterator>

#include "model/problem/input_error.hpp"
#include "model/tissue/network_builder.hpp"
#include "validation/bench/kernel_variants.hpp"
#include "validation/claims/tool_fixture.hpp"
#include "validation/text.hpp"

namespace palpate::bench {

std::vector<Case> all_benches(const timing::InstructionCounter& counter) {
  std::vector<Case> cases = kernel_cases();
  for (std::vector<Case> more :
       {precision_cases(), needle_cases(), frontier_cases(), instruction_cases(counter)}) {
    std::ranges::move(more, std::back_inserter(cases));
  }
  return cases;
}

namespace {

Workload cube(const char* name, bool as_list, Precision precision) {
  Workload workload{.name = name,
                    .what = "1000 nodes, 26 neighbours, semi-implicit Euler",
                    .scene = s26_scene(10),
                    .as_list = as_list};
  workload.scene.simulation.precision = precision;
  return workload;
}

/// Scene while the tip pierces skin and fat.
Workload needle(const char* name, const char* what, Scene scene, const char* integrator) {
  scene.simulation.integrator = integrator;
  scene.simulation.solver_tolerance = 1e-2;
  return {.name = name, .what = what, .scene = std::move(scene), .before = 60, .ticks = 10};
}

}  // namespace

std::vector<Workload> workloads() {
  using enum Precision;
  Workload oscillator{
      .name = "oscillator", .what = "one spring, velocity Verlet", .before = 100, .ticks = 1000};
  oscillator.scene.tissue.source = Source::oscillator;
  oscillator.scene.simulation = {.duration = 25.0, .step = 0.01, .integrator = "velocity-verlet"};
  oscillator.scene.simulation.substeps = 1;
  return {oscillator,
          cube("cube-list-double", true, double_precision),
          cube("cube-list-float", true, single_precision),
          cube("cube-lattice-double", false, double_precision),
          cube("cube-lattice-float", false, single_precision),
          needle("needle-explicit", "a needle in seven soft layers, velocity Verlet",
                 tools::seven_soft_layers(), "velocity-verlet"),
          needle("needle-implicit", "a needle in ligament of published modulus, implicit Euler",
                 tools::seven_published_layers(6), "implicit-euler")};
}

Workload find_workload(const std::string& name) {
  std::vector<Workload> all = workloads();
  const auto found = std::ranges::find(all, name, &Workload::name);
  if (found != all.end()) { return *found; }
  std::vector<std::string> names;
  for (const Workload& each : all) { names.push_back(each.name); }
  throw InputError("no workload is named \"" + name + "\"; one of " + join(names));
}

Simulation simulation_of(const Workload& workload) {
  if (!workload.as_list) { return Simulation(workload.scene); }
  SpringNetwork network = build_network(workload.scene);
  break_lattice(network);
  return {workload.scene, network};
}

// Instructions per tick, which do not depend on load or speed of the machine.

namespace {

using timing::InstructionCount;
using timing::InstructionCounter;

Table counts_table(const Workload& workload, const InstructionCount& count, double spring_steps) {
  const auto ticks = static_cast<double>(workload.ticks);
  Table table{.id = "instructions",
              .title = "Instructions",
              .caption = "Counted by " + count.counter + " in " + std::to_string(workload.ticks) +
                         " ticks after the first " + std::to_string(workload.before) +
                         ", each time in a process of its own. The kernel is what the processor "
                         "that it emulates got.",
              .columns = {"time", "kernel", "in all", "a tick", "a spring and step"},
              .timing = true};
  for (std::size_t n = 0; n < count.passes.size(); ++n) {
    const auto all = static_cast<double>(count.passes[n]);
    table.rows.push_back(
        {static_cast<double>(n + 1), count.kernel, all, all / ticks, all / ticks / spring_steps});
  }
  return table;
}

void measure(const Workload& workload, const InstructionCounter& counter, Outcome& outcome) {
  const InstructionCount count = counter(workload.name);
  if (!count.refusal.empty()) {
    outcome.skip("not run: " + count.refusal);
    return;
  }
  // Spring computations per tick, without additional evaluations of a scheme.
  const Simulation simulation = simulation_of(workload);
  const double spring_steps =
      static_cast<double>(simulation.spring_count()) * simulation.plan().substeps;
  const double a_tick =
      static_cast<double>(count.passes.front()) / static_cast<double>(workload.ticks);
  // Another kernel is another claim, and no slowdown of this one.
  outcome.claim += " Kernel: " + count.kernel + ".";
  outcome.judge_between("difference_on_repeat",
                        static_cast<double>(std::abs(count.passes.back() - count.passes.front())),
                        0.0, 0.0, "the same work from the same start, in a process of its own",
                        "instructions");
  outcome.report("instructions_per_tick", a_tick, "instructions");
  outcome.report("instructions_per_spring_step", a_tick / spring_steps, "instructions/spring-step");
  outcome.tables.push_back(counts_table(workload, count, spring_steps));
}

}  // namespace

std::vector<Case> instruction_cases(const InstructionCounter& counter) {
  std::vector<Case> cases;
  for (const Workload& workload : workloads()) {
    cases.push_back(
        {.name = "bench/instructions/" + workload.name,
         .suite = "timing",
         .claim = "A tick takes the same instructions every time: " + workload.what + ".",
         .measure = [workload, counter](const CaseContext&,
                                        Outcome& outcome) { measure(workload, counter, outcome); },
         .weight = 5.0});
  }
  return cases;
}

}  // namespace palpate::bench
