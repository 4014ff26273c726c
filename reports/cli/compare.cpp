// SPDX-License-Identifier: MIT
/// The command `compare`: recordings from files or folders, compared with a simulated trace.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/problems.hpp"
#include "fixtures/io/trace_file.hpp"
#include "model/problem/input_error.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/loaded_scene.hpp"
#include "reports/cli/provenance.hpp"
#include "reports/cli/tolerance_text.hpp"
#include "reports/comparison_report.hpp"
#include "reports/html/html_page.hpp"
#include "reports/results/results_folder.hpp"
#include "validation/roll_out.hpp"

namespace palpate::cli {
namespace {

/// Exactly one of `scene` and `trace` is given.
struct CompareOptions : CommonOptions {
  std::vector<std::filesystem::path> recordings{};  ///< recording files, or folders of files
  std::filesystem::path scene{}, trace{};
  std::filesystem::path results{};  ///< validation results for the credibility table
  std::string quantity = "pressure";
  std::string alignment = "automatic";
  double cutoff = 20.0;                   ///< cut-off frequency [Hz]; 0: no filter
  std::vector<std::string> tolerances{};  ///< syntax in tolerance_text.hpp
  double numerical_uncertainty = 0.0;     ///< u_num [1] of simulated values
  double input_uncertainty = 0.0;         ///< u_input [1] of simulated values
};

/// Scene that runs for its duration, or until `rest` after a loss of resistance, so that the
/// detection rule has enough samples.
struct SceneRun {
  LoadedScene loaded;
  double rest = 6.0;  ///< time after the event [s]
};
struct SimulatedScene {
  ComparedSimulation simulation{};
  std::map<std::string, std::string> provenance{};
  bool interrupted = false;
};

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

/// End of the message "FILE: no column ...".
std::string needed(const std::string& column) {
  return column +
         "; needed for what is compared (--quantity pressure: a [syringe]; force: a needle or "
         "probe)";
}

/// Returns true `rest` after a loss of resistance, or at the end of the duration without one.
bool long_enough(const Trace& trace, double duration, double rest) {
  const double slack = 1e-9 * duration;
  if (trace.time.back() < duration - slack) { return false; }
  for (const Event& event : trace.events) {
    if (event.kind == "loss-of-resistance") {
      return trace.time.back() >= event.time + rest - slack;
    }
  }
  return true;
}

/// Throws InputError if a trace has no samples to compare.
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

/// Reads files, and the .h5 files of folders in the order of their names. Throws an InputError with
/// one line per problem.
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

/// Throws InputError, also if the trace has no column of that name or no number in it.
ComparedSimulation read_simulation(const std::filesystem::path& file, const std::string& column) {
  ComparedSimulation simulation{.origin = ComparedSimulation::Origin::trace, .file = file};
  simulation.trace = io::read_trace(file);
  const Column* compared = simulation.trace.find(column);
  if (compared == nullptr) { throw InputError(file.string() + ": no column " + needed(column)); }
  check_samples(file, simulation.trace, *compared);
  simulation.hash = hash_of(file);
  return simulation;
}

/// Throws InputError, also if the scene will have no column of that name.
SceneRun prepare_scene(const CompareOptions& options, const std::string& column, double rest) {
  SceneRun run{.loaded = load_scene(options.scene, options, false, rest), .rest = rest};
  const auto& columns = run.loaded.subject.columns();
  if (std::ranges::none_of(columns, [&](const Column& one) { return one.name == column; })) {
    throw InputError(options.scene.string() + ": no column " + needed(column));
  }
  return run;
}

SimulatedScene simulate_scene(SceneRun& scene, bool quiet) {
  const io::SceneFile& file = scene.loaded.file;
  const double duration = file.scene.simulation.duration;
  RunControl how = run_control(quiet);
  how.enough = [&](const Trace& trace) { return long_enough(trace, duration, scene.rest); };
  Trace run = roll_out(scene.loaded.subject, file.scene, {}, how);
  SimulatedScene done{.provenance = scene_provenance(scene.loaded), .interrupted = run.interrupted};
  done.simulation = {.origin = ComparedSimulation::Origin::scene,
                     .file = file.inputs.front(),
                     .hash = io::content_hash(file.text),
                     .title = file.scene.title};
  const double longer = run.time.back() - duration;
  if (longer > 0.5 * file.scene.simulation.step) { done.simulation.run_longer = longer; }
  if (run.diverged) {
    done.simulation.failure = "diverged at t = " + quantity(run.diverged_at, "s");
  }
  done.simulation.trace = std::move(run);
  return done;
}

using namespace comparison;

template <class Value, std::size_t N>
Value value_named(const std::string& option, const std::string& text,
                  const std::array<Value, N>& values) {
  std::string known;
  for (const Value value : values) {
    if (comparison::name_of(value) == text) { return value; }
    known += (known.empty() ? "" : ", ") + std::string(comparison::name_of(value));
  }
  throw InputError(option + " " + text + "; must be one of " + known);
}

void check_cutoff(const CompareOptions& asked) {
  constexpr double least_cutoff = 1.0;  // [Hz]: three periods are added at either end of a trace
  if (!(asked.cutoff == 0.0 || asked.cutoff >= least_cutoff)) {
    throw InputError("--cutoff " + plain_number(asked.cutoff) +
                     "; must be 0 for none, or at least 1 Hz");
  }
}

GroupOptions group_options(const CompareOptions& asked) {
  check_cutoff(asked);
  GroupOptions options;
  ComparisonOptions& o = options.comparison;
  o.quantity = value_named("--quantity", asked.quantity,
                           std::array{QuantityKind::pressure, QuantityKind::force});
  o.alignment = value_named("--align", asked.alignment,
                            std::array{AlignmentRule::automatic, AlignmentRule::depth,
                                       AlignmentRule::event, AlignmentRule::start});
  o.column = column_of(o);
  o.cutoff = asked.cutoff;
  o.uncertainties.numerical = asked.numerical_uncertainty;
  o.uncertainties.input = asked.input_uncertainty;
  for (const std::string& text : asked.tolerances) {
    o.tolerances.push_back(tolerance_from(text, o.quantity));
    const auto same = [&](const Tolerance& one) {
      return one.feature == o.tolerances.back().feature;
    };
    if (std::ranges::count_if(o.tolerances, same) > 1) {
      throw InputError("--tolerance " + text + ": given before; every feature once");
    }
  }
  return options;
}

/// Quotes a text for a shell.
std::string quoted(const std::string& word) {
  const bool plain =
      word.find_first_not_of(
          "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=+%,") ==
      std::string::npos;
  if (plain && !word.empty()) { return word; }
  std::string text = "'";
  for (const char c : word) { text += c == '\'' ? "'\\''" : std::string(1, c); }
  return text + "'";
}

std::string command_of(const CompareOptions& o) {
  std::string command = "palpate compare";
  const auto add = [&](const std::string& word) { command += " " + quoted(word); };
  const auto add_option = [&](const char* name, const std::string& value) {
    add(name);
    add(value);
  };
  const CompareOptions defaults;
  for (const std::filesystem::path& path : o.recordings) { add(path.string()); }
  if (!o.scene.empty()) { add_option("--scene", o.scene.string()); }
  if (!o.trace.empty()) { add_option("--trace", o.trace.string()); }
  for (const std::string& each : o.overrides) { add_option("--set", each); }
  if (o.quantity != defaults.quantity) { add_option("--quantity", o.quantity); }
  if (o.alignment != defaults.alignment) { add_option("--align", o.alignment); }
  if (o.cutoff != defaults.cutoff) { add_option("--cutoff", plain_number(o.cutoff, 17)); }
  for (const std::string& each : o.tolerances) { add_option("--tolerance", each); }
  const auto add_share = [&](const char* name, double share) {
    if (share > 0.0) { add_option(name, plain_number(share, 17)); }
  };
  add_share("--numerical-uncertainty", o.numerical_uncertainty);
  add_share("--input-uncertainty", o.input_uncertainty);
  if (!o.results.empty()) { add_option("--results", o.results.string()); }
  return command;
}

void judge(const CompareOptions& asked, ComparisonReport& report) {
  std::vector<Recording> recordings;
  for (const ComparedRecording& one : report.recordings) {
    recordings.push_back(one.input.recording);
  }
  const bool failed = !report.simulation.failure.empty();
  report.found = compare_all(recordings,
                             failed ? Trace{.columns = {{report.options.comparison.column, "", {}}}}
                                    : report.simulation.trace,
                             report.options);
  if (failed) {
    report.found.outcome.reasons.insert(report.found.outcome.reasons.begin(),
                                        "the simulation " + report.simulation.failure);
  }
  std::vector<Outcome> outcomes;
  if (!asked.results.empty()) { outcomes = read_results_folder(asked.results).outcomes; }
  report.credibility = credibility(outcomes, &report.found);
  report.command = command_of(asked);
}

void tell(const ComparisonReport& report, const std::filesystem::path& folder) {
  std::printf("%s: %s\n", verdict_text(report).c_str(), verdict_sentence(report).c_str());
  std::printf("recordings: %s\n", tally_of(report).c_str());
  const bool more =
      report.found.outcome.reasons.size() > 1;  // the first reason is already in the sentence
  for (const std::string& reason : report.found.outcome.reasons) {
    if (more) { std::printf("  %s\n", reason.c_str()); }
  }
  if (report.simulation.run_longer > 0.0) {
    std::printf(
        "simulated %.4g s longer than the duration of the scene, until the loss of resistance "
        "could be detected\n",
        report.simulation.run_longer);
  }
  for (const Comparison& one : report.found.recordings) {
    if (!one.alignment.not_by_depth.empty()) {
      std::printf("%s: aligned %s\n", one.recording.c_str(), one.alignment.how.c_str());
    }
  }
  for (const ComparedRecording& one : report.recordings) {
    for (const std::string& warning : one.input.warnings) {
      std::fprintf(stderr, "palpate: warning: %s: %s\n", one.file.string().c_str(),
                   warning.c_str());
    }
  }
  std::printf("%s\n%s\n", (folder / "comparison.json").string().c_str(),
              (folder / "report.html").string().c_str());
}

/// Creates all contents before the first file is written.
void write(const ComparisonReport& report, const std::filesystem::path& folder) {
  const std::string json = to_json(report);
  const std::string page = to_html(report);
  if (report.simulation.origin == ComparedSimulation::Origin::scene) {
    io::write_trace_hdf5(folder / "trace.h5", report.simulation.trace, {}, report.provenance);
  }
  io::replace_file(folder / "comparison.json", json);
  io::replace_file(folder / "report.html", page);
}

int run_compare(const CompareOptions& options) {
  catch_interrupts();
  if (options.scene.empty() == options.trace.empty()) {
    throw InputError("compare: exactly one of --scene and --trace is needed");
  }
  if (!options.trace.empty() && !options.overrides.empty()) {
    throw InputError("compare: --set overrides keys of a scene; --trace has none");
  }
  ComparisonReport report{.options = group_options(options)};
  const std::string& column = report.options.comparison.column;
  report.recordings = read_recordings(options.recordings);
  if (!options.results.empty()) {
    (void)read_results_folder(options.results);
  }  // rejected before anything runs
  std::optional<SceneRun> scene;
  if (options.trace.empty()) {
    const LossRule& loss = report.options.comparison.features.loss;
    scene.emplace(prepare_scene(options, column, loss.hold + loss.settle));
  } else {
    report.simulation = read_simulation(options.trace, column);
    report.provenance = build_provenance();
  }
  const std::filesystem::path folder = make_folder(options.folder("compare"));
  if (scene) {
    SimulatedScene simulated = simulate_scene(*scene, options.quiet);
    if (simulated.interrupted) { return interrupted_code; }
    report.simulation = std::move(simulated.simulation);
    report.provenance = std::move(simulated.provenance);
  }
  judge(options, report);
  write(report, folder);
  if (!options.quiet) { tell(report, folder); }
  return holds(report) ? done : fell_short;
}

}  // namespace

void add_compare(CLI::App& app, std::function<int()>& chosen) {
  const auto [command, options] = add_command(
      app, chosen, "compare", "compare recorded insertions with a simulated one", run_compare);
  command
      .add_option("recordings", options.recordings,
                  "recordings in any format that import reads, or folders of .h5 files")
      ->required()
      ->type_name("RECORDING");
  command.add_option("--scene", options.scene, "scene to simulate")->type_name("SCENE");
  command.add_option("--trace", options.trace, "trace.h5 or trace.csv of an earlier run")
      ->type_name("TRACE");
  add_overrides(command, options, "scene");
  command.add_option("--quantity", options.quantity, "pressure or force [pressure]");
  command.add_option("--align", options.alignment,
                     "alignment of the clocks: automatic (depth, else event, else start), depth, "
                     "event or start [automatic]");
  command
      .add_option("--cutoff", options.cutoff,
                  "cut-off of the low-pass filter, from 1 to a quarter of a sample rate; 0: no "
                  "filter, and noise is not estimated [20]")
      ->type_name("HZ")
      ->check(number_range(0.0, 1e6));
  command
      .add_option("--tolerance", options.tolerances,
                  "FEATURE=WIDTH instead of its default; repeatable")
      ->type_name("FEATURE=WIDTH")
      ->allow_extra_args(false);
  const CLI::Validator share = number_range(0.0, 10.0);
  command
      .add_option("--numerical-uncertainty", options.numerical_uncertainty,
                  "u_num, standard, as a share of simulated values [0]")
      ->type_name("SHARE")
      ->check(share);
  command
      .add_option("--input-uncertainty", options.input_uncertainty,
                  "u_input, standard, as a share of simulated values [0]")
      ->type_name("SHARE")
      ->check(share);
  command
      .add_option("--results", options.results,
                  "results folder of `palpate validate`, shown as evidence at the end")
      ->type_name("DIR");
  add_common(command, options, "compare");
  command.footer(
      "One of --scene and --trace is needed. Default tolerances of a pressure:\n" +
      tolerance_help(comparison::QuantityKind::pressure) +
      "A width is a share (15%), a number with its unit (7mmHg), their sum (30%+5mmHg/s)\n"
      "or a factor (x2). Writes comparison.json and report.html, and with --scene trace.h5;\n"
      "docs/comparison.md describes the criteria. Exit codes: 0 agrees, 1 differs, is not "
      "distinguishable\nor not comparable, 2 bad input.");
}

}  // namespace palpate::cli
