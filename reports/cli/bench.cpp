// SPDX-License-Identifier: MIT

#include <memory>

#include "fixtures/io/file_bytes.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/folders.hpp"
#include "reports/cli/validate.hpp"
#include "reports/timing/callgrind.hpp"
#include "reports/timing/child_process.hpp"
#include "reports/timing/history.hpp"
#include "reports/timing/paired_runs.hpp"
#include "validation/bench/bench_cases.hpp"

namespace palpate::cli {
namespace {

struct BenchOptions : ValidateOptions {
  std::string against{};            ///< revision or step library, timed in pairs with this build
  int self_test = 0;                ///< number of comparisons of this build with itself
  std::filesystem::path history{};  ///< file with one line per run; empty: no history
};

/// Workloads with a lattice, a list of springs and a needle, which together cover most of the code.
const std::vector<std::string> paired_scenes{"s26", "seven-layers", "epidural"};

timing::PairedRuns runs_with(const std::filesystem::path& base) {
  return {.base = base,
          .head = timing::own_library(),
          .scenes = source_folder() / "fixtures" / "scenes",
          .stop = &interrupted};
}

int bench_against(const BenchOptions& options, Judging judging) {
  const std::filesystem::path cache =
      options.cache.empty() ? default_cache_folder() : options.cache;
  const timing::PairedRuns runs =
      runs_with(timing::library_of(options.against, source_folder(), cache, &interrupted));
  judging.further = " --against " + options.against;
  judging.cases = bench::paired_cases(paired_scenes, timing::measurement_of(runs));
  return judge(options, judging);
}

int bench_itself(const BenchOptions& options, Judging judging) {
  const io::ScratchFolder folder;
  const std::filesystem::path copy =
      folder.path() / "base.so";  // the same file loaded twice gives one library only
  std::filesystem::copy_file(timing::own_library(), copy);
  judging.further = " --self-test " + std::to_string(options.self_test);
  judging.cases = bench::self_test_cases(paired_scenes, options.self_test,
                                         timing::measurement_of(runs_with(copy)));
  return judge(options, judging);
}

/// Reads the history first, so that a damaged file is rejected before any case runs.
std::function<Outcome(const Results&)> keep_history(const std::filesystem::path& file) {
  return [file, history = timing::read_history(file)](const Results& results) mutable {
    history.push_back(timing::history_line_of(results));
    timing::append_history(file, history.back());
    return timing::history_outcome(history);
  };
}

/// Runs cases one at a time, so that they do not disturb each other's timing.
int run_bench(const BenchOptions& options) {
  catch_interrupts();
  Judging judging{.command = "bench", .title = "Palpate benchmark", .jobs = 1};
  if (!options.history.empty()) { judging.afterwards = keep_history(options.history); }
  if (!options.against.empty()) { return bench_against(options, judging); }
  if (options.self_test > 0) { return bench_itself(options, judging); }
  judging.cases = bench::all_benches(timing::callgrind_counter(&interrupted));
  return judge(options, judging);
}

}  // namespace

void add_bench(CLI::App& app, std::function<int()>& chosen) {
  const auto [command, options] = add_command(
      app, chosen, "bench", "run time against error, and the cost of a spring", run_bench);
  command.add_option("cases", options.cases, "benches or groups; all when none")->type_name("CASE");
  add_common(command, options, "bench");
  command.add_flag("--list", options.list, "list all benches and exit");
  command.add_flag("--quick", options.quick, "the short form");
  command
      .add_option("--history", options.history,
                  "append the results as a line of JSON, and test the recorded runs for slow drift")
      ->type_name("FILE");
  command
      .add_option("--cache", options.cache,
                  "folder of kept references and of libraries of revisions [user's cache]")
      ->type_name("DIR");
  CLI::Option* against = command
                             .add_option("--against", options.against,
                                         "time this build in pairs with that of a revision "
                                         "(scripts/build-base makes it), or with a library")
                             ->type_name("REV|FILE");
  command
      .add_option(
          "--self-test", options.self_test,
          "number of comparisons of this build with itself, and with itself slowed down by 5 %")
      ->type_name("N")
      ->check(CLI::Range(1, 10000))
      ->excludes(against);
}

}  // namespace palpate::cli
