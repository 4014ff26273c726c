// SPDX-License-Identifier: MIT
#include "reports/cli/timing_arguments.hpp"

#include "reports/cli/common_arguments.hpp"
#include "reports/cli/number_range.hpp"

namespace palpate::cli {

void add_bench(CLI::App& command, BenchOptions& options) {
  command.add_option("cases", options.cases, "benches or groups; all when none")->type_name("CASE");
  add_common(command, options, "bench");
  command.add_flag("--list", options.list, "name every bench and stop");
  command.add_flag("--quick", options.quick, "the short form");
  command
      .add_option("--history", options.history,
                  "append what was found as a line of JSON, and look for slow creep in the runs that stand there")
      ->type_name("FILE");
  command
      .add_option("--cache", options.cache, "folder of kept references and of libraries of revisions [user's cache]")
      ->type_name("DIR");
  CLI::Option* against =
      command
          .add_option(
              "--against", options.against,
              "time this build in pairs with that of a revision (scripts/build-base makes it), or with a library")
          ->type_name("REV|FILE");
  command
      .add_option("--self-test", options.self_test,
                  "so many comparisons of this build with itself, and with itself slowed down by 5 %")
      ->type_name("N")
      ->check(CLI::Range(1, 10000))
      ->excludes(against);
}

void add_steps(CLI::App& command, StepsOptions& options) {
  command.add_option("what", options.what, "a workload of bench/instructions, or a scene file")
      ->required()
      ->type_name("WORKLOAD|SCENE");
  add_overrides(command, options, "scene");
  command.add_option("--before", options.before, "ticks that a profiler does not look at [the workload's; 0]")
      ->type_name("N")
      ->check(CLI::Range(0L, 1000000000L));
  command.add_option("--ticks", options.ticks, "ticks that it looks at [the workload's; 1]")
      ->type_name("N")
      ->check(CLI::Range(1L, 1000000000L));
  command.add_option("--times", options.times, "how often all that is done, set up anew each time [1]")
      ->type_name("N")
      ->check(CLI::Range(1, 1000));
  command.add_option("--rate", options.rate, "ticks of a scene a second [falcon.rate, or a tick a step]")
      ->type_name("HZ")
      ->check(number_range(0.01, 20000.0));
  CLI::Option* library =
      command.add_option("--library", options.library, "step library whose code is used [the program's own]")
          ->type_name("FILE");
  CLI::Option* beside =
      command
          .add_option("--beside", options.beside, "another that is timed in turn with it; prints pairs of seconds")
          ->type_name("FILE")
          ->needs(library);
  command.add_option("--pairs", options.pairs, "of batches [40]")
      ->type_name("N")
      ->check(CLI::Range(1, 100000))
      ->needs(beside);
  command.add_option("--seed", options.seed, "of the order within pairs [1]")->type_name("N")->needs(beside);
  command.add_flag("--head-first", options.head_first, "load the other one first")->needs(beside);
  command.add_flag("--planted", options.planted, "the other one takes one tick in twenty more")->needs(beside);
  command.add_flag("--quiet", options.quiet, "say nothing but errors");
  command.footer(
      "Steps, and does nothing else: for profilers. `valgrind --tool=callgrind --instr-atstart=no palpate\n"
      "steps cube-list-double` counts the instructions of these ticks alone (docs/bench.md).");
}

}  // namespace palpate::cli
