// SPDX-License-Identifier: MIT
#include "reports/cli/judging.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>

#include <unistd.h>

#include "fixtures/io/network_csv.hpp"
#include "model/dynamics/scene_check.hpp"
#include "reports/cli/case_runner.hpp"
#include "reports/cli/interrupt.hpp"
#include "reports/cli/kept_cases.hpp"
#include "reports/cli/loaded_scene.hpp"
#include "reports/cli/provenance.hpp"
#include "reports/cli/reference_cache.hpp"
#include "reports/cli/source_folder.hpp"
#include "reports/damaged_files.hpp"
#include "reports/results_folder.hpp"

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
  folders.emplace_back(source_folder() / "../shared/data");
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
  context.order = options.order;
  context.cache = &cache;
  context.outside_network = [folders = data_folders(options.data)](std::string_view name) {
    return outside_network(folders, name);
  };
  context.damaged_files = try_damaged_files;
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

std::string command_text(const ValidateOptions& options, const std::string& command) {
  std::string text = "palpate " + command;
  for (const std::string& each : options.cases) { text += " " + each; }
  if (options.quick) { text += " --quick"; }
  if (options.no_skip) { text += " --no-skip"; }
  if (options.order != 0) { text += " --order " + std::to_string(options.order); }
  return text;
}

/// Everything that cases depend on beside code, libraries and processor.
KeptCases kept_cases(const ValidateOptions& options, const std::filesystem::path& cache) {
  return {cache, std::string(options.quick ? "quick " : "whole ") + std::to_string(options.order) + "\n" +
                     what_lies_in(data_folders(options.data))};
}

double seconds_of(const std::map<std::string, Outcome>& outcomes) {
  double seconds = 0.0;
  for (const auto& [name, outcome] : outcomes) { seconds += outcome.seconds; }
  return seconds;
}

std::string told_of(const std::map<std::string, Outcome>& kept) {
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), "%zu cases, %.1f s", kept.size(), seconds_of(kept));
  return text.data();
}

/// In the order asked for; what was interrupted is not there.
std::vector<Outcome> in_order(const std::vector<Case>& cases, std::map<std::string, Outcome> kept,
                              const std::vector<Outcome>& ran) {
  for (const Outcome& outcome : ran) { kept.emplace(outcome.name, outcome); }
  std::vector<Outcome> outcomes;
  for (const Case& one : cases) {
    if (const auto found = kept.find(one.name); found != kept.end()) { outcomes.push_back(found->second); }
  }
  return outcomes;
}

void tell_end(const std::vector<Outcome>& outcomes, std::size_t total, const std::filesystem::path& page) {
  const std::size_t fallen = count(outcomes, Status::fail) + count(outcomes, Status::error);
  std::printf("%zu passed, %zu failed, %zu skipped of %zu cases; %s\n", count(outcomes, Status::pass), fallen,
              count(outcomes, Status::skip), total, page.string().c_str());
}

void look_at_all(const ValidateOptions& options, const Judging& what, Results& results) {
  if (!what.afterwards) { return; }
  results.outcomes.push_back(what.afterwards(results));
  if (!options.quiet) { tell_case(results.outcomes.back(), results.outcomes.size(), results.outcomes.size()); }
}

/// A selection of which nothing could run here is no verdict on the program.
int exit_code(const std::vector<Outcome>& outcomes) {
  if (tally(outcomes).holds()) { return done; }
  const bool none_ran = std::ranges::all_of(
      outcomes, [](const Outcome& one) { return one.status == Status::skip && one.reason.starts_with("not run: "); });
  if (outcomes.empty() || !none_ran) { return fell_short; }
  std::fprintf(stderr, "palpate: %s\n", outcomes.front().reason.c_str());
  return machine_cannot;
}

}  // namespace

int judge(const ValidateOptions& options, const Judging& what) {
  if (options.list) { return list(what.cases); }
  const std::vector<Case> cases = select_cases(what.cases, options.cases, options.quick);
  const std::filesystem::path folder = make_folder(options.folder(what.command));
  const std::filesystem::path cache_folder = options.cache.empty() ? default_cache_folder() : options.cache;
  // Threads of an interrupted run still use it when this function is gone.
  static const reference::Cache cache = cache_in(cache_folder);
  const KeptCases keeper = kept_cases(options, cache_folder);
  std::vector<Case> to_run = cases;
  std::map<std::string, Outcome> kept;
  if (what.keeps && !options.no_skip) { kept = keeper.take(to_run); }
  if (!options.quiet && !kept.empty()) {
    std::printf("%s not run again: code, solvers and data are as before (--no-skip runs them)\n", told_of(kept).c_str());
  }
  const RunnerResult ran =
      run_cases(to_run, context_of(options, cache), what.jobs, interrupted,
                [&](const Outcome& outcome, std::size_t finished, std::size_t total) {
                  if (!options.quiet) { tell_case(outcome, finished, total); }
                  if (what.keeps) { keeper.keep(outcome); }
                });
  Results results{.title = what.title,
                  .command = command_text(options, what.command) + what.further,
                  .provenance = build_provenance(),
                  .outcomes = in_order(cases, kept, ran.outcomes)};
  if (!kept.empty()) { results.provenance["not run again"] = told_of(kept); }
  if (!ran.interrupted) { look_at_all(options, what, results); }
  write_results_folder(folder, results);
  if (!options.quiet) { tell_end(results.outcomes, cases.size(), folder / "report.html"); }
  if (ran.interrupted) {
    std::fflush(nullptr);
    std::_Exit(interrupted_code);  // cases still run on threads that cannot be stopped
  }
  return exit_code(results.outcomes);
}

}  // namespace palpate::cli
