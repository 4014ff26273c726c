// SPDX-License-Identifier: MIT

#include "reports/timing/paired_runs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <dlfcn.h>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "model/problem/input_error.hpp"
#include "reports/timing/callgrind.hpp"
#include "reports/timing/child_process.hpp"
#include "validation/bench/timing.hpp"
#include "validation/number_text.hpp"
#include "validation/random.hpp"

namespace palpate::timing {

namespace {

constexpr int known_version = 1;

}  // namespace

template <class Function> void LoadedLibrary::find(Function*& function, const char* name) {
  function = reinterpret_cast<Function*>(dlsym(handle_, name));
  if (function == nullptr) {
    throw InputError(name_ + ": has no " + name +
                     "; a step library, as scripts/build-base makes it");
  }
}

LoadedLibrary::LoadedLibrary(const std::filesystem::path& file) : name_(file.string()) {
  const std::filesystem::path whole = std::filesystem::absolute(file);  // avoids the search path
  handle_ = dlopen(whole.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle_ == nullptr) {
    throw InputError(name_ + ": cannot be loaded: " + dlerror() + "; a step library");
  }
  decltype(palpate_steps_version)* version = nullptr;
  find(version, "palpate_steps_version");
  if (version() != known_version) {
    throw InputError(name_ + ": version " + std::to_string(version()) + " of its functions; " +
                     std::to_string(known_version));
  }
  find(create_, "palpate_steps_create");
  find(run_, "palpate_steps_run");
  find(digest_, "palpate_steps_digest");
  find(kernel_, "palpate_steps_kernel");
  find(tick_count_, "palpate_steps_tick_count");
  find(tick_length_, "palpate_steps_tick_length");
  find(destroy_, "palpate_steps_destroy");
}

LoadedLibrary::~LoadedLibrary() {
  if (handle_ != nullptr) { dlclose(handle_); }
}

LibrarySteps LoadedLibrary::create(const std::filesystem::path& scene) const {
  std::array<char, 2048> problem{};
  palpate_steps* steps = create_(scene.c_str(), problem.data(), problem.size());
  if (steps == nullptr) { throw InputError(name_ + " refuses " + problem.data()); }
  return {*this, steps};
}

namespace {

constexpr double least_batch = 0.5e-3;  // [s]

struct BatchTime {
  double processor = 0.0;
  double wall = 0.0;
};

BatchTime time_of(LibrarySteps& steps, long ticks) {
  const double wall = bench::seconds_on(bench::Clock::wall);
  const double processor = bench::seconds_on(bench::Clock::processor);
  steps.run(ticks);
  return {.processor = bench::seconds_on(bench::Clock::processor) - processor,
          .wall = bench::seconds_on(bench::Clock::wall) - wall};
}

/// Simulations of one scene by both builds, at the same tick.
class PairOfSteps {
 public:
  explicit PairOfSteps(const PairedPlan& plan) : plan_(plan), head_next_(plan.head_first) {
    (plan.head_first ? head_ : base_).emplace(plan.head_first ? plan.head : plan.base);
    (plan.head_first ? base_ : head_).emplace(plan.head_first ? plan.base : plan.head);
    begin_anew();
    choose_batch();
  }

  Pair time(bool head_first) {
    if (done_ + batch_ > tick_count_) { begin_anew(); }
    done_ += batch_;
    BatchTime head;
    if (head_first) { head = time_of(*head_steps_, head_ticks()); }
    const BatchTime base = time_of(*base_steps_, batch_);
    if (!head_first) { head = time_of(*head_steps_, head_ticks()); }
    return {.base = base.processor,
            .head = head.processor,
            .base_wall = base.wall,
            .head_wall = head.wall};
  }
  [[nodiscard]] double batch_deadline() const {
    return static_cast<double>(batch_) * base_steps_->tick_length();
  }
  [[nodiscard]] bool same_motion() { return base_steps_->digest() == head_steps_->digest(); }

 private:
  [[nodiscard]] long head_ticks() const {
    return plan_.planted ? batch_ + batch_ / planted_every : batch_;
  }

  /// Restarts both scenes. The builds alternate in the order of destruction and creation, so that
  /// each uses the memory addresses of the other equally often.
  void begin_anew() {
    if (head_next_) { head_steps_.reset(); }
    base_steps_.reset();
    if (!head_next_) { head_steps_.reset(); }
    if (head_next_) { head_steps_.emplace(head_->create(plan_.scene)); }
    base_steps_.emplace(base_->create(plan_.scene));
    if (!head_next_) { head_steps_.emplace(head_->create(plan_.scene)); }
    head_next_ = !head_next_;
    tick_count_ = base_steps_->tick_count();
    done_ = 0;
  }

  void choose_batch() {
    if (tick_count_ < planted_every) {
      throw InputError(plan_.scene.string() + ": " + std::to_string(tick_count_) +
                       " ticks; at least " + std::to_string(planted_every));
    }
    const double seconds = std::max(time_of(*base_steps_, planted_every).processor, 1e-7);
    const long most = tick_count_ / planted_every;
    batch_ = planted_every * std::clamp(std::lround(std::ceil(least_batch / seconds)), 1L, most);
    begin_anew();
  }

