// SPDX-License-Identifier: MIT
/// The commands `validate` and `bench`, which run cases on several threads, and `report`.

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <link.h>
#include <map>
#include <mutex>
#include <numeric>
#include <optional>
#include <set>
#include <thread>
#include <unistd.h>

#include "fixtures/io/csv_tables.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/scene_file.hpp"
#include "fixtures/io/scene_folder.hpp"
#include "fixtures/io/toml_file.hpp"
#include "fixtures/io/trace_file.hpp"
#include "model/problem/input_error.hpp"
#include "model/tissue/network_builder.hpp"
#include "reference/solution.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/loaded_scene.hpp"
#include "reports/index_page.hpp"
#include "reports/results/results.hpp"
#include "reports/results/results_folder.hpp"
#include "reports/results/results_json.hpp"
#include "reports/timing/child_process.hpp"
#include "reports/timing/history.hpp"
#include "reports/timing/paired_runs.hpp"
#include "validation/bench/bench_cases.hpp"
#include "validation/case.hpp"

namespace palpate::cli {

/// Known failure of a simulator (docs/subjects.md, "Known failures").
struct ExpectedFailure {
  std::string of{};        ///< name of the case
  std::string quantity{};  ///< that fails; "error": the case ends with an error
  std::string reason{};
};

}  // namespace palpate::cli

namespace palpate::io {

template <class Visitor> void fields(Visitor& v, cli::ExpectedFailure& f) {
  v.value("case", f.of, required({}));
  v.value("quantity", f.quantity, required({}));
  v.value("reason", f.reason, required({}));
}

struct ExpectedList {
  std::vector<cli::ExpectedFailure> failures{};
};
template <class Visitor> void fields(Visitor& v, ExpectedList& list) {
  v.list("failure", list.failures);
}

}  // namespace palpate::io

