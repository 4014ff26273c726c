// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include <unistd.h>

#include "fixtures/io/network_csv.hpp"
#include "model/dynamics/scene_check.hpp"
#include "reports/cli/case_runner.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/interrupt.hpp"
#include "reports/cli/loaded_scene.hpp"
#include "reports/cli/provenance.hpp"
#include "reports/cli/reference_cache.hpp"
#include "reports/results_folder.hpp"
#include "validation/bench/bench_cases.hpp"

namespace palpate::cli {

namespace {

int list(const std::vector<Case>& cases) {
  for (const Case& one : cases) {
    std::printf("%-40s %-10s %s\n", one.name.c_str(), one.suite.c_str(), one.claim.c_str());
  }
  return done;
}

/// Folders that may hold data sets which the project does not contain.
std::vector<std::filesystem::path> data_folders(const std::filesystem::path& given) {
  if (!given.empty()) { return {given}; }
  std::vector<std::filesystem::path> folders;
  if (const char* from_environment = std::getenv("PALPATE_DATA")) {
    folders.emplace_back(from_environment);
  }
  folders.emplace_back("../shared/data");
  folders.emplace_back(std::filesystem::path(PALPATE_SOURCE_DIR) / "../shared/data");
  return folders;
}

std::optional<SpringNetwork> outside_network(const std::vector<std::filesystem::path>& folders,
                                             std::string_view name) {
  for (const std::filesystem::path& folder : folders) {
    const std::filesystem::path here = folder / name;
    if (!std::filesystem::exists(here / "nodes.csv")) { continue; }
    io::Problems problems;
    SpringNetwork network = io::read_network_csv(
        {.nodes = here / "nodes.csv", .springs = here / "springs.csv"}, problems);
    problems.throw_if_any();
    return network;
  }
  return std::nullopt;
}

CaseContext context_of(const ValidateOptions& options, const reference::Cache& cache) {
  CaseContext context;
  context.quick = options.quick;
  context.skip = !options.no_skip;
  context.cache = &cache;
  context.outside_network = [folders = data_folders(options.data)](std::string_view name) {
    return outside_network(folders, name);
  };
  return context;
}

void tell_case(const Outcome& outcome, std::size_t finished, std::size_t total) {
  std::printf("%3zu/%zu %-5s %7.2f s  %s%s%s\n", finished, total,
              std::string(name_of(outcome.status)).c_str(), outcome.seconds, outcome.name.c_str(),
              outcome.reason.empty() ? "" : ": ", outcome.reason.c_str());
  for (const Quantity& q : outcome.quantities) {
    if (!q.judged() || q.holds()) { continue; }
    std::printf("            %s = %.6g %s; allowed %.6g to %.6g (%s)\n", q.name.c_str(), q.value,
                q.unit.c_str(), q.lower, q.upper, q.bound_from.c_str());
  }
  std::fflush(stdout);
}

std::size_t count(const std::vector<Outcome>& outcomes, Status status) {
  return static_cast<std::size_t>(
      std::ranges::count(outcomes, status, [](const Outcome& one) { return one.status; }));
}

/// What two commands differ in.
struct Judging {
  std::string command{};  ///< "validate"
  std::string title{};
  std::vector<Case> cases{};
  int jobs = 1;
};

std::string command_text(const ValidateOptions& options, const std::string& command) {
  std::string text = "palpate " + command;
  for (const std::string& each : options.cases) { text += " " + each; }
  if (options.quick) { text += " --quick"; }
  if (options.no_skip) { text += " --no-skip"; }
  return text;
}

int judge(const ValidateOptions& options, const Judging& what) {
  if (options.list) { return list(what.cases); }
  const std::vector<Case> cases = select_cases(what.cases, options.cases, options.quick);
  const std::filesystem::path folder = make_folder(options.folder(what.command));
  // Threads of an interrupted run still use it when this function is gone.
  static const reference::Cache cache =
      cache_in(options.cache.empty() ? default_cache_folder() : options.cache);
  const RunnerResult ran =
      run_cases(cases, context_of(options, cache), what.jobs, interrupted,
                [&](const Outcome& outcome, std::size_t finished, std::size_t total) {
                  if (!options.quiet) { tell_case(outcome, finished, total); }
                });
  const Results results{.title = what.title,
                        .command = command_text(options, what.command),
                        .provenance = build_provenance(),
                        .outcomes = ran.outcomes};
  write_results_folder(folder, results);
  const std::size_t fallen = count(ran.outcomes, Status::fail) + count(ran.outcomes, Status::error);
  if (!options.quiet) {
    std::printf("%zu passed, %zu failed, %zu skipped of %zu cases; %s\n",
                count(ran.outcomes, Status::pass), fallen, count(ran.outcomes, Status::skip),
                cases.size(), (folder / "report.html").string().c_str());
  }
  if (ran.interrupted) {
    std::fflush(nullptr);
    std::_Exit(interrupted_code);  // cases still run on threads that cannot be stopped
  }
  return fallen == 0 && count(ran.outcomes, Status::pass) > 0 ? done : fell_short;
}

}  // namespace

int validate(const ValidateOptions& options) {
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return judge(options, {.command = "validate",
                         .title = "Palpate validation",
                         .cases = all_cases(),
                         .jobs = options.jobs > 0 ? options.jobs : cores});
}

/// One at a time: what is timed has the machine to itself.
int bench(const ValidateOptions& options) {
  return judge(options,
               {.command = "bench", .title = "Palpate benchmark", .cases = bench::all_benches(), .jobs = 1});
}

}  // namespace palpate::cli