  const PairedPlan& plan_;
  std::optional<LoadedLibrary> base_, head_;
  std::optional<LibrarySteps> base_steps_,
      head_steps_;  // destroyed before the libraries
  bool head_next_;
  long tick_count_ = 0;
  long batch_ = planted_every;
  long done_ = 0;
};

double next_number(std::istream& words) {
  double number = std::nan("");
  if (!(words >> number) || !(number > 0.0)) {
    throw InputError("times of a paired run: cut short; as `palpate steps --beside` prints them");
  }
  return number;
}

}  // namespace

PairedReport time_pairs(const PairedPlan& plan) {
  PairOfSteps steps(plan);
  Random random(plan.seed);
  PairedReport report;
  for (int n = 0; n < plan.pairs; ++n) {
    report.start.pairs.push_back(steps.time(random(0.0, 1.0) < 0.5));
  }
  report.start.batch_deadline = steps.batch_deadline();
  report.same_motion = steps.same_motion();
  return report;
}

std::string to_text(const PairedReport& report) {
  std::string text = report.same_motion ? "same\n" : "different\n";
  text += exact_number(report.start.batch_deadline) + " " +
          std::to_string(report.start.pairs.size()) + "\n";
  for (const Pair& pair : report.start.pairs) {
    text += exact_number(pair.base) + " " + exact_number(pair.head) + " " +
            exact_number(pair.base_wall) + " " + exact_number(pair.head_wall) + "\n";
  }
  return text;
}

PairedReport paired_report_from(const std::string& text) {
  std::istringstream words(text);
  PairedReport report;
  std::string motion;
  words >> motion;
  report.same_motion = motion == "same";
  report.start.batch_deadline = next_number(words);
  const auto count = static_cast<std::size_t>(next_number(words));
  for (std::size_t n = 0; n < count; ++n) {
    Pair& pair = report.start.pairs.emplace_back();
    for (double* time : {&pair.base, &pair.head, &pair.base_wall, &pair.head_wall}) {
      *time = next_number(words);
    }
  }
  return report;
}

namespace {

constexpr int bad_input = 2;  // exit code of `palpate` and of our scripts for bad input
constexpr const char* library_name = "libpalpate_steps.so";

/// Cache of instruction counts, which are deterministic.
class Counts {
 public:
  explicit Counts(const std::atomic<bool>* stop) : stop_(stop) {}
  const InstructionCount& of(const std::filesystem::path& library,
                             const std::filesystem::path& scene, long ticks) {
    const std::string key = library.string() + "\n" + scene.string() + "\n" + std::to_string(ticks);
    const auto known = known_.find(key);
    if (known != known_.end()) { return known->second; }
    return known_[key] = count_steps(
               {scene.string(), "--library", library.string(), "--ticks", std::to_string(ticks)},
               stop_);
  }

 private:
  const std::atomic<bool>* stop_;
  std::map<std::string, InstructionCount> known_{};
};

PairedReport run_start(const PairedRuns& runs, const std::filesystem::path& scene, bench::Head head,
                       std::uint64_t seed, bool head_first) {
  std::vector<std::string> words{
      own_program().string(),     "steps",    scene.string(),      "--library",
      runs.base.string(),         "--beside", runs.head.string(),  "--pairs",
      std::to_string(runs.pairs), "--seed",   std::to_string(seed)};
  if (head_first) { words.emplace_back("--head-first"); }
  if (head == bench::Head::planted) { words.emplace_back("--planted"); }
  const ChildEnd end = run_child(words, runs.stop);
  if (end.stopped) { throw std::runtime_error("interrupted"); }
  if (end.status != 0) { throw std::runtime_error(end.last_words()); }
  return paired_report_from(end.output);
}

/// Runs `git` in the source folder and returns the first line of its output.
std::string git_says(const std::filesystem::path& source, const std::vector<std::string>& words,
                     const std::atomic<bool>* stop) {
  std::vector<std::string> command{find_program("git").string(), "-C", source.string()};
  command.insert(command.end(), words.begin(), words.end());
  const ChildEnd end = run_child(command, stop);
  return end.status == 0 ? end.output.substr(0, end.output.find('\n')) : "";
}

}  // namespace

bench::PairedMeasurement measurement_of(const PairedRuns& runs) {
  const auto counts = std::make_shared<Counts>(runs.stop);
  return [runs, counts](const std::string& name, bench::Head head, std::uint64_t seed) {
    const std::filesystem::path scene = runs.scenes / (name + ".toml");
    bench::PairedFinding finding{.same_motion = true};
    const auto most_starts = static_cast<std::uint64_t>(runs.starts) * most_looks;
    finding.starts = starts_until_decided(runs.starts, [&](int n) {
      const std::uint64_t of_start = seed * most_starts + static_cast<std::uint64_t>(n);
      PairedReport report = run_start(runs, scene, head, of_start, n % 2 == 1);
      finding.same_motion = finding.same_motion && report.same_motion;
      return std::move(report.start);
    });
    const long further = head == bench::Head::planted ? 1 : 0;
    finding.base = counts->of(runs.base, scene, planted_every);
    finding.head = counts->of(runs.head, scene, planted_every + further);
    return finding;
  };
}

std::filesystem::path own_library() {
  const std::filesystem::path file = own_program().parent_path() / library_name;
  if (!std::filesystem::exists(file)) {
    throw InputError(file.string() +
                     ": no such file; the build's step library (cmake --build makes it)");
  }
  return file;
}

std::filesystem::path library_of(const std::string& revision, const std::filesystem::path& source,
                                 const std::filesystem::path& cache,
                                 const std::atomic<bool>* stop) {
  if (std::filesystem::is_regular_file(revision)) { return revision; }
  const std::string commit =
      git_says(source, {"rev-parse", "--verify", "--quiet", revision + "^{commit}"}, stop);
  const std::filesystem::path file = cache / "base" / (commit + ".so");
  if (!commit.empty() && std::filesystem::exists(file)) { return file; }
  const ChildEnd end =
      run_child({(source / "scripts" / "build-base").string(), revision, file.string()}, stop);
  if (end.status == bad_input) { throw InputError("--against " + end.last_words()); }
  if (end.status != 0) {
    throw std::runtime_error("scripts/build-base " + revision + ": " + end.last_words());
  }
  return file;
}

}  // namespace palpate::timing
