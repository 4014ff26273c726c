// SPDX-License-Identifier: MIT
#include "reports/damaged_files.hpp"

#include <cstdlib>
#include <filesystem>
#include <functional>

#include "fixtures/io/file_bytes.hpp"
#include "model/dynamics/scene_check.hpp"
#include "reports/baseline_file.hpp"
#include "reports/results_folder.hpp"
#include "validation/gate/approval.hpp"

namespace palpate {

namespace {

namespace fs = std::filesystem;

/// Gone when it goes out of scope.
class Scratch {
 public:
  Scratch() : folder_(fs::temp_directory_path() / "palpate-damaged-XXXXXX") {
    std::string name = folder_.string();
    if (mkdtemp(name.data()) == nullptr) { throw InputError(name + ": cannot be made; a folder that can be written"); }
    folder_ = name;
  }
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  [[nodiscard]] fs::path operator/(const char* name) const { return folder_ / name; }
  /// A message without the folder, which differs from run to run.
  [[nodiscard]] std::string without_folder(std::string text) const {
    const std::string name = folder_.string() + "/";
    for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name)) { text.erase(at, name.size()); }
    return text;
  }

 private:
  fs::path folder_;
};

Outcome sample(double height) {
  Outcome outcome{.name = "sample", .suite = "accuracy", .claim = "A parabola is one."};
  outcome.judge({.name = "height", .value = height, .upper = 10.0, .bound_from = "of a sample"});
  Series curve{.label = "parabola"};
  for (int n = 0; n < 2000; ++n) {
    curve.x.push_back(0.001 * n);
    curve.y.push_back(height * 1e-6 * n * n);
  }
  outcome.figures.push_back(
      {.id = "curve", .title = "Parabola", .x = {.label = "time (s)"}, .y = {.label = "height (m)"}, .series = {curve}});
  conclude(outcome);
  return outcome;
}

gate::Baseline baseline_of(double height) {
  return gate::accept({}, {.command = "sample", .reason = "sample", .outcomes = {sample(height)}});
}

void cut_short(const fs::path& file) { fs::resize_file(file, fs::file_size(file) / 2); }

void replace_in(const fs::path& file, const std::string& old, const std::string& text) {
  std::string bytes = io::read_bytes(file, 1U << 24U);
  bytes.replace(bytes.find(old), old.size(), text);
  io::replace_file(file, bytes);
}

struct Damage {
  std::string name{};
  std::function<void(const Scratch&)> inflict{};
};

std::vector<Damage> damages() {
  return {
      {"the baseline's file is missing", [](const Scratch& s) { fs::remove(s / "b.json"); }},
      {"the baseline's file is empty", [](const Scratch& s) { fs::resize_file(s / "b.json", 0); }},
      {"the baseline's file is cut short", [](const Scratch& s) { cut_short(s / "b.json"); }},
      {"a line of the baseline is garbled", [](const Scratch& s) { replace_in(s / "b.json", "\"ledger\": [", "\"ledger\": "); }},
      {"a number of the baseline was edited", [](const Scratch& s) { replace_in(s / "b.json", "\"value\": 3.0", "\"value\": 4.0"); }},
      {"a unit of the baseline was edited", [](const Scratch& s) { replace_in(s / "b.json", "\"unit\": \"1\"", "\"unit\": \"m\""); }},
      {"the baseline's curves are missing", [](const Scratch& s) { fs::remove(s / "b.h5"); }},
      {"the baseline's curves have another name", [](const Scratch& s) { fs::rename(s / "b.h5", s / "c.h5"); }},
      {"the baseline's curves are cut short", [](const Scratch& s) { cut_short(s / "b.h5"); }},
      {"the curves belong to another baseline",
       [](const Scratch& s) {
         write_baseline(s / "other.json", baseline_of(5.0));
         fs::rename(s / "other.h5", s / "b.h5");
       }},
      {"the results are cut short", [](const Scratch& s) { cut_short(s / "results" / "results.json"); }},
      {"a trace of the results is missing", [](const Scratch& s) { fs::remove(s / "results" / "traces" / "sample.h5"); }},
      {"a trace of the results is cut short", [](const Scratch& s) { cut_short(s / "results" / "traces" / "sample.h5"); }},
      {"a failure of the results says pass",
       [](const Scratch& s) { replace_in(s / "results" / "results.json", "\"value\": 3.0", "\"value\": 30.0"); }},
      {"a number of the results is not one",
       [](const Scratch& s) { replace_in(s / "results" / "results.json", "\"value\": 3.0", "\"value\": \"nan\""); }}};
}

}  // namespace

std::vector<std::pair<std::string, std::string>> try_damaged_files() {
  std::vector<std::pair<std::string, std::string>> found;
  for (const Damage& damage : damages()) {
    const Scratch scratch;
    write_baseline(scratch / "b.json", baseline_of(3.0));
    write_results_folder(scratch / "results", {.title = "sample", .command = "sample", .outcomes = {sample(3.0)}});
    damage.inflict(scratch);
    std::string refusal;
    try {
      (void)read_baseline(scratch / "b.json");
      (void)read_results_folder(scratch / "results");
    } catch (const InputError& problem) { refusal = scratch.without_folder(problem.what()); }
    found.emplace_back(damage.name, refusal);
  }
  return found;
}

}  // namespace palpate
