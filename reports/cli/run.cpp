// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstdio>
#include <sstream>

#include "device/falcon/wire_recording.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/trace_file.hpp"
#include "fixtures/io/xdmf_file.hpp"
#include "model/dynamics/scene_check.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/falcon_script.hpp"
#include "reports/cli/interrupt.hpp"
#include "reports/cli/loaded_scene.hpp"
#include "reports/cli/palpation.hpp"
#include "reports/cli/run_facts.hpp"
#include "reports/cli/scene_run.hpp"
#include "reports/cli/summary.hpp"
#include "reports/view.hpp"

namespace palpate::cli {

namespace {

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
  if (run.real_time) {
    std::printf("real time: %ld of %ld ticks a period late or more, the latest by %.3g ms\n",
                run.real_time->missed, run.real_time->ticks, 1e3 * run.real_time->worst_lateness);
  }
}

/// --script and --packets need a line between driver and device.
void refuse_without_line(const RunOptions& options, const Scene& scene, bool in_hand) {
  if (!options.packets && options.script.empty()) { return; }
  const std::string about = ": --script and --packets are about a Falcon's line, which ";
  if (!in_hand) {
    throw InputError(options.scene.string() + ": drive.kind" + about +
                     "only a drive of kind \"falcon\" has");
  }
  if (scene.falcon && !scene.falcon->quantised) {
    throw InputError(options.scene.string() + ": falcon.quantised = false" + about +
                     "only a quantised device has");
  }
}

device::falcon::FaultScript faults_of(const RunOptions& options) {
  if (options.script.empty()) { return {}; }
  const FalconScript script = read_falcon_script(options.script, {});
  const char* refused = script.moves_grip      ? "grip: the hand of the scene moves the grip"
                        : script.sets_firmware ? "firmware: the device of a scene keeps to its defaults"
                                               : nullptr;
  if (refused != nullptr) {
    throw InputError(options.script.string() + ": " + refused + "; allowed here are seed and [[fault]]");
  }
  return script.faults;
}

/// Two exchanges a tick, each a request and a reply.
std::size_t most_packets(const Scene& scene, double rate) {
  return 4 * static_cast<std::size_t>(std::lround(scene.simulation.duration * rate) + 1);
}

void write_packets(const std::filesystem::path& folder, const device::falcon::WireRecording& packets) {
  std::ostringstream text;
  write_csv(text, packets);
  io::replace_file(folder / "packets.csv", text.str());
  if (packets.left_out() > 0) {
    std::fprintf(stderr, "palpate: warning: %lld packets did not fit and are not in packets.csv\n",
                 static_cast<long long>(packets.left_out()));
  }
}

}  // namespace

int run(const RunOptions& options) {
  catch_interrupts();
  LoadedScene loaded = load_scene(options.scene, options, options.no_skip);
  const Scene& scene = loaded.file.scene;
  const bool in_hand = scene.drive && scene.drive->kind == Drive::Kind::falcon;
  const double rate = in_hand ? scene.falcon.value_or(FalconDrive{}).rate : 1.0 / scene.simulation.step;
  refuse_without_line(options, scene, in_hand);
  const device::falcon::FaultScript faults = faults_of(options);
  const std::filesystem::path folder = make_folder(options.folder("run"));
  RollOutOptions roll_out_how = roll_out_options(loaded, options.quiet);
  const auto* network = dynamic_cast<const NetworkProblem*>(&loaded.simulation.problem());
  if (network != nullptr && !options.no_view) { roll_out_how.events = events_shown(network->network().node_count()); }
  std::optional<FalconLoop> falcon;
  std::optional<device::falcon::WireRecording> packets;
  if (in_hand) {
    roll_out_how.falcon = &falcon.emplace(scene, loaded.simulation, FalconLoopOptions{.faults = faults});
    if (options.packets) { falcon->observe(&packets.emplace(most_packets(scene, rate))); }
  }
  std::optional<device::DeadlineClock> clock;
  if (options.real_time) { roll_out_how.clock = &clock.emplace(1.0 / rate); }
  const Run result = roll_out(loaded.simulation, roll_out_how);
  const auto provenance = scene_provenance(loaded);
  io::write_trace_csv(folder / "trace.csv", result.trace);
  io::write_trace_hdf5(folder / "trace.h5", result.trace,
                       network != nullptr ? network->network() : SpringNetwork{}, provenance);
  if (network != nullptr && !result.trace.frames.empty()) {
    io::write_xdmf(folder / "trace.xdmf", folder / "trace.h5", result.trace, network->network());
  }
  io::replace_file(folder / "summary.json", summary_json(loaded, result));
  if (packets) { write_packets(folder, *packets); }
  const Palpation palpation = palpate_skin(loaded);
  if (palpation.figure) { io::replace_file(folder / "palpation.csv", palpation.csv); }
  write_run_report(folder, {loaded, result, palpation, provenance, options.no_view ? "not wanted" : ""});
  if (!options.quiet) { tell(result, loaded, folder); }
  if (result.interrupted) { return interrupted_code; }
  return result.diverged ? fell_short : done;
}

}  // namespace palpate::cli
