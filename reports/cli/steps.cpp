// SPDX-License-Identifier: MIT

#include <cstdio>
#include <filesystem>
#include <memory>

#include "model/problem/input_error.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/loaded_scene.hpp"
#include "reports/timing/callgrind.hpp"
#include "reports/timing/paired_runs.hpp"
#include "validation/bench/bench_cases.hpp"
#include "validation/certificate/scene_loop.hpp"

namespace palpate::cli {
namespace {

struct StepsOptions : CommonOptions {
  std::string what{};  ///< name of a workload, or a scene file
  std::optional<long>
      before{};  ///< ticks before the profiled ones; empty: those of the workload, or none
  std::optional<long> ticks{};   ///< profiled ticks; empty: those of the workload, or one
  std::optional<double> rate{};  ///< ticks per second of a scene [Hz]; empty: its own rate
  int times = 1;
  std::filesystem::path library{};  ///< step library to use; empty: the code of the program
  std::filesystem::path beside{};   ///< second step library, timed alternately with the first
  int pairs = 40;
  std::uint64_t seed = 1;
  bool head_first = false;  ///< `beside` is loaded first
  bool planted = false;     ///< `beside` computes one extra tick in twenty
};

/// Interface that computes ticks.
struct Stepped {
  std::string kernel{};
  long before = 0;
  long ticks = 1;
  std::function<void(long)> run{};
};

Stepped stepped_workload(const std::string& name) {
  const bench::Workload workload = bench::find_workload(name);
  const auto simulation = std::make_shared<Simulation>(bench::simulation_of(workload));
  return {.kernel = simulation->plan().kernel,
          .before = workload.before,
          .ticks = workload.ticks,
          .run = [simulation](long ticks) {
            for (long n = 0; n < ticks; ++n) { (void)simulation->tick(); }
          }};
}

/// Loop of `palpate certify`, with device and links.
Stepped stepped_scene(const StepsOptions& options) {
  const auto loaded = std::make_shared<LoadedScene>(load_scene(options.what, options, false));
  const Scene& scene = loaded->file.scene;
  const double rate = options.rate.value_or(certificate::rate_of(scene));
  if (const std::string why = certificate::why_not_at(scene, rate); !why.empty()) {
    throw InputError(loaded->file.where("simulation.step") + ": " + why);
  }
  const auto loop = std::make_shared<certificate::SceneLoop>(scene, rate);
  return {.kernel = loop->simulation().plan().kernel, .run = [loaded, loop](long ticks) {
            for (long n = 0; n < ticks; ++n) { (void)loop->tick(); }
          }};
}

Stepped stepped_by_library(const StepsOptions& options) {
  const auto library = std::make_shared<timing::LoadedLibrary>(options.library);
  const auto steps = std::make_shared<timing::LibrarySteps>(library->create(options.what));
  return {.kernel = steps->kernel(), .run = [library, steps](long ticks) { steps->run(ticks); }};
}

bool is_scene(const std::string& what) {
  return std::filesystem::path(what).extension() == ".toml" || std::filesystem::exists(what);
}

Stepped stepped(const StepsOptions& options) {
  if (!options.library.empty()) { return stepped_by_library(options); }
  return is_scene(options.what) ? stepped_scene(options) : stepped_workload(options.what);
}

int print_pairs(const StepsOptions& options) {
  const timing::PairedReport report = timing::time_pairs({.base = options.library,
                                                          .head = options.beside,
                                                          .scene = options.what,
                                                          .pairs = options.pairs,
                                                          .seed = options.seed,
                                                          .head_first = options.head_first,
                                                          .planted = options.planted});
  std::printf("%s", timing::to_text(report).c_str());
  return done;
}

int run_steps(const StepsOptions& options) {
  if (!options.beside.empty()) { return print_pairs(options); }
  for (int n = 0; n < options.times; ++n) {
    const Stepped work = stepped(options);
    const long ticks = options.ticks.value_or(work.ticks);
    work.run(options.before.value_or(work.before));
    timing::run_counted(work.kernel, [&] { work.run(ticks); });
    if (!options.quiet) { std::printf("%ld ticks by %s\n", ticks, work.kernel.c_str()); }
  }
  return done;
}

}  // namespace

void add_steps(CLI::App& app, std::function<int()>& chosen) {
  const auto [command, options] = add_command(
      app, chosen, "steps", "compute ticks of a scene and nothing else, for profilers", run_steps);
  command.add_option("what", options.what, "a workload of bench/instructions, or a scene file")
      ->required()
      ->type_name("WORKLOAD|SCENE");
  add_overrides(command, options, "scene");
  command
      .add_option("--before", options.before, "ticks before the profiled ones [the workload's; 0]")
      ->type_name("N")
      ->check(CLI::Range(0L, 1000000000L));
  command.add_option("--ticks", options.ticks, "profiled ticks [the workload's; 1]")
      ->type_name("N")
      ->check(CLI::Range(1L, 1000000000L));
  command.add_option("--times", options.times, "number of repetitions, each with a new set-up [1]")
      ->type_name("N")
      ->check(CLI::Range(1, 1000));
  command
      .add_option("--rate", options.rate,
                  "ticks per second of a scene [falcon.rate, or one tick per step]")
      ->type_name("HZ")
      ->check(number_range(0.01, 20000.0));
  CLI::Option* library = command
                             .add_option("--library", options.library,
                                         "step library whose code is used [the program's own]")
                             ->type_name("FILE");
  CLI::Option* beside =
      command
          .add_option(
              "--beside", options.beside,
              "second step library, timed alternately with the first; prints pairs of seconds")
          ->type_name("FILE")
          ->needs(library);
  command.add_option("--pairs", options.pairs, "number of pairs of batches [40]")
      ->type_name("N")
      ->check(CLI::Range(1, 100000))
      ->needs(beside);
  command.add_option("--seed", options.seed, "seed of the order within pairs [1]")
      ->type_name("N")
      ->needs(beside);
  command.add_flag("--head-first", options.head_first, "load the second library first")
      ->needs(beside);
  command
      .add_flag("--planted", options.planted,
                "the second library computes one extra tick in twenty")
      ->needs(beside);
  command.add_flag("--quiet", options.quiet, "print errors only");
  command.footer(
      "Computes ticks and nothing else, for profilers. `valgrind --tool=callgrind "
      "--instr-atstart=no "
      "palpate\n"
      "steps cube-list-double` counts the instructions of these ticks alone (docs/bench.md).");
}

}  // namespace palpate::cli
