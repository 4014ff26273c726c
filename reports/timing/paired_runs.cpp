// SPDX-License-Identifier: MIT
#include "reports/timing/paired_runs.hpp"

#include <map>
#include <memory>
#include <stdexcept>

#include "model/dynamics/scene_check.hpp"
#include "reports/timing/child_process.hpp"
#include "reports/timing/instruction_counter.hpp"
#include "reports/timing/paired_steps.hpp"

namespace palpate::timing {

namespace {

constexpr int bad_input = 2;  // what `palpate` and our scripts end with then
constexpr const char* library_name = "libpalpate_steps.so";

/// Instructions are the same every time: counted once for each question.
class Counts {
 public:
  explicit Counts(const std::atomic<bool>* stop) : stop_(stop) {}
  const InstructionCount& of(const std::filesystem::path& library, const std::filesystem::path& scene, long ticks) {
    const std::string key = library.string() + "\n" + scene.string() + "\n" + std::to_string(ticks);
    const auto known = known_.find(key);
    if (known != known_.end()) { return known->second; }
    return known_[key] =
               count_steps({scene.string(), "--library", library.string(), "--ticks", std::to_string(ticks)}, stop_);
  }

 private:
  const std::atomic<bool>* stop_;
  std::map<std::string, InstructionCount> known_{};
};

PairedReport run_start(const PairedRuns& runs, const std::filesystem::path& scene, bench::Head head,
                       std::uint64_t seed, bool head_first) {
  std::vector<std::string> words{own_program().string(),     "steps",    scene.string(),      "--library",
                                 runs.base.string(),         "--beside", runs.head.string(),  "--pairs",
                                 std::to_string(runs.pairs), "--seed",   std::to_string(seed)};
  if (head_first) { words.emplace_back("--head-first"); }
  if (head == bench::Head::planted) { words.emplace_back("--planted"); }
  const ChildEnd end = run_child(words, runs.stop);
  if (end.stopped) { throw std::runtime_error("interrupted"); }
  if (end.status != 0) { throw std::runtime_error(end.last_words()); }
  return paired_report_from(end.output);
}

/// `git` in the source folder; its first line.
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
    throw InputError(file.string() + ": no such file; the build's step library (cmake --build makes it)");
  }
  return file;
}

std::filesystem::path library_of(const std::string& revision, const std::filesystem::path& source,
                                 const std::filesystem::path& cache, const std::atomic<bool>* stop) {
  if (std::filesystem::is_regular_file(revision)) { return revision; }
  const std::string commit = git_says(source, {"rev-parse", "--verify", "--quiet", revision + "^{commit}"}, stop);
  const std::filesystem::path file = cache / "base" / (commit + ".so");
  if (!commit.empty() && std::filesystem::exists(file)) { return file; }
  const ChildEnd end = run_child({(source / "scripts" / "build-base").string(), revision, file.string()}, stop);
  if (end.status == bad_input) { throw InputError("--against " + end.last_words()); }
  if (end.status != 0) { throw std::runtime_error("scripts/build-base " + revision + ": " + end.last_words()); }
  return file;
}

}  // namespace palpate::timing
