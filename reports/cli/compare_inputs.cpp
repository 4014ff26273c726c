// SPDX-License-Identifier: MIT
#include "reports/cli/compare_inputs.hpp"

#include <algorithm>
#include <cmath>

#include "fixtures/io/content_hash.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/problems.hpp"
#include "fixtures/io/trace_input.hpp"
#include "model/dynamics/scene_check.hpp"
#include "reports/cli/scene_run.hpp"
#include "reports/markup.hpp"

namespace palpate::cli {

namespace {

constexpr std::size_t most_compared_bytes = std::size_t{4} << 30U;

std::string hash_of(const std::filesystem::path& file) {
  return io::content_hash(io::read_bytes(file, most_compared_bytes));
}

void add_folder(const std::filesystem::path& folder, std::vector<std::filesystem::path>& files) {
  std::vector<std::filesystem::path> found;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".h5") { found.push_back(entry.path()); }
  }
  if (found.empty()) {
    throw InputError(folder.string() + ": has no .h5 file; a folder of recordings has some");
  }
  std::ranges::sort(found);
  std::ranges::move(found, std::back_inserter(files));
}

/// Behind "FILE: no column ".
std::string needed(const std::string& column) {
  return column +
         "; needed for what is compared (--quantity pressure: a [syringe]; force: a needle or probe)";
}

/// Over once a loss of resistance is old enough, else once the scene's own duration is.
bool long_enough(const Trace& trace, double duration, double rest) {
  const double slack = 1e-9 * duration;
  if (trace.time.back() < duration - slack) { return false; }
  for (const Event& event : trace.events) {
    if (event.kind == "loss-of-resistance") { return trace.time.back() >= event.time + rest - slack; }
  }
  return true;
}

/// Throws InputError where a trace holds nothing that could be compared.
void check_samples(const std::filesystem::path& file, const Trace& trace, const Column& column) {
  const auto refuse = [&](const std::string& what) {
    throw InputError(file.string() + ": " + what +
                     "; a trace of at least two samples with numbers is needed");
  };
  if (trace.time.size() < 2) { refuse(trace.time.empty() ? "has no samples" : "has one sample"); }
  if (std::ranges::none_of(column.values, [](double v) { return std::isfinite(v); })) {
    refuse("no number in column " + column.name);
  }
}

}  // namespace

std::vector<ComparedRecording> read_recordings(const std::vector<std::filesystem::path>& paths) {
  std::vector<std::filesystem::path> files;
  std::vector<ComparedRecording> recordings;
  std::string problems;
  const auto gather = [&](auto&& read) {
    try {
      read();
    } catch (const InputError& error) {
      problems += (problems.empty() ? "" : "\n") + std::string(error.what());
    }
  };
  for (const std::filesystem::path& path : paths) {
    gather([&] {
      if (std::filesystem::is_directory(path)) { return add_folder(path, files); }
      files.push_back(path);
    });
  }
  for (const std::filesystem::path& file : files) {
    gather([&] {
      ComparedRecording one{.file = file, .input = read_any_recording(file)};
      one.hash = hash_of(file);
      const auto twin = std::ranges::find(recordings, one.hash, &ComparedRecording::hash);
      if (twin != recordings.end()) {
        throw InputError(file.string() + ": the same bytes as " + twin->file.string() +
                         "; every recording once");
      }
      if (one.input.recording.name.empty()) { one.input.recording.name = file.stem().string(); }
      recordings.push_back(std::move(one));
    });
  }
  if (!problems.empty()) { throw InputError(problems); }
  return recordings;
}

ComparedSimulation read_simulation(const std::filesystem::path& file, const std::string& column) {
  ComparedSimulation simulation{.origin = ComparedSimulation::Origin::trace, .file = file};
  simulation.trace = io::read_trace(file);
  const Column* compared = simulation.trace.find(column);
  if (compared == nullptr) { throw InputError(file.string() + ": no column " + needed(column)); }
  check_samples(file, simulation.trace, *compared);
  simulation.hash = hash_of(file);
  return simulation;
}

SceneRun prepare_scene(const CompareOptions& options, const std::string& column, double rest) {
  SceneRun run{.loaded = load_scene(options.scene, options, false, rest), .rest = rest};
  const auto& columns = run.loaded.simulation.columns();
  if (std::ranges::none_of(columns, [&](const Column& one) { return one.name == column; })) {
    throw InputError(options.scene.string() + ": no column " + needed(column));
  }
  return run;
}

SimulatedScene simulate_scene(SceneRun& scene, bool quiet) {
  const io::SceneFile& file = scene.loaded.file;
  const double duration = file.scene.simulation.duration;
  RollOutOptions how = roll_out_options(scene.loaded, quiet);
  how.frames = 0;
  how.enough = [&](const Trace& trace) { return long_enough(trace, duration, scene.rest); };
  std::optional<FalconLoop> falcon;
  if (file.scene.drive && file.scene.drive->kind == Drive::Kind::falcon) {
    how.falcon = &falcon.emplace(file.scene, scene.loaded.simulation, FalconLoopOptions{});
  }
  Run run = roll_out(scene.loaded.simulation, how);
  SimulatedScene done{.provenance = scene_provenance(scene.loaded), .interrupted = run.interrupted};
  done.simulation = {.origin = ComparedSimulation::Origin::scene,
                     .file = file.inputs.front(),
                     .hash = io::content_hash(file.text),
                     .title = file.scene.title};
  const double longer = run.trace.time.back() - duration;
  if (longer > 0.5 * file.scene.simulation.step) { done.simulation.run_longer = longer; }
  if (run.diverged) { done.simulation.failure = "diverged at t = " + quantity(run.diverged_at, "s"); }
  done.simulation.trace = std::move(run.trace);
  return done;
}

}  // namespace palpate::cli
