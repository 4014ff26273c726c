// SPDX-License-Identifier: MIT

#include <cstdio>

#include "model/problem/input_error.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/loaded_scene.hpp"
#include "reports/timing/child_process.hpp"
#include "reports/timing/paired_runs.hpp"
#include "validation/bench/bench_cases.hpp"
#include "validation/certificate/scene_loop.hpp"

namespace palpate::cli {
namespace {

struct StepsOptions : CommonOptions {
  std::string what{};            ///< name of a workload, or a scene file
  std::optional<long> before{};  ///< ticks before the profiled ones; empty: the workload's
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
  return {.kernel = static_cast<ModelSubject&>(loop->subject()).simulation().plan().kernel,
          .run = [loaded, loop](long ticks) {
            for (long n = 0; n < ticks; ++n) { (void)loop->tick(); }
          }};
}

Stepped stepped_by_library(const StepsOptions& options) {
  const auto library = std::make_shared<timing::LoadedLibrary>(options.library);
  const std::shared_ptr<palpate_steps> steps = library->create(options.what);
  return {.kernel = library->kernel(steps.get()),
          .run = [library, steps](long ticks) { (void)library->run(steps.get(), ticks); }};
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

void add_steps(Program& program) {
  const auto [command, options] = add_command(
      program, "steps", "compute ticks of a scene and nothing else, for profilers", run_steps);
  add_value(command, "what", options.what, "WORKLOAD|SCENE",
            "a workload of bench/instructions, or a scene file")
      ->required();
  add_overrides(command, options);
  add_value(command, "--before", options.before, "N",
            "ticks before the profiled ones [the workload's; 0]")
      ->check(CLI::Range(0L, 1000000000L));
  add_value(command, "--ticks", options.ticks, "N", "profiled ticks [the workload's; 1]")
      ->check(CLI::Range(1L, 1000000000L));
  add_value(command, "--times", options.times, "N",
            "number of repetitions, each with a new set-up [1]")
      ->check(CLI::Range(1, 1000));
  add_value(command, "--rate", options.rate, "HZ",
            "ticks per second of a scene [falcon.rate, or one tick per step]")
      ->check(number_range(0.01, 20000.0));
  CLI::Option* library = add_value(command, "--library", options.library, "FILE",
                                   "step library whose code is used [the program's own]");
  CLI::Option* beside =
      add_value(command, "--beside", options.beside, "FILE",
                "second step library, timed alternately with the first; prints pairs of seconds")
          ->needs(library);
  add_value(command, "--pairs", options.pairs, "N", "number of pairs of batches [40]")
      ->check(CLI::Range(1, 100000))
      ->needs(beside);
  add_value(command, "--seed", options.seed, "N", "seed of the order within pairs [1]")
      ->check(seed_range())
      ->needs(beside);
  command.add_flag("--head-first", options.head_first, "load the second library first")
      ->needs(beside);
  command
      .add_flag("--planted", options.planted,
                "the second library computes one extra tick in twenty")
      ->needs(beside);
  command.footer(
      "Computes ticks and nothing else, for profilers. `valgrind --tool=callgrind "
      "--instr-atstart=no palpate\n"
      "steps cube-list-double` counts the instructions of these ticks alone (docs/bench.md).");
}

}  // namespace palpate::cli