namespace palpate::cli {
namespace {

/// Options shared by validate and bench.
struct ValidateOptions : CommonOptions {
  std::vector<std::string> cases{};
  bool list = false;
  bool quick = false;
  bool no_skip = false;
  bool slack = false;             ///< list quantities with loose bounds
  int jobs = 0;                   ///< parallel jobs; 0: one per core
  std::uint64_t order = 0;        ///< seed of an alternative summation order; 0: default order
  std::uint64_t seed = 0;         ///< of scenes that are drawn at run time; 0: another at every run
  std::filesystem::path cache{};  ///< folder for references, judged cases and libraries; if empty,
                                  ///< the user's cache folder
  std::filesystem::path data{};   ///< networks outside the project; if empty, the default folders
  SubjectChoice subject{};
  std::filesystem::path expected{};        ///< list of known failures; empty: none
  std::string shard_text{};                ///< value of --shard
  std::optional<campaign::Shard> shard{};  ///< part of the selected cases to run; empty: all
};

/// Settings that differ between the two commands.
struct Judging {
  std::string title{};
  std::vector<Case> cases{};
  int jobs = 1;
  /// Judges the complete results after all cases; may be empty.
  std::function<Outcome(const Results&)> afterwards{};
  bool keeps = false;  ///< if true, passed cases are not run again while their inputs are unchanged
  bool advises = false;  ///< if true, advice is added to failed cases of subjects
};

/// Source folder that this program was built from. It contains the shipped scenes.
std::filesystem::path source_folder() { return PALPATE_SOURCE_DIR; }

struct RunnerResult {
  std::vector<Outcome> outcomes{};  ///< of the finished cases, in the order of `cases`
  bool interrupted = false;         ///< if true, some cases still run on their threads
};

/// Data shared by all threads. Shared ownership keeps it alive after an interrupt.
struct Work {
  std::vector<Case> cases;
  CaseContext context;
  std::vector<std::size_t> order;  ///< longest first
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<std::optional<Outcome>> outcomes;
  std::vector<std::size_t> fresh;  ///< finished and not yet reported
};

void work_on(const std::shared_ptr<Work>& work, const std::atomic<bool>& stop) {
  while (!stop.load()) {
    const std::size_t turn = work->next.fetch_add(1);
    if (turn >= work->order.size()) { return; }
    const std::size_t index = work->order[turn];
    Outcome outcome = run_case(work->cases[index], work->context);
    if (stop.load()) { return; }  // the case may have stopped before its end
    const std::scoped_lock lock(work->mutex);
    work->outcomes[index] = std::move(outcome);
    work->fresh.push_back(index);
    work->changed.notify_one();
  }
}

/// Runs the cases on `jobs` threads and calls finished(outcome, done, total) on the calling thread
/// when a case ends. After an interrupt it returns within a fraction of a second without waiting
/// for the running cases; the caller must then end the process without destroying their data.
RunnerResult run_cases(
    std::vector<Case> cases, const CaseContext& context, int jobs, const std::atomic<bool>& stop,
    const std::function<void(const Outcome&, std::size_t, std::size_t)>& finished) {
  const auto work = std::make_shared<Work>();
  work->cases = std::move(cases);
  work->context = context;
  const std::size_t total = work->cases.size();
  work->outcomes.resize(total);
  work->order.resize(total);
  std::iota(work->order.begin(), work->order.end(), std::size_t{0});
  std::ranges::stable_sort(work->order, std::greater<>(),
                           [&](std::size_t n) { return work->cases[n].weight; });
  std::vector<std::thread> threads;
  for (int n = 0; n < jobs; ++n) {
    threads.emplace_back([work, &stop] { work_on(work, stop); });
  }

  std::size_t told = 0;
  while (told < total && !stop.load()) {
    std::vector<std::size_t> fresh;
    {
      std::unique_lock lock(work->mutex);
      work->changed.wait_for(lock, std::chrono::milliseconds(100),
                             [&] { return !work->fresh.empty(); });
      fresh.swap(work->fresh);
    }
    for (const std::size_t index : fresh) { finished(*work->outcomes[index], ++told, total); }
  }
  RunnerResult result;
  result.interrupted = told < total;
  for (std::thread& thread : threads) { result.interrupted ? thread.detach() : thread.join(); }
  const std::scoped_lock lock(work->mutex);
  for (const auto& outcome : work->outcomes) {
    if (outcome) { result.outcomes.push_back(*outcome); }
  }
  return result;
}

namespace fs = std::filesystem;

int add_library(dl_phdr_info* info, std::size_t, void* list) {
  if (info->dlpi_name != nullptr && *info->dlpi_name == '/') {
    static_cast<std::set<std::string>*>(list)->insert(io::sha256_of_file(info->dlpi_name));
  }
  return 0;
}

/// Hash of the object code, the processor and the content of the loaded shared libraries.
std::string what_runs() {
  std::string text =
      std::string(build::code_hash()) + "\n" + build_provenance().at("processor") + "\n";
  // These select functions of the C library and kernels.
  for (const char* choice : {"GLIBC_TUNABLES", "PALPATE_INSTRUCTIONS"}) {
    const char* value = std::getenv(choice);
    text += std::string(value != nullptr ? value : "") + "\n";
  }
  std::set<std::string> libraries;
  dl_iterate_phdr(add_library, &libraries);
  for (const std::string& library : libraries) { text += library + "\n"; }
  return io::sha256(text);
}

/// Names and content of the files that outside_network() may read, in the order of the folders.
std::string networks_in(const std::vector<fs::path>& folders) {
  std::string text;
  for (const fs::path& folder : folders) {
    std::set<std::string> files;
    std::error_code problem;
    for (fs::recursive_directory_iterator at(folder, problem), end; !problem && at != end;
         at.increment(problem)) {
      const fs::path name = at->path().filename();
      if (name != "nodes.csv" && name != "springs.csv") { continue; }
      files.insert(at->path().lexically_relative(folder).string() + "\n" +
                   io::sha256_of_file(at->path()) + "\n");
    }
    for (const std::string& file : files) { text += file; }
    text += "\n";
  }
  return text;
}

/// Cache of the outcomes of passed cases, keyed by everything that an outcome depends on.
class KeptCases {
 public:
  /// Creates the cache. `inputs` contains everything that an outcome depends on. Throws InputError
  /// if another user may write to its folders.
  KeptCases(const fs::path& cache, const std::string& inputs)
      : folder_(cache / "cases" / io::sha256(inputs)) {
    for (const fs::path& folder : {folder_.parent_path(), folder_}) { io::make_own_folder(folder); }
  }

  /// Removes the cases with a kept outcome from the list and returns these outcomes by name.
  [[nodiscard]] std::map<std::string, Outcome> take(std::vector<Case>& cases) const {
    std::map<std::string, Outcome> taken;
    std::erase_if(cases, [&](const Case& one) {
      std::optional<Outcome> outcome = find(one);
      if (outcome) { taken.emplace(one.name, std::move(*outcome)); }
      return outcome.has_value();
    });
    return taken;
  }

  /// Keeps the outcome if the case passed. A full or read-only disk is not an error.
  void keep(const Outcome& outcome) const {
    if (outcome.status != Status::pass) { return; }
    try {
      write_figure_data(folder_, outcome);
      const std::string text = to_json(Results{.title = "kept", .outcomes = {outcome}});
      io::replace_file(file_of(outcome.name), seal_of(text, outcome) + "\n" + text);
    } catch (const std::exception&) {}  // the case will run again
  }

 private:
  [[nodiscard]] fs::path file_of(const std::string& name) const {
    return folder_ / (fs::path(trace_file_name(name)).replace_extension(".json"));
  }
  /// Hash of an outcome's text and of its file of figures, under this cache's inputs.
  [[nodiscard]] std::string seal_of(const std::string& text, const Outcome& outcome) const {
    return io::sha256(folder_.filename().string() + "\n" + text +
                      (outcome.figures.empty()
                           ? ""
                           : io::sha256_of_file(folder_ / trace_file_name(outcome.name))));
  }
  /// Returns the kept outcome. Empty if the case has not passed under the same conditions, or if
  /// the file is damaged or was edited, which is reported.
  [[nodiscard]] std::optional<Outcome> find(const Case& definition) const {
    constexpr std::size_t most_bytes = 1U << 28U;
    const fs::path file = file_of(definition.name);
    if (!definition.keeps || !fs::exists(fs::symlink_status(file))) { return std::nullopt; }
    try {
      const std::string sealed = io::read_text(file, most_bytes);
      const std::size_t line = std::min(sealed.find('\n'), sealed.size() - 1);
      const std::string text = sealed.substr(line + 1);
      Results kept = results_from_json(text, file.string());
      Outcome& outcome = kept.outcomes.at(0);
      if (outcome.name == definition.name && outcome.status == Status::pass &&
          sealed.substr(0, line) == seal_of(text, outcome)) {
        read_figure_data(folder_, outcome);
        return std::move(outcome);
      }
    } catch (const std::exception&) {}
    std::fprintf(stderr, "palpate: %s: is damaged or was edited; the case is run again\n",
                 io::printable(file.string()).c_str());
    return std::nullopt;
  }

