// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstdio>
#include <thread>
#include <unistd.h>

#include "fixtures/io/content_hash.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/scene_rewrite.hpp"
#include "model/dynamics/scene_check.hpp"
#include "reports/cli/calibrate_inputs.hpp"
#include "reports/cli/interrupt.hpp"
#include "reports/cli/loaded_scene.hpp"
#include "reports/cli/provenance.hpp"

namespace palpate::cli {
namespace {

using namespace calibration;

void tell_stage(const char* stage) { std::fprintf(stderr, "palpate: %s\n", stage); }

CalibrationOptions calibration_options(const CalibrateOptions& options) {
  const auto cores = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  CalibrationOptions how{.jobs = options.jobs > 0 ? options.jobs : cores, .stop = &interrupted};
  if (!options.quiet && isatty(STDERR_FILENO) != 0) { how.progress = tell_stage; }
  return how;
}

std::string command_of(const CalibrateOptions& options) {
  std::string command = "palpate calibrate";
  for (const auto& path : options.recordings) { command += " " + path.filename().string(); }
  command += " --scene " + options.scene.filename().string();
  const auto add = [&](const char* name, const std::vector<std::string>& values) {
    for (const std::string& value : values) { command += std::string(" ") + name + " " + value; }
  };
  add("--parameter", options.parameters);
  add("--prior", options.priors);
  add("--bounds", options.bounds);
  add("--set", options.overrides);
  return command;
}

/// What stands above fitted.toml; nothing in it differs between two runs.
std::vector<std::string> comment_of(const CalibrationReport& report) {
  std::vector<std::string> lines{
      "Calibrated from " + report.scene + " by `palpate calibrate`: " + calibration_verdict(report) + ".",
      calibration_detail(report), "Told, with 95 % intervals:"};
  const Fit& fit = report.result.fit;
  for (const std::size_t n : fit.told) {
    const FittedParameter& each = fit.parameters[n];
    char text[160];
    std::snprintf(text, sizeof text, ": %.5g (%.3g to %.3g) %s, was %.5g", each.value, each.interval.lower,
                  each.interval.upper, each.parameter.unit.c_str(), each.parameter.prior);
    lines.push_back("  " + each.parameter.key + text);
  }
  lines.emplace_back("All other numbers are those of the scene. Recordings:");
  for (const CalibratedRecording& each : report.recordings) {
    lines.push_back("  " + each.file + " (" +
                    (each.kind == Recording::Kind::measured ? "measured" : "reconstructed") + "), FNV-1a " +
                    each.hash);
  }
  return lines;
}

void tell(const CalibrationReport& report, const std::filesystem::path& folder) {
  const Fit& fit = report.result.fit;
  std::printf("%s\n%s\n", calibration_verdict(report).c_str(), calibration_detail(report).c_str());
  for (const std::size_t n : fit.told) {
    const FittedParameter& each = fit.parameters[n];
    std::printf("  %-44s %.4g -> %.4g %s, 95 %%: %.3g to %.3g\n", each.parameter.key.c_str(),
                each.parameter.prior, each.value, each.parameter.unit.c_str(), each.interval.lower,
                each.interval.upper);
  }
  for (const HeldOut& held : report.result.held_out) {
    std::printf("  without %s: error %.3g %% of those fitted, %.3g %% of those foretold\n",
                held.group.empty() ? "recordings of no group" : held.group.c_str(), 100.0 * held.error_fitted,
                100.0 * held.error_foretold);
  }
  for (const std::string& warning : calibration_warnings(report)) {
    std::fprintf(stderr, "palpate: note: %s\n", warning.c_str());
  }
  std::printf("%s\n", (folder / "report.html").string().c_str());
}

/// The values of the priors that were asked for are those that the scene starts with.
Scene scene_at_priors(const Scene& scene, const std::vector<Parameter>& parameters) {
  std::vector<double> values;
  for (const Parameter& each : parameters) { values.push_back(each.prior); }
  return with_values(scene, parameters, values);
}

}  // namespace

int calibrate(const CalibrateOptions& options) {
  catch_interrupts();
  const LoadedScene loaded = load_scene(options.scene, options, false);
  const Scene& scene = loaded.file.scene;
  if (const std::string why = why_not_calibrated(scene); !why.empty()) {
    throw InputError(options.scene.string() + ": " + why);
  }
  const std::vector<Parameter> parameters = chosen_parameters(options, scene);
  CalibrationReport report;
  report.recordings = read_calibrated(options.recordings);
  report.scene = options.scene.filename().string();
  report.scene_hash = io::content_hash(loaded.file.text);
  report.command = command_of(options);
  report.provenance = build_provenance();
  std::vector<Subject> subjects;
  for (const CalibratedRecording& each : report.recordings) { subjects.push_back(each.subject); }
  try {
    report.result = calibration::calibrate(scene_at_priors(scene, parameters), parameters, subjects,
                                           calibration_options(options));
  } catch (const Interrupted&) {
    std::fprintf(stderr, "palpate: interrupted before a fit; nothing was written\n");
    return interrupted_code;
  }
  const std::string page = to_html(report);
  const std::string fitted =
      io::rewrite_scene(loaded.file, changes(scene, report.result.fitted), comment_of(report));
  const std::filesystem::path folder = make_folder(options.folder("calibrate"));
  io::replace_file(folder / "fitted.toml", fitted);
  io::replace_file(folder / "calibration.json", to_json(report));
  io::replace_file(folder / "report.html", page);
  if (!options.quiet) { tell(report, folder); }
  return report.result.held() ? done : fell_short;
}

}  // namespace palpate::cli
