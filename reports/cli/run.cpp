// SPDX-License-Identifier: MIT
/// The command `run`.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <sstream>

#include "device/falcon/emulator.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/trace_file.hpp"
#include "model/problem/input_error.hpp"
#include "reference/solution.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/falcon_script.hpp"
#include "reports/cli/loaded_scene.hpp"
#include "reports/html/html_page.hpp"
#include "reports/plot/trace_figures.hpp"
#include "reports/results/results_json.hpp"
#include "reports/run_report.hpp"
#include "reports/view/view.hpp"
#include "validation/outcome.hpp"
#include "validation/palpation_map.hpp"
#include "validation/roll_out.hpp"

namespace palpate::cli {
namespace {

struct RunOptions : CommonOptions {
  std::filesystem::path scene{};
  bool no_skip = false;
  bool real_time = false;
  bool no_view = false;            ///< if true, report.html has no 3-D view
  bool packets = false;            ///< if true, packets.csv is written
  std::filesystem::path script{};  ///< script of faults on the Falcon's link
};

/// Trace of a run with the findings of its device and its clock.
struct FinishedRun {
  Trace trace{};
  std::optional<FalconFacts> falcon{};               ///< facts of the device, for a hand-held tool
  std::optional<device::DeadlineFacts> real_time{};  ///< only with the wall clock

