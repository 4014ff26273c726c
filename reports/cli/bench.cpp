// SPDX-License-Identifier: MIT

#include "fixtures/io/file_bytes.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/validate.hpp"
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
  judging.cases = bench::paired_cases(paired_scenes, timing::measurement_of(runs));
  return judge(options, judging);
}

int bench_itself(const BenchOptions& options, Judging judging) {
  const io::ScratchFolder folder;
  const std::filesystem::path copy =
      folder.path() / "base.so";  // the same file loaded twice gives one library only
  std::filesystem::copy_file(timing::own_library(), copy);
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
  Judging judging{.title = "Palpate benchmark", .jobs = 1};
  if (!options.history.empty()) { judging.afterwards = keep_history(options.history); }
  if (!options.against.empty()) { return bench_against(options, judging); }
  if (options.self_test > 0) { return bench_itself(options, judging); }
  judging.cases = bench::all_benches(timing::callgrind_counter(&interrupted));
  return judge(options, judging);
}

}  // namespace

void add_bench(Program& program) {
  const auto [command, options] =
      add_command(program, "bench", "run time against error, and the cost of a spring", run_bench);
  add_cases(command, options, "benches or groups; all when none");
  add_value(command, "--history", options.history, "FILE",
            "append the results as a line of JSON, and test the recorded runs for slow drift");
  CLI::Option* against =
      add_value(command, "--against", options.against, "REV|FILE",
                "time this build in pairs with that of a revision (scripts/build-base makes it), "
                "or with a library");
  add_value(command, "--self-test", options.self_test, "N",
            "number of comparisons of this build with itself, and with itself slowed down by 5 %")
      ->check(CLI::Range(1, 10000))
      ->excludes(against);
}

}  // namespace palpate::cli