  fs::path folder_;
};

int list(const std::vector<Case>& cases) {
  for (const Case& one : cases) {
    std::printf("%-40s %-10s %s\n", one.name.c_str(), one.suite.c_str(), one.claim.c_str());
  }
  return done;
}

/// Folders to search for data sets that are not part of the project.
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

CaseContext context_of(const ValidateOptions& options, const reference::Cache& cache,
                       const std::filesystem::path& cached) {
  CaseContext context;
  context.quick = options.quick;
  context.skip = !options.no_skip;
  context.order = options.order;
  context.seed = options.seed;
  context.cache = &cache;
  context.outside_network = [folders = data_folders(options.data)](std::string_view name) {
    return outside_network(folders, name);
  };
  context.damaged_files = try_damaged_files;
  context.library = [] {
    std::vector<Material> materials;
    for (const io::LibraryMaterial& each : io::material_library()) {
      materials.push_back(each.material);
    }
    return materials;
  };
  context.shipped_scene = [](std::string_view name) -> std::optional<Scene> {
    const fs::path file = source_folder() / "fixtures" / "scenes" / (std::string(name) + ".toml");
    return fs::exists(file) ? std::optional(io::read_scene(file).scene) : std::nullopt;
  };
  context.through_files = [](const Scene& scene, const SpringNetwork& network) {
    const io::ScratchFolder folder;
    io::write_scene_folder(folder.path(), {.scene = scene, .network = network, .needs = {}});
    return build_network(io::read_scene(folder.path() / "scene.toml").scene);
  };
  context.network_of_files = [](const std::map<std::string, std::string>& files) {
    const io::ScratchFolder folder;
    for (const auto& [name, bytes] : files) { io::replace_file(folder.path() / name, bytes); }
    return build_network(io::read_scene(folder.path() / "scene.toml").scene);
  };
  if (options.subject.foreign()) {
    context.subject = [choice = confined(options.subject, options, {cached})] {
      return make_subject(choice);
    };
  }
  return context;
}

/// Prints a finished case. A long reason that the case before has is not repeated.
void tell_case(const ValidateOptions& options, const Outcome& outcome, std::size_t finished,
               std::size_t total) {
  static std::string last;
  const std::string reason = outcome.reason();
  const bool same = reason.size() > 80 && reason == last;
  last = reason;
  std::string status(name_of(outcome.status));
  status.resize(5, ' ');
  std::printf("%3zu/%zu %s %7.2f s  %s%s%s\n", finished, total,
              in_colour(status, outcome.status).c_str(), outcome.seconds, outcome.name.c_str(),
              reason.empty() ? "" : ": ",
              same ? "the same as before" : io::printable(reason).c_str());
  for (const Quantity& q : outcome.quantities) {
    if (!options.verbose && (!q.judged() || q.holds())) { continue; }
    std::printf("            %s = %.6g%s", q.name.c_str(), q.value,
                q.unit == "1" ? "" : (" " + q.unit).c_str());
    if (q.judged()) {
      std::printf("; allowed %.6g to %.6g (%s)", q.lower, q.upper, q.bound_from.c_str());
    }
    std::printf("\n");
  }
  if (outcome.status == Status::fail) {
    for (const std::string& note : outcome.notes) {
      std::printf("            %s\n", io::printable(note).c_str());
    }
  }
  std::fflush(stdout);
}

/// Everything that outcomes depend on; `code` is what_runs().
std::string inputs_of_cases(const ValidateOptions& options, const std::string& code) {
  return code + (options.quick ? " quick " : " whole ") + std::to_string(options.order) + "\n" +
         networks_in(data_folders(options.data));
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

/// Outcomes in the order of `cases`, without the interrupted ones.
std::vector<Outcome> in_order(const std::vector<Case>& cases, std::map<std::string, Outcome> kept,
                              const std::vector<Outcome>& ran) {
  for (const Outcome& outcome : ran) { kept.emplace(outcome.name, outcome); }
  std::vector<Outcome> outcomes;
  for (const Case& one : cases) {
    if (const auto found = kept.find(one.name); found != kept.end()) {
      outcomes.push_back(found->second);
    }
  }
  return outcomes;
}

void tell_end(const std::vector<Outcome>& outcomes, std::size_t total,
              const std::filesystem::path& page) {
  const Tally sum = tally(outcomes);
  const std::string text =
      std::to_string(sum.passed) + " passed, " + std::to_string(sum.not_passed()) + " failed, " +
      std::to_string(sum.skipped) + " skipped of " + std::to_string(total) + " cases";
  std::printf("%s; %s\n", in_colour(text, sum.holds() ? Status::pass : Status::fail).c_str(),
              io::printable(page.string()).c_str());
}

/// Returns true if a quantity could change by far and stay within its bound: an error that is less
/// than 1 % of what is allowed, or an interval that is wider than the value. Bounds of rounding are
/// tight however little of them is used, because every other fault is larger by decades; values
/// that are whole numbers are counts or exact.
bool is_loose(const Quantity& q) {
  constexpr double little = 0.01;
  constexpr double rounding = 1e-8;
  if (!q.judged() || q.value == std::trunc(q.value)) { return false; }
  const bool interval = std::isfinite(q.lower) && std::isfinite(q.upper) && q.lower * q.upper > 0.0;
  if (interval) { return q.upper - q.lower > std::abs(q.value); }
  return share_of_bound(q) < little && q.unit != "eps" && !(q.upper <= rounding);
}

/// Prints the quantities with loose bounds.
void tell_slack(const std::vector<Outcome>& outcomes) {
  for (const Outcome& outcome : outcomes) {
    for (const Quantity& q : outcome.quantities) {
      if (!is_loose(q)) { continue; }
      std::printf("loose  %s: %s = %s; allowed %s (%s)\n", outcome.name.c_str(), q.name.c_str(),
                  measured_text(q).c_str(), allowed_text(q).c_str(), q.bound_from.c_str());
    }
  }
}

/// Share of the cases that were judged: "12 of 15 cases judged".
std::string coverage(const std::vector<Outcome>& outcomes) {
  const Tally sum = tally(outcomes);
  return std::to_string(sum.ran()) + " of " + std::to_string(sum.all()) + " cases judged";
}

void look_at_all(const ValidateOptions& options, const Judging& what, Results& results) {
  if (!what.afterwards) { return; }
  results.outcomes.push_back(what.afterwards(results));
  if (!options.quiet) {
    tell_case(options, results.outcomes.back(), results.outcomes.size(), results.outcomes.size());
  }
}

/// Folder of kept references, judged cases and libraries. Throws InputError if another user may
/// write to it.
std::filesystem::path cache_folder(const ValidateOptions& options) {
  std::filesystem::path folder = options.cache.empty() ? default_cache_folder() : options.cache;
  io::make_own_folder(folder);
  return folder;
}

reference::Cache cache_in(const std::filesystem::path& folder, const ValidateOptions& options,
                          const std::string& code) {
  reference::Cache cache{.code = code};
  cache.save = [folder](const std::string& key, const Trace& solution) {
    io::save_reference(folder, key, solution);
  };
  if (options.no_skip) { return cache; }
  cache.load = [folder](const std::string& key) -> std::optional<Trace> {
    try {
      return io::load_reference(folder, key);
    } catch (const InputError& damage) {
      std::fprintf(stderr, "palpate: %s; computed again\n", io::printable(damage.what()).c_str());
      return std::nullopt;
    }
  };
  return cache;
}

/// Throws InputError with the nearest name of a case or a group if a pattern matches nothing.
void refuse_unknown_cases(const std::vector<Case>& cases, std::span<const std::string> patterns) {
  for (const std::string& pattern : patterns) {
    if (std::ranges::any_of(cases, [&](const Case& one) { return is_named(one, pattern); })) {
      continue;
    }
    std::vector<std::string_view> names;
    for (const Case& one : cases) {
      const std::string_view name = one.name;
      names.push_back(name);
      for (auto end = name.find('/'); end != name.npos; end = name.find('/', end + 1)) {
        names.push_back(name.substr(0, end));
      }
    }
    const std::string nearest(io::nearest_word(pattern, names));
    throw InputError("no case is named \"" + pattern + "\"" +
                     (nearest.empty() ? "" : "; did you mean " + nearest + "?") +
                     (nearest.empty() ? "; " : " ") + "validate --list shows them all");
  }
}

/// Reads [[failure]] with case, quantity and reason. Throws InputError, also for a case that is
/// not in the list.
std::vector<ExpectedFailure> read_expected(const std::filesystem::path& file,
                                           const std::vector<Case>& cases) {
  io::Problems problems;
  const io::TomlDocument document = io::read_toml(file, "a list of known failures", {}, problems);
  io::ExpectedList list;
  io::TomlReader reader(document.root, "", document.places, problems,
                        [](std::string_view) { return std::string(); });
  fields(reader, list);
  reader.refuse_unknown_keys();
  std::set<std::pair<std::string, std::string>> known;
  for (std::size_t n = 0; n < list.failures.size(); ++n) {
    const ExpectedFailure& failure = list.failures[n];
    const std::string entry = "failure[" + std::to_string(n) + "]";
    if (failure.reason.find_first_not_of(" \t\n") == std::string::npos) {
      problems.add(document.places, entry + ".reason",
                   "reason is empty; why the case fails is needed");
    }
    if (!known.emplace(failure.of, failure.quantity).second) {
      problems.add(document.places, entry + ".quantity",
                   "quantity " + failure.quantity + " is listed twice for the case \"" +
                       failure.of + "\"; once is allowed");
    }
    if (std::ranges::find(cases, failure.of, &Case::name) == cases.end() && !failure.of.empty()) {
      problems.add(document.places, entry + ".case",
                   "no case is named \"" + failure.of + "\"; validate --list shows them");
    }
  }
  problems.throw_if_any();
  return list.failures;
}

/// Changes outcomes by the list of known failures and returns those that changed. A known failure
/// becomes a skip; one that passes, is skipped or fails in another quantity becomes a failure.
std::vector<const Outcome*> apply_expected(const std::vector<ExpectedFailure>& expected,
                                           std::vector<Outcome>& outcomes) {
  std::vector<const Outcome*> changed;
  std::set<std::string> listed;
  for (const ExpectedFailure& one : expected) { listed.insert(one.of); }
  for (Outcome& outcome : outcomes) {
    if (!listed.contains(outcome.name)) { continue; }
    std::set<std::string> wanted;
    std::string reason;
    for (const ExpectedFailure& one : expected) {
      if (one.of != outcome.name) { continue; }
      wanted.insert(one.quantity);
      reason += (reason.empty() ? "" : "; ") + one.reason;
    }
    std::set<std::string> found;
    if (outcome.status == Status::error) { found.insert("error"); }
    for (const Quantity& q : outcome.quantities) {
      if (q.judged() && !q.holds()) { found.insert(q.name); }
    }
    if (outcome.status != Status::skip && found == wanted) {
      outcome.skip("expected failure: " + reason);
    } else {
      std::string names;
      for (const std::string& name : found) { names += (names.empty() ? "" : ", ") + name; }
      outcome.reasons = {"a failure was expected (" + reason + "), but the case " +
                         (outcome.status == Status::skip ? "is skipped: " + outcome.reason()
                          : found.empty()                ? "passes; remove it from the list"
                                                         : "fails in " + names)};
      outcome.status = Status::fail;
    }
    changed.push_back(&outcome);
  }
  return changed;
}

void add_seed(CLI::App& command, ValidateOptions& options) {
  add_value(command, "--seed", options.seed, "SEED",
            "seed of the scenes that are drawn at run time, to repeat them [another in every run]")
      ->check(seed_range());
}

void add_cache(CLI::App& command, ValidateOptions& options) {
  add_value(command, "--cache", options.cache, "DIR",
            "folder of kept references, judged cases and libraries of revisions [user's cache]");
}

void add_cases(CLI::App& command, ValidateOptions& options, const char* help) {
  add_value(command, "cases", options.cases, "CASE", help);
  command.add_flag("--list", options.list, "list all cases and exit");
  command.add_flag("--quick", options.quick, "the short form");
  add_cache(command, options);
  add_seed(command, options);
}

const std::map<std::string, std::string>& advice();

void tell_advice(const Outcome& outcome) {
  constexpr std::string_view group = "subject/";
  if (outcome.status != Status::fail || !outcome.name.starts_with(group)) { return; }
  const auto found = advice().find(outcome.name.substr(group.size()));
  if (found != advice().end()) { std::printf("            advice: %s\n", found->second.c_str()); }
}

/// Removes the cases that are not of the shard, and returns the provenance from which `palpate
/// merge` restores the order of one run. Long cases are dealt out first.
std::map<std::string, std::string> keep_shard(const campaign::Shard& shard,
                                              std::vector<Case>& cases) {
  std::vector<std::size_t> order(cases.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::greater<>(), [&](std::size_t n) { return cases[n].weight; });
  std::set<std::size_t> positions;
  for (std::size_t n = 0; n < order.size(); ++n) {
    if (shard.has(n)) { positions.insert(order[n]); }
  }
  std::map<std::string, std::string> provenance{{shard_key, shard.text()},
                                                {shard_total_key, std::to_string(cases.size())}};
  std::vector<Case> kept;
  for (const std::size_t position : positions) {
    std::string& list = provenance[shard_positions_key];
    list += (list.empty() ? "" : " ") + std::to_string(position);
    kept.push_back(std::move(cases[position]));
  }
  cases = std::move(kept);
  return provenance;
}

int judge(const ValidateOptions& options, const Judging& what) {
  if (options.list) { return list(what.cases); }
  refuse_unknown_cases(what.cases, options.cases);
  std::vector<Case> cases = select_cases(what.cases, options.cases, options.quick);
  std::map<std::string, std::string> of_shard;
  if (options.shard) { of_shard = keep_shard(*options.shard, cases); }
  if (options.subject.subject.starts_with("trace:") && cases.size() != 1) {
    throw InputError("--subject " + options.subject.subject + ": " + std::to_string(cases.size()) +
                     " cases are selected; a trace answers the scene of one, and its name is "
                     "needed, such as subject/s26");
  }
  std::vector<ExpectedFailure> expected;
  if (!options.expected.empty()) { expected = read_expected(options.expected, what.cases); }
  const std::filesystem::path cached = cache_folder(options);
  const std::filesystem::path folder = options.make_folder(files_of_results());
  const std::string code = what_runs();
  // Threads of an interrupted run still use it after this function has returned.
  static const reference::Cache cache = cache_in(cached, options, code);
  std::optional<KeptCases> keeper;
  // --no-skip also computes what scenes do not need, which changes numbers.
  if (what.keeps && !options.no_skip) { keeper.emplace(cached, inputs_of_cases(options, code)); }
  std::vector<Case> to_run = cases;
  std::map<std::string, Outcome> kept;
  if (keeper) { kept = keeper->take(to_run); }
  if (!options.quiet && !kept.empty()) {
    std::printf("%s not run again: code, solvers and data are as before (--no-skip runs them)\n",
                told_of(kept).c_str());
  }
  const CaseContext context = context_of(options, cache, cached);
  // Before the cases, because an interrupted subject does not answer.
  std::map<std::string, std::string> of_subject;
  if (options.subject.foreign()) {
    of_subject = subject_provenance(context.make_subject()->facts());
  }
  const RunnerResult ran =
      run_cases(to_run, context, what.jobs, interrupted,
                [&](const Outcome& outcome, std::size_t finished, std::size_t total) {
                  if (!options.quiet) { tell_case(options, outcome, finished, total); }
                  if (!options.quiet && what.advises) { tell_advice(outcome); }
                  if (keeper) { keeper->keep(outcome); }
                });
  Results results{.title = what.title,
                  .command = options.command,
                  .provenance = build_provenance(),
                  .outcomes = in_order(cases, kept, ran.outcomes)};
  results.provenance.merge(of_shard);
  if (!kept.empty()) { results.provenance["not run again"] = told_of(kept); }
  if (!ran.interrupted) { look_at_all(options, what, results); }
  for (const Outcome* changed : apply_expected(expected, results.outcomes)) {
    if (!options.quiet) {
      tell_case(options, *changed, results.outcomes.size(), results.outcomes.size());
    }
  }
  if (options.subject.foreign()) {
    results.provenance.merge(of_subject);
    results.provenance["coverage"] = coverage(results.outcomes);
    if (!options.quiet) { std::printf("%s\n", results.provenance["coverage"].c_str()); }
  }
  write_results_folder(folder, results);
  if (options.slack) { tell_slack(results.outcomes); }
  tell_end(results.outcomes, cases.size(), folder / "report.html");
  if (ran.interrupted) {
    std::fflush(stdout);
    io::end_process(interrupted_code);  // cases still run on threads that cannot be stopped
  }
  if (tally(results.outcomes).holds()) { return done; }
  // A shard may have no case, or skipped ones only.
  if (options.shard && tally(results.outcomes).not_passed() == 0) { return done; }
  const bool none_ran = std::ranges::all_of(results.outcomes, [](const Outcome& one) {
    return one.status == Status::skip && one.reason().starts_with("not run: ");
  });
  if (results.outcomes.empty() || !none_ran) { return fell_short; }
  std::fprintf(stderr, "palpate: %s\n", io::printable(results.outcomes.front().reason()).c_str());
  return machine_cannot;
}

/// Cases that judge any simulator.
std::vector<Case> subject_cases() {
  std::vector<Case> cases = all_cases();
  std::erase_if(cases, [](const Case& one) { return !one.any_subject; });
  return cases;
}

int run_validate(const ValidateOptions& given) {
  keep_results_of_interrupted();
  ValidateOptions options = given;
  options.shard = chosen_shard(options.shard_text);
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  if (options.subject.foreign()) {
    const SubjectFacts facts = make_subject(options.subject)->facts();
    // One at a time, so that cases do not disturb each other's timing.
    return judge(options, {.title = "Validation of " + facts.name + " " + facts.version,
                           .cases = subject_cases(),
                           .jobs = options.jobs > 0 ? options.jobs : 1});
  }
  return judge(options, {.title = "Palpate validation",
                         .cases = all_cases(),
                         .jobs = options.jobs > 0 ? options.jobs : cores,
                         .keeps = true});
}

/// Advice for a simulator that fails a case, by the name of the case without "subject/".
const std::map<std::string, std::string>& advice() {
  static const std::map<std::string, std::string> texts{
      {"s26",
       "compare the first rows of tip.z_m with the reference: a constant factor is a unit or "
       "a stiffness counted twice, a shift is a step too late, a slow drift the integrator"},
      {"first-step",
       "apply the loads of loads.csv at the beginning of the step, in newtons, and "
       "return the state at the end of the step"},
      {"static",
       "check rest lengths, stiffness and fixed nodes; the force of a spring is along it"},
      {"chain",
       "check the mass of each node and the stiffness of a spring between a fixed and a "
       "free node; hidden damping lowers the amplitude"},
      {"momentum",
       "a spring must push both ends by the same force; global damping and sleeping take "
       "momentum away"},
      {"energy",
       "a step above the limit of the integrator, or constraints that are projected, add "
       "energy"},
      {"invariance",
       "coordinates must not enter but by differences; single precision far from the "
       "origin loses digits"},
      {"rest", "rest lengths must be those of springs.csv, not of the engine's own mesh"},
      {"stability",
       "use substeps, or an implicit integrator; after divergence load must work again"},
      {"audit/renumbered", "the order of nodes.csv must be kept by get_state"},
      {"audit/stiffness",
       "read springs.csv at every load; do not keep a scene by its title or path"},
      {"audit/drawn",
       "loads.csv has rows at later times that replace earlier ones, and gravity is in "
       "settings.csv; "
       "`palpate validate subject/audit/drawn --subject ... --seed SEED` repeats the scene"},
      {"audit/repeat", "reset must restore positions, velocities, time and every inner state"},
      {"audit/substeps",
       "after set_parameter(\"substeps\", n) and a reset, a step must be n integration steps of "
       "dt / n"},
      {"audit/memory", "free the scene in destroy, and nothing may grow with the steps"},
      {"needle", "force is that of the tissue on the tool; the tool's depth is along z"},
      {"probe", "force is that of the tissue on the tool, over the whole face"},
      {"layered", "every row of layers.csv has its own modulus, from top_m to bottom_m"}};
  return texts;
}

/// Compares what a subject declares with what it does, in the short form of all cases, with advice.
int run_subject_check(const ValidateOptions& given) {
  keep_results_of_interrupted();
  ValidateOptions options = given;
  options.quick = true;
  const SubjectFacts facts = make_subject(options.subject)->facts();
  if (!options.quiet) {
    std::printf("%s %s (%s), %s\ncapabilities: %s\nparameters: %s\n",
                io::printable(facts.name).c_str(), io::printable(facts.version).c_str(),
                io::printable(facts.licence).c_str(), io::printable(facts.carrier).c_str(),
                names_of(facts.capabilities).c_str(), io::printable(facts.parameters).c_str());
  }
  return judge(options, {.title = "Check of " + facts.name + " " + facts.version,
                         .cases = subject_cases(),
                         .jobs = options.jobs > 0 ? options.jobs : 1,
                         .advises = true});
}

struct BenchOptions : ValidateOptions {
  std::string against{};            ///< revision or step library, timed in pairs with this build
  int self_test = 0;                ///< number of comparisons of this build with itself
  std::filesystem::path history{};  ///< file with one line per run; empty: no history
  std::vector<std::filesystem::path> ticks{};  ///< scenes with a tool
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
  const timing::PairedRuns runs = runs_with(
      timing::library_of(options.against, source_folder(), cache_folder(options), &interrupted));
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
    timing::append_line(file, timing::to_text(history.back()));
    return timing::history_outcome(history);
  };
}

/// Times the ticks of scenes. Throws InputError for a scene without a tool.
int bench_ticks(const BenchOptions& options, Judging judging) {
  for (const std::filesystem::path& file : options.ticks) {
    const LoadedScene loaded = load_scene(file, options, false);
    const Scene& scene = loaded.file.scene;
    if (!scene.needle && !scene.probe) {
      throw InputError("--ticks " + file.string() + ": has no tool; a needle or probe is needed");
    }
    if (scene.drive && scene.drive->is_coupled()) {
      throw InputError("--ticks " + file.string() +
                       ": drive.kind = \"falcon\" or \"recorded\"; palpate certify times a scene "
                       "in the loop of its device");
    }
    const std::string name =
        file.stem() == "scene" ? file.parent_path().filename().string() : file.stem().string();
    judging.cases.push_back(bench::tick_case(name, scene));
  }
  return judge(options, judging);
}

/// Runs cases one at a time, so that they do not disturb each other's timing.
int run_bench(const BenchOptions& options) {
  keep_results_of_interrupted();
  Judging judging{.title = "Palpate benchmark", .jobs = 1};
  if (!options.overrides.empty() && options.ticks.empty()) {
    throw InputError("bench: --set overrides keys of the scenes of --ticks; there are none");
  }
  if (!options.history.empty()) { judging.afterwards = keep_history(options.history); }
  if (options.subject.foreign() && (!options.against.empty() || options.self_test > 0)) {
    throw InputError("--subject with --against or --self-test: these time builds of the model");
  }
  if (!options.against.empty()) { return bench_against(options, judging); }
  if (options.self_test > 0) { return bench_itself(options, judging); }
  if (!options.ticks.empty()) { return bench_ticks(options, judging); }
  judging.cases = bench::all_benches(timing::callgrind_counter(&interrupted));
  if (options.subject.foreign()) {
    judging.title = "Benchmark of " + make_subject(options.subject)->facts().name;
    std::erase_if(judging.cases, [](const Case& one) { return !one.any_subject; });
    const std::vector<std::string> s26{"subject/s26"};  // cost at equal error
    std::ranges::move(select_cases(all_cases(), s26, false), std::back_inserter(judging.cases));
  }
  return judge(options, judging);
}

void add_results_forms(CLI::App& command, CommonOptions& options) {
  add_verbose(command, options, "print every quantity of every case");
  add_json(command, options, "results.json");
}

struct ReportOptions : CommonOptions {
  std::vector<std::filesystem::path> results{};
};

int run_report(const ReportOptions& options) {
  std::vector<Results> all;
  for (const std::filesystem::path& folder : options.results) {
    all.push_back(read_results_folder(folder));
    if (all.back().outcomes.empty()) {
      throw InputError((folder / "results.json").string() +
                       ": has no case; the results of a validate, bench or subject that ran some");
    }
  }
  const bool compares = all.size() > 1;
  const Results results = compares ? subject_matrix(all) : all.front();
  const std::filesystem::path folder =
      options.out.empty() && !compares
          ? options.results.front()
          : options.make_folder(compares ? files_of_results()
                                         : std::vector<std::string>{"report.html"});
  if (compares) {
    write_results_folder(folder, results);
  } else {
    io::replace_file(folder / "report.html", to_html(results));
  }
  std::printf("%s\n", io::printable((folder / "report.html").string()).c_str());
  return done;
}

}  // namespace

void add_validate(Program& program) {
  const auto [command, options] = add_command(
      program, "validate", "judge the model: accuracy, stability, physics", run_validate);
  add_cases(command, options, "cases, groups or suites; all when none");
  command.add_flag("--no-skip", options.no_skip,
                   "run also cases whose code has not changed, compute also what scenes do not "
                   "need; same verdicts");
  command.add_flag("--slack", options.slack,
                   "list the quantities that could change by far within their bounds");
  command.add_option("--jobs", options.jobs, "cases at a time [one per core]")
      ->check(CLI::Range(1, 1024));
  add_value(command, "--order", options.order, "SEED",
            "put nodes and springs in a random order with this seed, to show the effect of "
            "rounding (docs/gate.md)")
      ->check(seed_range());
  add_value(command, "--data", options.data, "DIR", "folder of data outside the project");
  add_shard(command, options.shard_text, "cases");
  add_subject_options(command, options.subject);
  add_results_forms(command, options);
  add_value(command, "--expected", options.expected, "FILE",
            "known failures (TOML, docs/subjects.md); one that passes, is skipped or fails in "
            "another quantity fails the run");
}

void add_subject_check(Program& program, CLI::App& subject) {
  const auto [command, options] =
      add_command(program, "check", "compare what a simulator declares with what it does",
                  run_subject_check, &subject);
  add_value(command, "subject", options.subject.subject, "SUBJECT", "PATH.so or exec:COMMAND")
      ->required();
  add_cache(command, options);
  add_seed(command, options);
  add_subject_options(command, options.subject);
  add_results_forms(command, options);
}

void add_bench(Program& program) {
  const auto [command, options] =
      add_command(program, "bench", "run time against error, and the cost of a spring", run_bench);
  add_cases(command, options, "benches or groups; all when none");
  add_value(command, "--history", options.history, "FILE",
            "append the results as a line of JSON, and test the recorded runs for slow drift");
  add_subject_options(command, options.subject);
  add_results_forms(command, options);
  CLI::Option* ticks = add_value(command, "--ticks", options.ticks, "SCENE",
                                 "time every tick of this scene, and judge what its tolerance and "
                                 "reduced-order model change; repeatable");
  add_overrides(command, options);
  CLI::Option* against =
      add_value(command, "--against", options.against, "REV|FILE",
                "time this build in pairs with that of a revision (scripts/build-base makes it), "
                "or with a library");
  add_value(command, "--self-test", options.self_test, "N",
            "number of comparisons of this build with itself, and with itself slowed down by 5 %")
      ->check(CLI::Range(1, 10000))
      ->excludes(against)
      ->excludes(ticks);
  ticks->excludes(against);
}

void add_report(Program& program) {
  const auto [command, options] = add_command(
      program, "report",
      "render report.html again from a results folder, or compare several simulators", run_report);
  add_value(command, "results", options.results, "RESULTS",
            "folder with results.json and traces/; several folders: results of simulators on the "
            "same cases, compared on one page")
      ->required();
}

namespace {

struct IndexOptions : CommonOptions {
  std::filesystem::path parent = "palpate-out";
};

int run_index(const IndexOptions& options) {
  if (!std::filesystem::is_directory(options.parent)) {
    throw InputError(options.parent.string() +
                     ": is no folder; a folder whose folders have results is needed");
  }
  const auto is_index = [](std::string_view start) {
    return start.find("<title>" + std::string(index_title)) != start.npos;
  };
  refuse_to_replace(options.parent / "index.html", is_index, "a page of palpate index");
  const std::size_t count = index_folders_in(options.parent);
  std::printf("%zu results; %s\n", count, (options.parent / "index.html").c_str());
  return done;
}

}  // namespace

void add_index(Program& program) {
  const auto [command, options] =
      add_command(program, "index", "list the results of all folders on one page", run_index);
  command.remove_option(command.get_option("--out"));  // DIR is the folder
  add_value(command, "parent", options.parent, "DIR",
            "folder whose folders have results [palpate-out]");
  command.footer(
      "Writes DIR/index.html, with what changed since the run before, and DIR/index.jsonl,\n"
      "its ledger. Commands without --out add their result to palpate-out by themselves.");
}

}  // namespace palpate::cli
