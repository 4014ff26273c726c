// SPDX-License-Identifier: MIT
/// The command `compare`: recordings from files or folders, compared with a simulated trace.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/problems.hpp"
#include "fixtures/io/trace_file.hpp"
#include "model/problem/input_error.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/loaded_scene.hpp"
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
  std::string quantity = "automatic";
  std::string alignment = "automatic";
  double cutoff = 20.0;                   ///< cut-off frequency [Hz]; 0: no filter
  std::vector<std::string> tolerances{};  ///< syntax of tolerance_from()
  double numerical_uncertainty = 0.0;     ///< u_num [1] of simulated values
  double input_uncertainty = 0.0;         ///< u_input [1] of simulated values
  SubjectChoice subject{};
};

/// End of the message "FILE: no column ...".
std::string needed(const std::string& column) {
  return column +
         "; needed for what is compared (--quantity pressure: a [syringe]; force or insertion: a "
         "needle or probe)";
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

/// Throws InputError, also if the trace has no column of that name or no number in it.
ComparedSimulation read_simulation(const std::filesystem::path& file, const std::string& column) {
  ComparedSimulation simulation{.origin = ComparedSimulation::Origin::trace, .file = file};
  simulation.trace = io::read_trace(file);
  const Column* compared = simulation.trace.find(column);
  if (compared == nullptr) { throw InputError(file.string() + ": no column " + needed(column)); }
  check_samples(file, simulation.trace, *compared);
  simulation.hash = hash_of_file(file);
  return simulation;
}

/// Runs the scene for its duration, or until `rest` [s] after a loss of resistance, so that the
/// rule that finds it has enough samples. Returns false after an interrupt.
bool simulate(LoadedScene& loaded, Subject& subject, double rest, bool quiet,
              ComparisonReport& report) {
  const io::SceneFile& file = loaded.file;
  const double duration = file.scene.simulation.duration;
  RunControl how = run_control(quiet);
  how.enough = [&](const Trace& trace) { return long_enough(trace, duration, rest); };
  ComparedSimulation& simulation = report.simulation;
  simulation = {.origin = ComparedSimulation::Origin::scene,
                .file = file.inputs.front(),
                .hash = io::content_hash(file.text),
                .title = file.scene.title,
                .trace = roll_out(subject, file.scene, {}, how)};
  report.provenance = scene_provenance(loaded);
  if (&subject != &loaded.subject) { report.provenance.merge(subject_provenance(subject.facts())); }
  const Trace& trace = simulation.trace;
  const double longer = trace.time.back() - duration;
  if (longer > 0.5 * file.scene.simulation.step) { simulation.run_longer = longer; }
  if (trace.diverged) {
    simulation.failure = "diverged at t = " + quantity(trace.diverged_at, "s");
  }
  return !trace.interrupted;
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

/// Returns the quantity that the user asks for. Without a request: insertion if no recording has a
/// pressure, else pressure. Throws InputError if only some have one.
QuantityKind quantity_of(const CompareOptions& asked,
                         const std::vector<RecordingFile>& recordings) {
  using enum QuantityKind;
  if (asked.quantity != "automatic") {
    return value_named("--quantity", asked.quantity, std::array{pressure, force, insertion});
  }
  const auto by_force = std::ranges::count_if(
      recordings, [](const RecordingFile& one) { return one.input.recording.pressure.empty(); });
  if (by_force > 0 && by_force < std::ssize(recordings)) {
    throw InputError("compare: " + std::to_string(by_force) + " of " +
                     std::to_string(recordings.size()) +
                     " recordings have no pressure; --quantity pressure, force or insertion must "
                     "say what is compared");
  }
  return by_force > 0 ? insertion : pressure;
}

GroupOptions group_options(const CompareOptions& asked,
                           const std::vector<RecordingFile>& recordings) {
  constexpr double least_cutoff = 1.0;  // [Hz]: three periods are added at either end of a trace
  if (!(asked.cutoff == 0.0 || asked.cutoff >= least_cutoff)) {
    throw InputError("--cutoff " + plain_number(asked.cutoff) +
                     "; must be 0 for none, or at least 1 Hz");
  }
  GroupOptions options;
  ComparisonOptions& o = options.comparison;
  o.quantity = quantity_of(asked, recordings);
  using enum AlignmentRule;
  o.alignment =
      value_named("--align", asked.alignment,
                  std::array{automatic, AlignmentRule::depth, event, start, contact, clock});
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

void tell(const ComparisonReport& report, const std::filesystem::path& folder,
          const CommonOptions& options) {
  std::printf("%s: %s\n",
              in_colour(verdict_text(report), holds(report) ? Status::pass : Status::fail).c_str(),
              io::printable(verdict_sentence(report)).c_str());
  if (options.quiet) { return; }
  std::printf("recordings: %s\n", tally_of(report).c_str());
  const bool more =
      report.found.outcome.reasons.size() > 1;  // the first reason is already in the sentence
  for (const std::string& reason : report.found.outcome.reasons) {
    if (more) { std::printf("  %s\n", io::printable(reason).c_str()); }
  }
  if (report.simulation.run_longer > 0.0) {
    std::printf(
        "simulated %.4g s longer than the duration of the scene, until the loss of resistance "
        "could be detected\n",
        report.simulation.run_longer);
  }
  for (const Comparison& one : report.found.recordings) {
    if (!one.alignment.not_by_depth.empty()) {
      std::printf("%s: aligned %s\n", io::printable(one.recording).c_str(),
                  one.alignment.how.c_str());
    }
  }
  for (const RecordingFile& one : report.recordings) {
    for (const std::string& warning : one.input.warnings) {
      std::fprintf(stderr, "palpate: warning: %s: %s\n", io::printable(one.file.string()).c_str(),
                   io::printable(warning).c_str());
    }
  }
  std::printf("%s\n%s\n", io::printable((folder / "comparison.json").string()).c_str(),
              io::printable((folder / "report.html").string()).c_str());
}

int run_compare(const CompareOptions& options) {
  if (options.scene.empty() == options.trace.empty()) {
    throw InputError("compare: exactly one of --scene and --trace is needed");
  }
  if (!options.trace.empty() && options.subject.foreign()) {
    throw InputError("compare: --subject simulates a scene; --trace has none");
  }
  if (!options.trace.empty() && !options.overrides.empty()) {
    throw InputError("compare: --set overrides keys of a scene; --trace has none");
  }
  ComparisonReport report{.command = options.command};
  report.recordings = read_recordings(options.recordings);
  report.options = group_options(options, report.recordings);
  const std::string& column = report.options.comparison.column;
  std::vector<Outcome> validated;
  if (!options.results.empty()) { validated = read_results_folder(options.results).outcomes; }
  std::optional<LoadedScene> scene;
  std::unique_ptr<Subject> foreign;
  const LossRule& loss = report.options.comparison.features.loss;
  const double rest = loss.hold + loss.settle;
  if (options.trace.empty()) {
    scene.emplace(load_scene(options.scene, options, false, rest));
    if (std::ranges::count(scene->subject.columns(), column, &Column::name) == 0) {
      throw InputError(options.scene.string() + ": no column " + needed(column));
    }
    foreign = foreign_subject(confined(options.subject, options, options.recordings), *scene, rest);
  } else {
    report.simulation = read_simulation(options.trace, column);
    report.provenance = build_provenance();
  }
  const std::filesystem::path folder = options.make_folder(
      scene ? std::vector<std::string>{"comparison.json", "report.html", "trace.h5"}
            : std::vector<std::string>{"comparison.json", "report.html"});
  if (!options.results.empty()) { refuse_folder_of(options.results, folder); }
  if (!options.trace.empty()) {
    const std::filesystem::path run = std::filesystem::absolute(options.trace).parent_path();
    if (is_run_folder(run)) { refuse_folder_of(run, folder); }
  }
  keep_results_of_interrupted();
  if (scene && !simulate(*scene, foreign != nullptr ? *foreign : scene->subject, rest,
                         options.quiet, report)) {
    return interrupted_code;
  }
  std::vector<Recording> recordings;
  for (const RecordingFile& one : report.recordings) { recordings.push_back(one.input.recording); }
  const bool failed = !report.simulation.failure.empty();
  report.found = compare_all(recordings,
                             failed ? Trace{.columns = {{report.options.comparison.column, "", {}}}}
                                    : report.simulation.trace,
                             report.options);
  if (failed) {
    report.found.outcome.reasons.insert(report.found.outcome.reasons.begin(),
                                        "the simulation " + report.simulation.failure);
  }
  report.credibility = credibility(validated, &report.found);
  // All contents are created before the first file is written.
  const std::string json = to_json(report);
  const std::string page = to_html(report);
  const io::WholeWrite whole;
  if (report.simulation.origin == ComparedSimulation::Origin::scene) {
    io::write_trace_hdf5(folder / "trace.h5", report.simulation.trace, {}, report.provenance);
  }
  io::replace_file(folder / "comparison.json", json);
  io::replace_file(folder / "report.html", page);
  tell(report, folder, options);
  return holds(report) ? done : fell_short;
}

}  // namespace

void add_compare(Program& program) {
  const auto [command, options] = add_command(
      program, "compare", "compare recorded insertions with a simulated one", run_compare);
  add_value(command, "recordings", options.recordings, "RECORDING",
            "recordings in any format that import reads, or folders of .h5 files")
      ->required();
  add_value(command, "--scene", options.scene, "SCENE", "scene to simulate");
  add_value(command, "--trace", options.trace, "TRACE", "trace.h5 or trace.csv of an earlier run");
  add_overrides(command, options);
  command.add_option("--quantity", options.quantity,
                     "pressure, force, or insertion: force with the features of puncture, hold and "
                     "withdrawal [pressure; of recordings with force alone, insertion]");
  command.add_option("--align", options.alignment,
                     "alignment of the clocks: automatic (depth, else event, else start; of an "
                     "insertion, contact), depth, event, start, contact, or clock (not shifted) "
                     "[automatic]");
  add_value(command, "--cutoff", options.cutoff, "HZ",
            "cut-off of the low-pass filter, from 1 to a quarter of a sample rate; 0: no filter, "
            "and noise is not estimated [20]")
      ->check(number_range(0.0, 1e6));
  add_value(command, "--tolerance", options.tolerances, "FEATURE=WIDTH",
            "FEATURE=WIDTH instead of its default; repeatable");
  const CLI::Validator share = number_range(0.0, 10.0);
  add_value(command, "--numerical-uncertainty", options.numerical_uncertainty, "SHARE",
            "u_num, standard, as a share of simulated values [0]")
      ->check(share);
  add_value(command, "--input-uncertainty", options.input_uncertainty, "SHARE",
            "u_input, standard, as a share of simulated values [0]")
      ->check(share);
  add_value(command, "--results", options.results, "DIR",
            "results folder of `palpate validate`, shown as evidence at the end");
  add_subject_options(command, options.subject);
  add_json(command, options, "comparison.json");
  command.footer(
      "One of --scene and --trace is needed. Default tolerances of a pressure:\n" +
      tolerance_help(comparison::QuantityKind::pressure) +
      "of an insertion with fewer than three recordings (else twice their standard deviation):\n" +
      tolerance_help(comparison::QuantityKind::insertion) +
      "A width is a share (15%), a number with its unit (7mmHg), their sum (30%+5mmHg/s)\n"
      "or a factor (x2). Writes comparison.json and report.html, and with --scene trace.h5;\n"
      "docs/comparison.md describes the criteria. Exit codes: 0 agrees, 1 differs, is not "
      "distinguishable\nor not comparable, 2 bad input.");
}

}  // namespace palpate::cli