  [[nodiscard]] double ns_per_spring_step(std::size_t springs) const {
    return trace.steps == 0 || springs == 0
               ? 0.0
               : 1e9 * trace.seconds /
                     (static_cast<double>(trace.steps) * static_cast<double>(springs));
  }
};

struct Palpation {
  std::optional<Figure> figure{};  ///< empty: not requested, or not possible (see warnings)
  std::vector<std::string> warnings{};
  std::string csv{};  ///< columns x_m,y_m,stiffness_n_per_m; one row per site, x varies fastest
};

template <class Item> void append(std::vector<Item>& items, const std::vector<Item>& more) {
  items.insert(items.end(), more.begin(), more.end());
}

std::string csv_of(const HeatMap& map) {
  std::string text = "x_m,y_m,stiffness_n_per_m\n";
  std::size_t site = 0;
  for (const double y : map.y) {
    for (const double x : map.x) {
      text += plain_number(1e-3 * x, 17) + "," + plain_number(1e-3 * y, 17) + "," +
              plain_number(1e3 * map.z[site++], 17) + "\n";
    }
  }
  return text;
}

/// Palpation map, if the probe of the scene requests one.
Palpation palpate_skin(const LoadedScene& loaded) {
  const Scene& scene = loaded.file.scene;
  const NetworkProblem* problem = loaded.network();
  if (problem == nullptr || !scene.probe || !scene.probe->map) { return {}; }
  Palpation palpation;
  try {
    HeatMap map = palpation_map(scene, *problem, *scene.probe->map);
    palpation.csv = csv_of(map);
    palpation.figure = {.id = "palpation-map",
                        .title = "Palpation map",
                        .caption =
                            "How stiff the skin is under the probe, place by place: force for each "
                            "millimetre of a small push on the tissue at rest.",
                        .x = {.label = "x (mm)"},
                        .y = {.label = "y (mm)"},
                        .heat_map = std::move(map),
                        .square = true};
  } catch (const reference::SolverError& e) {
    palpation.warnings.push_back(std::string("no palpation map: ") + e.what());
  }
  return palpation;
}

using Json = nlohmann::ordered_json;

Json device_json(const FalconFacts& facts) {
  Json json =
      object("ticks", facts.ticks, "saturated_ticks", facts.saturated, "unanswered_requests",
             facts.unanswered, "unhomed_ticks", facts.unhomed, "largest_requested_n",
             facts.largest_requested, "largest_delivered_n", facts.largest_delivered,
             "axial_limit_n", facts.axial_force, "weakest_limit_n", facts.weakest_force,
             "least_energy_j", facts.least_energy, "least_energy_at_s", facts.least_energy_at,
             "taken_by_controller_j", facts.taken_by_controller, "reaction_s", facts.reaction);
  if (facts.lost_resistance_at) {
    add_keys(json, "lost_resistance_at_s", *facts.lost_resistance_at, "overshoot_m",
             facts.overshoot);
  }
  return json;
}

const char* status_of(const Trace& trace) {
  return trace.diverged             ? "diverged"
         : trace.interrupted        ? "interrupted"
         : trace.inverted_cells > 0 ? "unreliable"
                                    : "ok";
}

/// Returns the reasons why the result of a run cannot be trusted.
std::vector<std::string> doubts(const Trace& trace) {
  if (trace.inverted_cells == 0) { return {}; }
  return {std::to_string(trace.inverted_cells) +
          " cells of the tissue turned inside out; smallest corner Jacobian " +
          short_number(trace.smallest_jacobian, 3) +
          " at t = " + quantity(trace.smallest_jacobian_at, "s") +
          ": use a finer spacing, a wider tool, a smaller force, or poissons_ratio above 0.25"};
}

/// Largest force and pressure on the tool, and its deepest place.
void add_peaks(const Trace& trace, Json& json) {
  const Column* force = trace.find("tool.force_n");
  if (force == nullptr || force->values.empty()) { return; }
  const auto peak = std::ranges::max_element(force->values);
  const auto row = static_cast<std::size_t>(peak - force->values.begin());
  const std::vector<double>& place = trace.values("tool.insertion_m");
  add_keys(json, "peak_force_n", *peak, "peak_force_depth_m", place[row]);
  if (const Column* pressure = trace.find("syringe.pressure_pa")) {
    json["peak_pressure_pa"] = std::ranges::max(pressure->values);
  }
  json["deepest_m"] = std::ranges::max(place);
}

std::string summary_json(const LoadedScene& loaded, const FinishedRun& run) {
  const Trace& trace = run.trace;
  const Simulation& simulation = loaded.simulation();
  const StepPlan& plan = simulation.plan();
  const NetworkProblem* network = loaded.network();
  Json json = object("schema", 1, "title", loaded.file.scene.title, "status", status_of(trace));
  if (trace.diverged) { json["diverged_at_s"] = trace.diverged_at; }
  if (const auto reasons = doubts(trace); !reasons.empty()) {
    json["unreliable_because"] = reasons;
  }
  add_keys(json, "smallest_jacobian", trace.smallest_jacobian, "smallest_jacobian_at_s",
           trace.smallest_jacobian_at);
  add_peaks(trace, json);
  add_keys(json, "nodes", network != nullptr ? network->network().node_count() : 1, "springs",
           network != nullptr ? network->network().springs.size() : 1, "ticks", trace.ticks,
           "steps", trace.steps, "integrator", plan.integrator->name, "integrator_reason",
           plan.integrator_reason, "substeps", plan.substeps, "integrator_step_s", plan.h,
           "omega_max_rad_per_s", plan.bounds.omega_estimate, "h_omega_max",
           plan.h * plan.bounds.omega_estimate, "load_s", loaded.load_seconds, "wall_s",
           trace.seconds, "slowest_tick_s", trace.slowest_tick, "ns_per_spring_step",
           run.ns_per_spring_step(simulation.spring_count()), "kernel", plan.kernel);
  if (plan.sleep_force > 0.0) { json["awake_share"] = simulation.awake_share(); }
  add_keys(json, "skipped", plan.skipped, "warnings", plan.warnings, "zero_length_springs",
           simulation.zero_length_springs(), "energy",
           object("initial_j", trace.energy.initial, "final_j", trace.energy.final, "max_j",
                  trace.energy.maximum));
  if (run.falcon) { json["device"] = device_json(*run.falcon); }
  if (run.real_time) {
    const device::DeadlineFacts& facts = *run.real_time;
    json["real_time"] = object("ticks", facts.ticks, "missed", facts.missed, "worst_wake_s",
                               facts.worst_wake, "worst_lateness_s", facts.worst_lateness);
  }
  json["events"] = list_of(trace.events, [](const Event& event) {
    return object("time_s", event.time, "kind", event.kind, "detail", event.detail);
  });
  return json_text(json, 2);
}

std::vector<Fact> scene_facts(const LoadedScene& loaded) {
  const NetworkProblem* network = loaded.network();
  if (network == nullptr) { return {{"tissue", "one spring-mass-damper", ""}}; }
  const auto nodes = network->network().node_count();
  return {{"nodes", std::to_string(nodes), std::to_string(network->free_nodes().size()) + " free"},
          {"springs", std::to_string(network->network().springs.size()), ""}};
}

void add_step_facts(std::vector<Fact>& facts, const StepPlan& plan) {
  const double limit = plan.stable_step.at(std::string(plan.integrator->name));
  facts.push_back({"integrator", std::string(plan.integrator->name), plan.integrator_reason});
  facts.push_back({"substeps a tick", std::to_string(plan.substeps), plan.substeps_reason});
  facts.push_back(
      {"step", quantity(plan.h, "s"),
       std::isfinite(limit) ? "stable below " + quantity(limit, "s") : "no stability limit"});
  facts.push_back({"highest frequency", quantity(plan.bounds.omega_estimate, "rad/s"),
                   "guaranteed below " + quantity(plan.bounds.omega_upper, "rad/s")});
  facts.push_back({"kernel", plan.kernel, ""});
}

/// Mean computation time of a tick as a fraction of the tick period.
Fact tick_cost(const StepPlan& plan, const FinishedRun& run) {
  const double tick = plan.h * plan.substeps;
  const double mean =
      run.trace.ticks > 0 ? run.trace.seconds / static_cast<double>(run.trace.ticks) : 0.0;
  return {"time for a tick", quantity(1e3 * mean, "ms"),
          short_number(100.0 * mean / tick, 3) + " % of its " + quantity(1e3 * tick, "ms") +
              ", with " + std::to_string(plan.substeps) +
              (plan.substeps == 1 ? " step of " : " steps of ") +
              std::string(plan.integrator->name) + "; the slowest took " +
              quantity(1e3 * run.trace.slowest_tick, "ms")};
}

/// Number and largest lateness of ticks that are late relative to the wall clock.
Fact punctuality(const device::DeadlineFacts& facts) {
  return {"ticks too late", std::to_string(facts.missed),
          "of " + std::to_string(facts.ticks) + ", by a period or more; latest by " +
              quantity(1e3 * facts.worst_lateness, "ms") + ", after a sleep by " +
              quantity(1e3 * facts.worst_wake, "ms")};
}

void add_cost_facts(std::vector<Fact>& facts, const LoadedScene& loaded, const FinishedRun& run) {
  const double simulated = run.trace.time.back();
  facts.push_back({"wall time", quantity(run.trace.seconds, "s"),
                   "for " + quantity(simulated, "s") + " simulated; slowest tick " +
                       quantity(1e3 * run.trace.slowest_tick, "ms")});
  facts.push_back({"cost",
                   quantity(run.ns_per_spring_step(loaded.simulation().spring_count()), "ns"),
                   "per spring and step"});
  facts.push_back(
      {"energy",
       quantity(run.trace.energy.initial, "J") + " to " + quantity(run.trace.energy.final, "J"),
       "at most " + quantity(run.trace.energy.maximum, "J")});
}

/// Adds the 3-D view, or the reason why there is none.
void add_view(RunReport& report, const LoadedScene& loaded, const Trace& trace) {
  const NetworkProblem* network = loaded.network();
  if (network == nullptr) { return; }
  std::vector<std::string> notes;
  std::vector<ViewSurface> surfaces;
  if (std::optional<ViewSurface> skin = view_of_skin(loaded.file.scene, notes)) {
    surfaces.push_back(std::move(*skin));
  }
  report.view = make_view({loaded.file.scene, *network, trace, std::move(surfaces)});
  if (report.view) { append(report.view->notes, notes); }
  if (!report.view || !report.interactive) {
    report.skipped.push_back(std::string("view in three dimensions: ") +
                             (report.interactive ? "no frames are kept" : "not wanted"));
  }
}

RunReport report_of(const RunOptions& options, const LoadedScene& loaded, const FinishedRun& run,
                    const Palpation& palpation,
                    const std::map<std::string, std::string>& provenance) {
  const Scene& scene = loaded.file.scene;
  const Trace& trace = run.trace;
  const StepPlan& plan = loaded.simulation().plan();
  RunReport report{.title = scene.title.empty() ? "Palpate run" : scene.title,
                   .held = !trace.diverged && trace.inverted_cells == 0,
                   .facts = tool_facts(trace),
                   .tool_figures = falcon_figures(trace),
                   .skipped = plan.skipped,
                   .warnings = plan.warnings,
                   .provenance = facts_of_map(provenance),
                   .command = options.command};
  report.verdict = trace.diverged ? "Diverged at t = " + quantity(trace.diverged_at, "s")
                                  : (trace.interrupted ? "Interrupted at t = " : "Ran to t = ") +
                                        quantity(trace.time.back(), "s");
  report.detail = trace.diverged
                      ? "The motion left every bound; the traces are kept up to there."
                      : std::to_string(trace.ticks) + " ticks, every state finite and in bounds.";
  if (const auto reasons = doubts(trace); !reasons.empty() && !trace.diverged) {
    report.verdict += ", but not reliable";
    report.detail = reasons.front() + ".";
  }
  if (run.falcon) {
    append(report.facts, falcon_fact_list(*run.falcon));
    report.tool_figures.push_back(force_reach_figure(*run.falcon));
  }
  if (!report.facts.empty()) { report.facts.push_back(tick_cost(plan, run)); }
  if (run.real_time) { report.facts.push_back(punctuality(*run.real_time)); }
  append(report.facts, scene_facts(loaded));
  append(report.facts, patient_facts(scene));
  add_step_facts(report.facts, plan);
  report.facts.push_back({"smallest corner of a cell", short_number(trace.smallest_jacobian, 3),
                          "volume relative to rest, at t = " +
                              quantity(trace.smallest_jacobian_at, "s") + "; inside out at 0"});
  add_cost_facts(report.facts, loaded, run);
  report.interactive = !options.no_view;
  add_view(report, loaded, trace);
  append(report.warnings, palpation.warnings);
  if (palpation.figure) { report.tool_figures.push_back(*palpation.figure); }
  append(report.tool_figures, lookup_figures(scene));
  if (const auto count = loaded.simulation().zero_length_springs(); count > 0) {
    report.warnings.push_back(std::to_string(count) + " springs have no length and exert no force");
  }
  return report;
}

void tell(const FinishedRun& run, const LoadedScene& loaded, const std::filesystem::path& folder) {
  const StepPlan& plan = loaded.simulation().plan();
  for (const std::string& warning : plan.warnings) {
    std::fprintf(stderr, "palpate: warning: %s\n", warning.c_str());
  }
  if (run.trace.diverged) {
    std::fprintf(stderr, "palpate: diverged at t = %.6g s; the trace is kept up to there\n",
                 run.trace.diverged_at);
  }
  for (const std::string& reason : doubts(run.trace)) {
    std::fprintf(stderr, "palpate: unreliable: %s\n", reason.c_str());
  }
  std::printf("%s: %ld ticks x %d substeps of %s in %.3g s; %s\n", status_of(run.trace),
              run.trace.ticks, plan.substeps, std::string(plan.integrator->name).c_str(),
              run.trace.seconds, (folder / "report.html").string().c_str());
  if (run.real_time) {
    std::printf("real time: %ld of %ld ticks a period late or more, the latest by %.3g ms\n",
                run.real_time->missed, run.real_time->ticks, 1e3 * run.real_time->worst_lateness);
  }
}

/// Checks that --script and --packets are used only with a link between driver and device.
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
  const char* refused = script.moves_grip ? "grip: the hand of the scene moves the grip"
                        : script.sets_firmware
                            ? "firmware: the device of a scene keeps to its defaults"
                            : nullptr;
  if (refused != nullptr) {
    throw InputError(options.script.string() + ": " + refused +
                     "; allowed here are seed and [[fault]]");
  }
  return script.faults;
}

/// Number of packets: two exchanges per tick, each a request and a reply.
std::size_t most_packets(const Scene& scene, double rate) {
  return 4 * static_cast<std::size_t>(std::lround(scene.simulation.duration * rate) + 1);
}

void write_packets(const std::filesystem::path& folder,
                   const device::falcon::WireRecording& packets) {
  std::ostringstream text;
  write_csv(text, packets);
  io::replace_file(folder / "packets.csv", text.str());
  if (packets.left_out() > 0) {
    std::fprintf(stderr, "palpate: warning: %lld packets did not fit and are not in packets.csv\n",
                 static_cast<long long>(packets.left_out()));
  }
}

int run_scene(const RunOptions& options) {
  catch_interrupts();
  LoadedScene loaded = load_scene(options.scene, options, options.no_skip);
  const Scene& scene = loaded.file.scene;
  const bool in_hand = scene.drive && scene.drive->kind == Drive::Kind::falcon;
  const double rate =
      in_hand ? scene.falcon.value_or(FalconDrive{}).rate : 1.0 / scene.simulation.step;
  refuse_without_line(options, scene, in_hand);
  const device::falcon::FaultScript faults = faults_of(options);
  const std::filesystem::path folder = options.make_folder();
  SampleOptions samples{.energy_range = true, .frames = scene.output.frames};
  const NetworkProblem* network = loaded.network();
  if (network != nullptr) { samples.cells = &network->network(); }
  if (network != nullptr && !options.no_view) {
    samples.keyframes = events_shown(network->network().node_count());
  }
  RunControl control = run_control(options.quiet);
  control.device.faults = faults;
  std::optional<device::falcon::WireRecording> packets;
  if (options.packets) { control.device.observer = &packets.emplace(most_packets(scene, rate)); }
  std::optional<device::DeadlineClock> clock;
  if (options.real_time) { control.clock = &clock.emplace(1.0 / rate); }
  FinishedRun result;
  if (in_hand) { control.falcon = &result.falcon.emplace(); }
  result.trace = roll_out(loaded.subject, scene, samples, control);
  if (clock) { result.real_time = clock->facts(); }
  const auto provenance = scene_provenance(loaded);
  io::write_trace_csv(folder / "trace.csv", result.trace);
  io::write_trace_hdf5(folder / "trace.h5", result.trace,
                       network != nullptr ? network->network() : SpringNetwork{}, provenance);
  if (network != nullptr && !result.trace.frames.position.empty()) {
    io::write_xdmf(folder / "trace.xdmf", folder / "trace.h5", result.trace, network->network());
  }
  io::replace_file(folder / "summary.json", summary_json(loaded, result));
  if (packets) { write_packets(folder, *packets); }
  const Palpation palpation = palpate_skin(loaded);
  if (palpation.figure) { io::replace_file(folder / "palpation.csv", palpation.csv); }
  io::replace_file(
      folder / "report.html",
      to_html(report_of(options, loaded, result, palpation, provenance), result.trace));
  if (!options.quiet) { tell(result, loaded, folder); }
  if (result.trace.interrupted) { return interrupted_code; }
  return result.trace.diverged || result.trace.inverted_cells > 0 ? fell_short : done;
}

}  // namespace

void add_run(Program& program) {
  const auto [command, options] = add_command(program, "run", "simulate one scene", run_scene);
  add_scene(command, options, options.scene);
  command.add_flag("--no-skip", options.no_skip,
                   "compute what the scene does not need; same result");
  command.add_flag("--no-view", options.no_view,
                   "no 3-D view in report.html, and no data recorded for it");
  command.add_flag("--real-time", options.real_time,
                   "run every tick at its time on the wall clock");
  add_value(command, "--script", options.script, "FILE",
            "faults on the Falcon's line, by time (TOML, docs/falcon.md)");
  command.add_flag("--packets", options.packets,
                   "write packets.csv: all packets on the Falcon's line");
  command.footer(integrator_help());
}

}  // namespace palpate::cli
