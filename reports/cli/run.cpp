// SPDX-License-Identifier: MIT
#include <cstdio>

#include <unistd.h>

#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/trace_file.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/interrupt.hpp"
#include "reports/cli/loaded_scene.hpp"
#include "reports/cli/palpation.hpp"
#include "reports/cli/provenance.hpp"
#include "reports/cli/run_facts.hpp"
#include "reports/cli/summary.hpp"

namespace palpate::cli {

namespace {

std::map<std::string, std::string> provenance_of(const LoadedScene& loaded) {
  std::map<std::string, std::string> provenance = build_provenance();
  provenance["scene"] = loaded.file.text;
  std::string overrides;
  for (const std::string& each : loaded.file.overrides) { overrides += each + "\n"; }
  if (!overrides.empty()) { provenance["overrides"] = overrides; }
  return provenance;
}

RollOutOptions roll_out_options(const LoadedScene& loaded, bool quiet) {
  RollOutOptions options{.frames = loaded.file.scene.output.frames, .stop = &interrupted};
  if (!quiet && isatty(STDERR_FILENO) != 0) {
    options.progress = [](double share) { std::fprintf(stderr, "\r%3.0f %%", 100.0 * share); };
  }
  return options;
}

void tell(const Run& run, const LoadedScene& loaded, const std::filesystem::path& folder) {
  const StepPlan& plan = loaded.simulation.plan();
  for (const std::string& warning : plan.warnings) {
    std::fprintf(stderr, "palpate: warning: %s\n", warning.c_str());
  }
  if (run.diverged) {
    std::fprintf(stderr, "palpate: diverged at t = %.6g s; the trace is kept up to there\n",
                 run.diverged_at);
  }
  std::printf("%s: %ld ticks x %d substeps of %s in %.3g s; %s\n",
              run.diverged ? "diverged" : run.interrupted ? "interrupted" : "ok", run.ticks,
              plan.substeps, std::string(plan.integrator->name).c_str(), run.seconds,
              (folder / "report.html").string().c_str());
}

}  // namespace

int run(const RunOptions& options) {
  LoadedScene loaded = load_scene(options.scene, options, options.no_skip);
  const std::filesystem::path folder = make_folder(options.folder("run"));
  std::optional<FalconLoop> falcon;
  RollOutOptions roll_out_how = roll_out_options(loaded, options.quiet);
  const Scene& scene = loaded.file.scene;
  if (scene.drive && scene.drive->kind == Drive::Kind::falcon) {
    roll_out_how.falcon = &falcon.emplace(scene, loaded.simulation);
  }
  const Run result = roll_out(loaded.simulation, roll_out_how);
  const auto provenance = provenance_of(loaded);
  const auto* network = dynamic_cast<const NetworkProblem*>(&loaded.simulation.problem());
  io::write_trace_csv(folder / "trace.csv", result.trace);
  io::write_trace_hdf5(folder / "trace.h5", result.trace,
                       network != nullptr ? network->network() : SpringNetwork{}, provenance);
  io::replace_file(folder / "summary.json", summary_json(loaded, result));
  const Palpation palpation = palpate_skin(loaded);
  if (palpation.figure) { io::replace_file(folder / "palpation.csv", palpation.csv); }
  write_run_report(folder, loaded, result, palpation, provenance);
  if (!options.quiet) { tell(result, loaded, folder); }
  if (result.interrupted) { return interrupted_code; }
  return result.diverged ? fell_short : done;
}

}  // namespace palpate::cli
