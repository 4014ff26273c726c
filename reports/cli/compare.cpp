// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cstdio>

#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/trace_file.hpp"
#include "model/dynamics/scene_check.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/compare_inputs.hpp"
#include "reports/cli/interrupt.hpp"
#include "reports/cli/provenance.hpp"
#include "reports/comparison_json.hpp"
#include "reports/comparison_words.hpp"
#include "reports/markup.hpp"
#include "reports/results_folder.hpp"
#include "reports/tolerance_text.hpp"

namespace palpate::cli {

namespace {

using namespace comparison;

template <class Value, std::size_t N>
Value value_named(const std::string& option, const std::string& text, const std::array<Value, N>& values) {
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
    throw InputError("--cutoff " + plain_number(asked.cutoff) + "; must be 0 for none, or at least 1 Hz");
  }
}

GroupOptions group_options(const CompareOptions& asked) {
  check_cutoff(asked);
  GroupOptions options;
  ComparisonOptions& o = options.comparison;
  o.quantity =
      value_named("--quantity", asked.quantity, std::array{QuantityKind::pressure, QuantityKind::force});
  o.alignment = value_named(
      "--align", asked.alignment,
      std::array{AlignmentRule::automatic, AlignmentRule::depth, AlignmentRule::event, AlignmentRule::start});
  o.column = column_of(o);
  o.cutoff = asked.cutoff;
  o.uncertainties.numerical = asked.numerical_uncertainty;
  o.uncertainties.input = asked.input_uncertainty;
  for (const std::string& text : asked.tolerances) {
    o.tolerances.push_back(tolerance_from(text, o.quantity));
    const auto same = [&](const Tolerance& one) { return one.feature == o.tolerances.back().feature; };
    if (std::ranges::count_if(o.tolerances, same) > 1) {
      throw InputError("--tolerance " + text + ": given before; every feature once");
    }
  }
  return options;
}

/// As a shell takes it.
std::string quoted(const std::string& word) {
  const bool plain =
      word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=+%,") ==
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
  for (const ComparedRecording& one : report.recordings) { recordings.push_back(one.input.recording); }
  const bool failed = !report.simulation.failure.empty();
  report.found = compare_all(
      recordings,
      failed ? Trace{.columns = {{report.options.comparison.column, "", {}}}} : report.simulation.trace,
      report.options);
  if (failed) {
    report.found.reasons.insert(report.found.reasons.begin(), "the simulation " + report.simulation.failure);
  }
  std::vector<Outcome> outcomes;
  if (!asked.results.empty()) { outcomes = read_results_folder(asked.results).outcomes; }
  report.credibility = credibility(outcomes, &report.found);
  report.command = command_of(asked);
}

void tell(const ComparisonReport& report, const std::filesystem::path& folder) {
  std::printf("%s: %s\n", verdict_text(report).c_str(), verdict_sentence(report).c_str());
  std::printf("recordings: %s\n", tally_of(report).c_str());
  const bool more = report.found.reasons.size() > 1;  // one is in the sentence
  for (const std::string& reason : report.found.reasons) {
    if (more) { std::printf("  %s\n", reason.c_str()); }
  }
  if (report.simulation.run_longer > 0.0) {
    std::printf("simulated %.4g s longer than the scene says, until the loss of resistance could be told\n",
                report.simulation.run_longer);
  }
  for (const Comparison& one : report.found.recordings) {
    if (!one.alignment.not_by_depth.empty()) {
      std::printf("%s: aligned %s\n", one.recording.c_str(), one.alignment.how.c_str());
    }
  }
  for (const ComparedRecording& one : report.recordings) {
    for (const std::string& warning : one.input.warnings) {
      std::fprintf(stderr, "palpate: warning: %s: %s\n", one.file.string().c_str(), warning.c_str());
    }
  }
  std::printf("%s\n%s\n", (folder / "comparison.json").string().c_str(),
              (folder / "report.html").string().c_str());
}

/// Everything is made before anything is written.
void write(const ComparisonReport& report, const std::filesystem::path& folder) {
  const std::string json = to_json(report);
  const std::string page = to_html(report);
  if (report.simulation.origin == ComparedSimulation::Origin::scene) {
    io::write_trace_hdf5(folder / "trace.h5", report.simulation.trace, {}, report.provenance);
  }
  io::replace_file(folder / "comparison.json", json);
  io::replace_file(folder / "report.html", page);
}

}  // namespace

int compare_recordings(const CompareOptions& options) {
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
  }  // refused before anything runs
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

}  // namespace palpate::cli
