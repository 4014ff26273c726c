// SPDX-License-Identifier: MIT

#include "validation/bench/bench_cases.hpp"

#include <algorithm>
#include <iterator>

#include "model/problem/input_error.hpp"
#include "model/tissue/network_builder.hpp"
#include "validation/claims/groups.hpp"
#include "validation/claims/tool_fixture.hpp"
#include "validation/number_text.hpp"
#include "validation/signal.hpp"

namespace palpate::bench {

std::vector<Case> all_benches(const timing::InstructionCounter& counter) {
  std::vector<Case> cases = kernel_cases();
  for (std::vector<Case> more :
       {precision_cases(), needle_cases(), frontier_cases(), instruction_cases(counter)}) {
    std::ranges::move(more, std::back_inserter(cases));
  }
  cases.push_back(subjects::cost_case());
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

void break_lattice(SpringNetwork& network) {
  const double distance = (network.rest_position.col(2) - network.rest_position.col(0)).norm();
  network.springs.push_back({0, 2, 1e-9, 0.0, distance});
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
  Table table = make_table("instructions", "Instructions",
                           "Counted by " + count.counter + " in " + std::to_string(workload.ticks) +
                               " ticks after the first " + std::to_string(workload.before) +
                               ", each time in a process of its own. The kernel is what the "
                               "processor that it emulates got.",
                           {"time", "kernel", "in all", "a tick", "a spring and step"});
  table.timing = true;
  for (std::size_t n = 0; n < count.passes.size(); ++n) {
    const auto all = static_cast<double>(count.passes[n]);
    table.rows.push_back({n + 1, count.kernel, all, all / ticks, all / ticks / spring_steps});
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
  outcome.judge_between(
      "difference_on_repeat", std::abs(count.passes.back() - count.passes.front()), 0.0, 0.0,
      "the same work from the same start, in a process of its own", "instructions");
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

namespace {

using timing::PairedStart;
using timing::PairedVerdict;

bool counted(const PairedFinding& finding) {
  return !finding.base.passes.empty() && !finding.head.passes.empty();
}

/// NaN where nobody counted.
double instruction_ratio(const PairedFinding& finding) {
  if (!counted(finding)) { return std::nan(""); }
  return static_cast<double>(finding.head.passes.front()) /
         static_cast<double>(finding.base.passes.front());
}

/// Returns true if the counts confirm the times.
bool has_a_cause(const PairedFinding& finding, const PairedVerdict& verdict) {
  return !counted(finding) || instruction_ratio(finding) > 1.0 || verdict.misses_rose();
}

Table starts_table(const PairedFinding& finding) {
  Table table =
      make_table("starts", "Starts of the process",
                 "Each loads the libraries in the other order. Head over base; what identical "
                 "libraries show here is where they lie in memory.",
                 {"start", "pairs", "median ratio", "base, median (us)", "head, median (us)"});
  table.timing = true;
  for (std::size_t n = 0; n < finding.starts.size(); ++n) {
    const PairedStart& start = finding.starts[n];
    std::vector<double> base, head;
    for (const timing::Pair& pair : start.pairs) {
      base.push_back(1e6 * pair.base);
      head.push_back(1e6 * pair.head);
    }
    table.rows.push_back({n + 1, start.pairs.size(), timing::judge_pairs({&start, 1}).ratio,
                          comparison::quantile(base, 0.5), comparison::quantile(head, 0.5)});
  }
  return table;
}

void tell(const PairedFinding& finding, const PairedVerdict& verdict, Outcome& outcome) {
  outcome.report("time_ratio", verdict.ratio);
  outcome.report("time_ratio_lower_99", verdict.lower);
  outcome.report("time_ratio_upper_99", verdict.upper);
  outcome.report("instruction_ratio", instruction_ratio(finding));
  outcome.report("missed_batches_of_base", verdict.base_misses);
  outcome.report("missed_batches_of_head", verdict.head_misses);
  outcome.tables.push_back(starts_table(finding));
  outcome.notes.emplace_back(finding.same_motion
                                 ? "Both builds move alike to the last bit."
                                 : "The two builds do not move alike to the last bit.");
  if (!counted(finding)) {
    outcome.notes.push_back("Instructions were not counted: " + finding.head.refusal + ".");
  }
}

void compare(const PairedFinding& finding, Outcome& outcome) {
  const PairedVerdict verdict = timing::judge_pairs(finding.starts);
  tell(finding, verdict, outcome);
  if (verdict.slower() && !has_a_cause(finding, verdict)) {
    outcome.notes.emplace_back(
        "The clock says slower, but nothing more is done and no more deadlines are missed: where "
        "code lies in memory, or the machine.");
  }
  outcome.judge_at_most(
      "slowdown_with_a_cause",
      has_a_cause(finding, verdict) ? verdict.lower : std::min(verdict.lower, 1.0),
      timing::allowed_slowdown,
      "wanted: no build is 3 % slower, with 99 % confidence, by a clock that instructions or "
      "missed deadlines bear out");
}

struct Alarms {
  int by_clock = 0;
  int in_all = 0;
  std::vector<double> ratios{};
};

Alarms alarms_of(const std::string& scene, Head head, int comparisons,
                 const PairedMeasurement& measure) {
  Alarms alarms;
  for (int n = 0; n < comparisons; ++n) {
    const PairedFinding finding = measure(scene, head, static_cast<std::uint64_t>(n) + 1);
    const PairedVerdict verdict = timing::judge_pairs(finding.starts);
    alarms.by_clock += verdict.slower() ? 1 : 0;
    alarms.in_all += is_slower(finding) ? 1 : 0;
    alarms.ratios.push_back(verdict.ratio);
  }
  return alarms;
}

void self_test(const std::string& scene, int comparisons, const PairedMeasurement& measure,
               Outcome& outcome) {
  // Fewer comparisons with the planted slowdown: false alarms must be rarer than missed slowdowns.
  const int planted_count = comparisons < 20 ? comparisons : std::max(20, comparisons / 10);
  const Alarms same = alarms_of(scene, Head::as_built, comparisons, measure);
  const Alarms planted = alarms_of(scene, Head::planted, planted_count, measure);
  outcome.judge_equal("alarms_at_the_same_build", same.in_all, 0.0,
                      "a build is not slower than itself");
  outcome.judge_equal("missed_slowdowns",
                      static_cast<double>(planted.ratios.size()) - planted.in_all, 0.0,
                      "one tick in twenty more is 5 % slower, which is more than 3 %");
  Table& table =
      outcome.table("self-test", "The comparison, compared",
                    "A build against itself, and against itself with one tick in twenty more.",
                    {"head", "comparisons", "alarms", "alarms of the clock alone", "least ratio",
                     "largest ratio"});
  table.timing = true;
  for (const auto& [name, alarms] :
       {std::pair{"the same", &same}, std::pair{"5 % planted", &planted}}) {
    table.rows.push_back({name, alarms->ratios.size(), alarms->in_all, alarms->by_clock,
                          *std::ranges::min_element(alarms->ratios),
                          *std::ranges::max_element(alarms->ratios)});
  }
}

}  // namespace

bool is_slower(const PairedFinding& finding) {
  const PairedVerdict verdict = timing::judge_pairs(finding.starts);
  return verdict.slower() && has_a_cause(finding, verdict);
}

std::vector<Case> paired_cases(const std::vector<std::string>& scenes,
                               const PairedMeasurement& measure) {
  std::vector<Case> cases;
  for (const std::string& scene : scenes) {
    cases.push_back({"bench/paired/" + scene, "timing",
                     "Ticks of " + scene + ".toml are not slower than before.",
                     [=](const CaseContext&, Outcome& outcome) {
                       compare(measure(scene, Head::as_built, 1), outcome);
                     }});
  }
  return cases;
}

std::vector<Case> self_test_cases(const std::vector<std::string>& scenes, int comparisons,
                                  const PairedMeasurement& measure) {
  std::vector<Case> cases;
  for (const std::string& scene : scenes) {
    cases.push_back(
        {"bench/self-test/" + scene, "timing",
         "With " + scene +
             ".toml a build is never called slower than itself, and 5 % are always seen.",
         [=](const CaseContext&, Outcome& outcome) {
           self_test(scene, comparisons, measure, outcome);
         }});
  }
  return cases;
}

}  // namespace palpate::bench
