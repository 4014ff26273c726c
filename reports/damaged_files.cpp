// SPDX-License-Identifier: MIT
#include "reports/damaged_files.hpp"

#include <filesystem>
#include <functional>

#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/scratch_folder.hpp"
#include "model/dynamics/scene_check.hpp"
#include "reports/baseline_file.hpp"
#include "reports/results_folder.hpp"
#include "validation/gate/approval.hpp"

namespace palpate {

namespace {

namespace fs = std::filesystem;

/// A message without the folder, which differs from run to run.
std::string without_folder(std::string text, const fs::path& folder) {
  const std::string name = folder.string() + "/";
  for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name)) { text.erase(at, name.size()); }
  return text;
}

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
  std::function<void(const io::ScratchFolder&)> inflict{};
};

std::vector<Damage> damages() {
  using Folder = io::ScratchFolder;
  return {
      {"the baseline's file is missing", [](const Folder& s) { fs::remove(s / "b.json"); }},
      {"the baseline's file is empty", [](const Folder& s) { fs::resize_file(s / "b.json", 0); }},
      {"the baseline's file is cut short", [](const Folder& s) { cut_short(s / "b.json"); }},
      {"a line of the baseline is garbled", [](const Folder& s) { replace_in(s / "b.json", "\"ledger\": [", "\"ledger\": "); }},
      {"a number of the baseline was edited", [](const Folder& s) { replace_in(s / "b.json", "\"value\": 3.0", "\"value\": 4.0"); }},
      {"a unit of the baseline was edited", [](const Folder& s) { replace_in(s / "b.json", "\"unit\": \"1\"", "\"unit\": \"m\""); }},
      {"the baseline's curves are missing", [](const Folder& s) { fs::remove(s / "b.h5"); }},
      {"the baseline's curves have another name", [](const Folder& s) { fs::rename(s / "b.h5", s / "c.h5"); }},
      {"the baseline's curves are cut short", [](const Folder& s) { cut_short(s / "b.h5"); }},
      {"the curves belong to another baseline",
       [](const Folder& s) {
         write_baseline(s / "other.json", baseline_of(5.0));
         fs::rename(s / "other.h5", s / "b.h5");
       }},
      {"the results are cut short", [](const Folder& s) { cut_short(s / "results" / "results.json"); }},
      {"a trace of the results is missing", [](const Folder& s) { fs::remove(s / "results" / "traces" / "sample.h5"); }},
      {"a trace of the results is cut short", [](const Folder& s) { cut_short(s / "results" / "traces" / "sample.h5"); }},
      {"a failure of the results says pass",
       [](const Folder& s) { replace_in(s / "results" / "results.json", "\"value\": 3.0", "\"value\": 30.0"); }},
      {"a number of the results is not one",
       [](const Folder& s) { replace_in(s / "results" / "results.json", "\"value\": 3.0", "\"value\": \"nan\""); }}};
}

}  // namespace

std::vector<std::pair<std::string, std::string>> try_damaged_files() {
  std::vector<std::pair<std::string, std::string>> found;
  for (const Damage& damage : damages()) {
    const io::ScratchFolder scratch;
    write_baseline(scratch / "b.json", baseline_of(3.0));
    write_results_folder(scratch / "results", {.title = "sample", .command = "sample", .outcomes = {sample(3.0)}});
    damage.inflict(scratch);
    std::string refusal;
    try {
      (void)read_baseline(scratch / "b.json");
      (void)read_results_folder(scratch / "results");
    } catch (const InputError& problem) { refusal = without_folder(problem.what(), scratch.path()); }
    found.emplace_back(damage.name, refusal);
  }
  return found;
}

}  // namespace palpate
