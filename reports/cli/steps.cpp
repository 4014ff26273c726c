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

/// Whatever takes ticks.
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

/// As `palpate certify` steps it, with its device and its lines.
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

}  // namespace

int steps(const StepsOptions& options) {
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

}  // namespace palpate::cli
