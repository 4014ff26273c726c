// SPDX-License-Identifier: MIT

#include "reports/timing/paired_runs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <dlfcn.h>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "model/problem/input_error.hpp"
#include "reports/timing/child_process.hpp"
#include "validation/number_text.hpp"
#include "validation/random.hpp"

namespace palpate::timing {

LoadedLibrary::LoadedLibrary(const std::filesystem::path& file)
    : name_(file.string()),
      handle_(std::filesystem::is_regular_file(file)
                  ? dlopen(std::filesystem::absolute(file).c_str(), RTLD_NOW | RTLD_LOCAL)
                  : nullptr,
              &dlclose) {
  constexpr int known_version = 1;
  if (!handle_) {
    const char* reason = dlerror();
    throw InputError(name_ + ": cannot be loaded: " +
                     (reason != nullptr ? reason : "is not a regular file") + "; a step library");
  }
  const auto find = [this](auto*& function, const std::string& name) {
    const std::string symbol = "palpate_steps_" + name;
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(
        dlsym(handle_.get(), symbol.c_str()));
    if (function == nullptr) {
      throw InputError(name_ + ": has no " + symbol +
                       "; a step library, as scripts/build-base makes it");
    }
  };
  decltype(palpate_steps_version)* version = nullptr;
  find(version, "version");
  if (version() != known_version) {
    throw InputError(name_ + ": version " + std::to_string(version()) + " of its functions; " +
                     std::to_string(known_version));
  }
  find(make, "create");
  find(run, "run");
  find(digest, "digest");
  find(kernel, "kernel");
  find(tick_count, "tick_count");
  find(tick_length, "tick_length");
  find(destroy, "destroy");
}

LoadedLibrary::Steps LoadedLibrary::create(const std::filesystem::path& scene) const {
  std::array<char, 2048> problem{};
  Steps steps(make(scene.c_str(), problem.data(), problem.size()), destroy);
  if (!steps) { throw InputError(name_ + " refuses " + problem.data()); }
  return steps;
}

namespace {

constexpr double least_batch = 0.5e-3;  // [s]

struct BatchTime {
  double processor = 0.0;
  double wall = 0.0;
};

/// Simulation of one scene by one build.
struct Build {
  LoadedLibrary library;
  LoadedLibrary::Steps steps;

  explicit Build(const std::filesystem::path& file) : library(file), steps(nullptr, nullptr) {}

  BatchTime time(long ticks) {
    const double wall = bench::seconds_on(bench::Clock::wall);
    const double processor = bench::seconds_on(bench::Clock::processor);
    (void)library.run(steps.get(), ticks);
    return {.processor = bench::seconds_on(bench::Clock::processor) - processor,
            .wall = bench::seconds_on(bench::Clock::wall) - wall};
  }
  [[nodiscard]] std::string digest() {
    std::array<char, 33> text{};
    library.digest(steps.get(), text.data());
    return text.data();
  }
};

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
    const long head_ticks = plan_.planted ? batch_ + batch_ / planted_every : batch_;
    BatchTime head;
    if (head_first) { head = head_->time(head_ticks); }
    const BatchTime base = base_->time(batch_);
    if (!head_first) { head = head_->time(head_ticks); }
    return {.base = base.processor,
            .head = head.processor,
            .base_wall = base.wall,
            .head_wall = head.wall};
  }
  [[nodiscard]] double batch_deadline() const {
    return static_cast<double>(batch_) * base_->library.tick_length(base_->steps.get());
  }
  [[nodiscard]] bool same_motion() { return base_->digest() == head_->digest(); }

 private:
  /// Restarts both scenes. The builds alternate in the order of destruction and creation, so that
  /// each uses the memory addresses of the other equally often.
  void begin_anew() {
    Build& first = head_next_ ? *head_ : *base_;
    Build& second = head_next_ ? *base_ : *head_;
    for (Build* build : {&first, &second}) { build->steps.reset(); }
    for (Build* build : {&first, &second}) { build->steps = build->library.create(plan_.scene); }
    head_next_ = !head_next_;
    tick_count_ = base_->library.tick_count(base_->steps.get());
    done_ = 0;
  }

  void choose_batch() {
    if (tick_count_ < planted_every) {
      throw InputError(plan_.scene.string() + ": " + std::to_string(tick_count_) +
                       " ticks; at least " + std::to_string(planted_every));
    }
    const double seconds = std::max(base_->time(planted_every).processor, 1e-7);
    const long most = tick_count_ / planted_every;
    batch_ = planted_every * std::clamp(std::lround(std::ceil(least_batch / seconds)), 1L, most);
    begin_anew();
  }

  const PairedPlan& plan_;
  std::optional<Build> base_, head_;
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

/// Runs `git` in the source folder and returns the first line of its output.
std::string git_says(const std::filesystem::path& source, const std::vector<std::string>& words,
                     const std::atomic<bool>* stop) {
  std::vector<std::string> command{find_program("git").string(), "-C", source.string()};
  command.insert(command.end(), words.begin(), words.end());
  const ChildEnd end = run_child(command, stop);
  return end.status == 0 ? end.output.substr(0, end.output.find('\n')) : "";
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

bench::PairedMeasurement measurement_of(const PairedRuns& runs) {
  const auto counts = std::make_shared<Counts>(runs.stop);
  return [runs, counts](const std::string& name, bench::Head head, std::uint64_t seed) {
    const std::filesystem::path scene = runs.scenes / (name + ".toml");
    bench::PairedFinding finding{.same_motion = true};
    const auto most_starts = static_cast<std::uint64_t>(runs.starts) * most_looks;
    finding.starts = starts_until_decided(runs.starts, [&](int n) {
      const std::uint64_t of_start = seed * most_starts + static_cast<std::uint64_t>(n);
      std::vector<std::string> words{
          own_program().string(),     "steps",    scene.string(),          "--library",
          runs.base.string(),         "--beside", runs.head.string(),      "--pairs",
          std::to_string(runs.pairs), "--seed",   std::to_string(of_start)};
      if (n % 2 == 1) { words.emplace_back("--head-first"); }
      if (head == bench::Head::planted) { words.emplace_back("--planted"); }
      const ChildEnd end = run_child(words, runs.stop);
      if (end.stopped) { throw std::runtime_error("interrupted"); }
      if (end.status != 0) { throw std::runtime_error(end.last_words()); }
      PairedReport report = paired_report_from(end.output);
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
