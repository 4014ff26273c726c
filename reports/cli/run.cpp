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
#include "fixtures/io/scene_folder.hpp"
#include "fixtures/io/trace_file.hpp"
#include "model/problem/input_error.hpp"
#include "model/problem/needle_path.hpp"
#include "model/problem/recording.hpp"
#include "model/reduction/mode_basis.hpp"
#include "model/reduction/reduced_network.hpp"
#include "model/tissue/network_builder.hpp"
#include "model/tissue/voxel_tissue.hpp"
#include "reference/solution.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/falcon_script.hpp"
#include "reports/cli/loaded_scene.hpp"
#include "reports/html/html_page.hpp"
#include "reports/index_page.hpp"
#include "reports/plot/trace_figures.hpp"
#include "reports/results/results_folder.hpp"
#include "reports/results/results_json.hpp"
#include "reports/run_report.hpp"
#include "reports/view/view.hpp"
#include "validation/outcome.hpp"
#include "validation/palpation_map.hpp"
#include "validation/refinement.hpp"
#include "validation/roll_out.hpp"
#include "validation/signal.hpp"

namespace palpate::cli {
namespace {

struct RunOptions : CommonOptions {
  std::filesystem::path scene{};
  bool no_skip = false;
  bool real_time = false;
  bool refine = false;             ///< measure the error by refined runs
  bool no_view = false;            ///< if true, report.html has no 3-D view
  bool packets = false;            ///< if true, packets.csv is written
  bool vtk = false;                ///< if true, the frames are written for ParaView
  std::optional<double> every{};   ///< time between rows of the trace [s]; none: every tick
  std::filesystem::path script{};  ///< script of faults on the Falcon's link
  SubjectChoice subject{};
};

/// Trace of a run with the findings of its device and its clock.
struct FinishedRun {
  Trace trace{};
  std::optional<FalconFacts> falcon{};               ///< facts of the device, for a hand-held tool
  std::optional<device::DeadlineFacts> real_time{};  ///< only with the wall clock
  double rate = 0.0;                                 ///< ticks of the loop per second [Hz]
  std::optional<SubjectFacts> subject{};             ///< another simulator than the model
  double control = 0.0;                              ///< of an empty call to it [s]
  std::vector<std::string> warnings{};

  [[nodiscard]] bool late() const { return real_time && real_time->missed > 0; }
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

/// Palpation map, if the probe of the scene requests one. None after an interrupt.
Palpation palpate_skin(const LoadedScene& loaded) {
  const Scene& scene = loaded.file.scene;
  const NetworkProblem* problem = loaded.network();
  if (problem == nullptr || !scene.probe || !scene.probe->map) { return {}; }
  Palpation palpation;
  try {
    HeatMap map = palpation_map(scene, *problem, *scene.probe->map, &interrupted);
    if (interrupted) { return {}; }
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

// Error estimate: what changes at half the step, half the spacing, without the reduced-order model
// and with equations solved to rounding (docs/formats.md, "Error estimate").

std::string plain(double value, const char* unit) { return plain_number(value, 4) + " " + unit; }

/// One source of error, and the run that measures it.
struct ErrorSource {
  std::string of{};                      ///< key in error_estimate
  std::string label{};                   ///< name on the page
  std::string how{};                     ///< how the refined run differs
  std::vector<std::string> overrides{};  ///< that refine the scene
  double cost = 1.0;                     ///< estimated time of the refined run, relative to the run
  double nodes = 0.0;                    ///< about how many the refined scene has
  std::string estimate{};                ///< where a share without a refined run comes from
  std::string obstacle{};                ///< reason why there is no refined run; empty: there is
  std::optional<double> share{};         ///< estimated error as a share of the peak
  std::optional<RunDifference> difference{};
  double seconds = 0.0;  ///< of the refined run
};

/// Above these numbers of nodes the whole tissue is too large to measure what a reduced-order model
/// leaves out; it is then compared with one of twice the radius and modes.
constexpr double most_nodes_implicit = 20'000;
constexpr double most_nodes_explicit = 300'000;

void plan_finer_spacing(const Scene& scene, ErrorSource& source) {
  const auto halved = [&](const std::string& table, const std::vector<int>& nodes, double spacing) {
    std::string list;
    for (const int n : nodes) {
      list += (list.empty() ? "[" : ", ") + std::to_string(2 * n - 1);
      source.nodes *= (2.0 * n - 1.0) / n;
    }
    if (nodes.size() == 2) { source.nodes *= 2.0; }
    source.overrides = {table + ".nodes=" + list + "]",
                        table + ".spacing=" + plain_number(0.5 * spacing, 17)};
    source.how = "spacing of " + plain(mm * 0.5 * spacing, "mm") + " in place of " +
                 plain(mm * spacing, "mm");
  };
  const Tissue& tissue = scene.tissue;
  if (tissue.source == Source::layers) {
    halved("tissue.layers", {tissue.block.nodes.begin(), tissue.block.nodes.end()},
           tissue.block.spacing);
  } else if (tissue.source == Source::lattice && tissue.lattice.weights == LatticeWeights::cell) {
    halved("tissue.lattice", {tissue.lattice.nodes.begin(), tissue.lattice.nodes.end()},
           tissue.lattice.spacing);
  } else if (tissue.source == Source::mesh) {
    const double voxel = tissue.voxels->nodes.spacing.x();
    source.overrides = {"tissue.mesh.voxel=" + plain_number(0.5 * voxel, 17)};
    source.how =
        "voxels of " + plain(mm * 0.5 * voxel, "mm") + " in place of " + plain(mm * voxel, "mm");
    source.nodes *= 8.0;
  } else if (tissue.source == Source::mri) {
    const long stride =
        std::lround(tissue.voxels->nodes.spacing.x() / tissue.voxels->image->spacing.x());
    if (stride % 2 != 0) { source.obstacle = "the image has no pixels between its nodes"; }
    source.overrides = {"tissue.mri.stride=" + std::to_string(stride / 2)};
    source.how = "every " + std::to_string(stride / 2) + " pixels in place of every " +
                 std::to_string(stride) + ", within slices";
    source.nodes *= 4.0;
  } else {
    source.obstacle = "the springs are the model itself, not the mesh of a continuum";
  }
}

/// Returns the sources of error of a loaded scene, with the refined scenes that measure them.
std::vector<ErrorSource> error_sources(const LoadedScene& loaded) {
  const Scene& scene = loaded.file.scene;
  const StepPlan& plan = loaded.simulation().plan();
  const NetworkProblem* network = loaded.network();
  const bool implicit = plan.integrator->implicit;
  const double nodes =
      network != nullptr ? static_cast<double>(network->network().node_count()) : 1.0;
  const auto number = [](double value) { return plain_number(value, 17); };
  ErrorSource space{.of = "space", .label = "spacing", .nodes = nodes};
  ErrorSource time{.of = "time", .label = "step", .nodes = nodes};
  ErrorSource reduction{.of = "reduction", .label = "reduced-order model", .nodes = nodes};
  ErrorSource solver{.of = "solver", .label = "solver", .nodes = nodes};
  plan_finer_spacing(scene, space);
  // A solution with factors of a block of n nodes costs n^(4/3), explicit substeps double.
  const double growth = space.nodes / nodes;
  space.cost = implicit ? std::pow(growth, 4.0 / 3.0) : 2.0 * growth;
  time.how = "steps of " + plain(0.5 * plan.h, "s") + " in place of " + plain(plan.h, "s");
  time.cost = 2.0;
  if (scene.simulation.printed.any()) {
    time.obstacle = "the printed equations have one step a tick";
  }
  if (!plan.far) {
    reduction.obstacle = "every node is integrated";
  } else {
    const double near =
        static_cast<double>(std::ranges::count(plan.far->near.near, static_cast<unsigned char>(1)));
    const bool whole = nodes <= (implicit ? most_nodes_implicit : most_nodes_explicit);
    const double radius = whole ? 0.0 : 2.0 * plan.far->radius;
    reduction.overrides = {"simulation.near_radius=" + number(radius)};
    reduction.how = "every node integrated";
    reduction.cost = std::pow(nodes / near, implicit ? 4.0 / 3.0 : 1.0);
    if (!whole) {
      const int modes = 2 * plan.far->modes;
      reduction.overrides.push_back("simulation.far_modes=" + std::to_string(modes));
      reduction.how = "twice the radius and modes, " + plain(mm * radius, "mm") + " and " +
                      std::to_string(modes) + ": the whole tissue is too large";
      reduction.cost = implicit ? 16.0 : 8.0;
    }
  }
  const double tolerance = scene.simulation.solver_tolerance;
  if (!implicit || (tolerance == 0.0 && scene.simulation.solver_corrections == 0)) {
    solver.share = 0.0;
    solver.obstacle = implicit ? "its equations are solved to rounding error"
                               : "an explicit scheme solves no equations";
  } else {
    solver.overrides = {"simulation.solver_tolerance=0.0", "simulation.solver_corrections=0"};
    const int most = scene.simulation.solver_corrections;
    solver.how =
        "equations solved to rounding error in place of " +
        (tolerance > 0.0 ? plain_number(tolerance, 3) : std::string()) +
        (tolerance > 0.0 && most > 0 ? ", and " : "") +
        (most > 0 ? "at most " + std::to_string(most) + " corrections a step" : std::string());
    solver.cost = 2.0;
  }
  std::vector<ErrorSource> sources{std::move(space), std::move(time), std::move(reduction),
                                   std::move(solver)};
  for (ErrorSource& source : sources) {
    source.overrides.push_back("simulation.integrator=\"" + std::string(plan.integrator->name) +
                               "\"");
    const bool finer = source.of == "space";
    // The stable step of an explicit scheme falls with the spacing: "auto" finds it.
    if (finer && !implicit && !scene.simulation.substeps) { continue; }
    const int factor = source.of == "time" || (finer && !implicit) ? 2 : 1;
    source.overrides.push_back("simulation.substeps=" + std::to_string(factor * plan.substeps));
  }
  return sources;
}

/// Runs the refined scene of one source and compares it. Returns false if it was interrupted.
bool measure(const RunOptions& options, const LoadedScene& loaded, const Trace& trace,
             const RunControl& control, ErrorSource& source) {
  std::vector<std::string> overrides = options.overrides;
  append(overrides, source.overrides);
  Trace refined;
  try {
    Scene scene = io::read_scene(options.scene, overrides).scene;
    const NetworkProblem* coarse = loaded.network();
    const SpringNetwork network = coarse != nullptr ? build_network(scene) : SpringNetwork{};
    if (source.of == "space") {
      const Tissue& tissue = loaded.file.scene.tissue;
      const Eigen::Vector3d spacing =
          tissue.voxels ? tissue.voxels->nodes.spacing
                        : Eigen::Vector3d::Constant(coarse->network().springs.lattice()->spacing);
      move_to_finer_nodes(scene, coarse->network(), network, spacing);
    }
    ModelSubject subject;
    subject.load(scene, network, !options.no_skip);
    source.nodes = static_cast<double>(std::max<Eigen::Index>(network.node_count(), 1));
    if (interrupted) { return false; }
    refined = roll_out(subject, scene, {}, control);
  } catch (const InputError& problem) {
    source.obstacle = std::string("the refined scene is refused: ") + problem.what();
    return true;
  }
  source.seconds = refined.seconds;
  if (refined.interrupted) { return false; }
  if (refined.diverged) {
    source.obstacle = "the refined run diverged at t = " + plain(refined.diverged_at, "s");
    return true;
  }
  source.difference = difference_of(trace, refined);
  if (source.difference) { source.share = source.difference->share(); }
  return true;
}

std::string percent(double share) {
  return share > 0.0 && share < 1e-5 ? "under 0.001 %" : plain_number(100.0 * share, 2) + " %";
}

/// Estimates the error of the reduced-order model from its own solution, and warns above
/// simulation.force_error.
void estimate_reduction(const LoadedScene& loaded, const Trace& trace, ErrorSource& source,
                        std::vector<std::string>& warnings) {
  const Scene& scene = loaded.file.scene;
  const StepPlan& plan = loaded.simulation().plan();
  if (!plan.far) { return; }
  const NetworkProblem& problem = *loaded.network();
  const bool tool = scene.needle || scene.probe;
  std::optional<NeedlePath> path;
  if (tool) { path.emplace(scene, problem.network()); }
  const ReductionError error(problem, *plan.far,
                             tool ? path->direction() : Eigen::Vector3d::Zero().eval());
  double peak = 0.0;
  for (const Load& load : problem.loads()) { peak = std::max(peak, load.force.norm()); }
  if (tool) { peak = std::ranges::max(trace.values("tool.force_n")); }
  std::vector<ReductionError::Moment> moments;
  for (const Frames* frames : {&trace.frames, &trace.keyframes}) {
    for (std::size_t n = 0; n < frames->time.size(); ++n) {
      ReductionError::Moment moment{.position = &frames->position[n]};
      if (scene.needle) {
        const auto row = row_at(trace, frames->time[n]);
        // Where the tip cuts or is in the air, its force does not depend on the tissue's.
        if (trace.values("tool.stiffness_n")[row] == 0.0) { continue; }
        moment.tip = path->direction().dot(path->origin()) + trace.values("tool.insertion_m")[row];
        const double cut = trace.values("tool.cut_m")[row];
        const std::size_t interval = path->interval_at(cut);
        const DentLaw law =
            plan.tip.law(cut, path->intervals()[interval].indentation_toe, interval);
        if (law.is_linear()) { moment.contact = law.compliance; }
      }
      moments.push_back(moment);
    }
  }
  const double accepted = scene.simulation.force_error;
  const double nonlinear =
      peak > 0.0 ? error.largest_nonlinear(moments, 0.5 * accepted * peak) / peak : 0.0;
  // The force of a needle depends on the compliance only where it neither cuts nor slides.
  double held = 1.0;
  if (scene.needle && peak > 0.0) {
    const std::vector<double>& elastic = trace.values("tool.stiffness_n");
    held = Eigen::Map<const Eigen::VectorXd>(elastic.data(), std::ssize(elastic)).norm() /
           std::sqrt(static_cast<double>(elastic.size())) / peak;
  }
  const double modes = held * error.linear();
  source.share = modes + nonlinear;
  source.estimate =
      percent(modes) + " by too few modes, " + percent(nonlinear) +
      " by springs beyond simulation.near_radius that are stretched too far to be linear";
  if (*source.share <= accepted) { return; }
  warnings.push_back("the reduced-order model changes the force by about " +
                     percent(*source.share) + ": " + source.estimate +
                     "; increase simulation.near_radius or far_modes");
}

Json json_of(const ErrorSource& source) {
  Json json = object("of", source.of);
  if (!source.difference) {
    json["reason"] = source.obstacle.empty() ? "not finished" : source.obstacle;
    return json;
  }
  const RunDifference& difference = *source.difference;
  add_keys(json, "how", source.how, "nodes", source.nodes, "wall_s", source.seconds, "peak",
           difference.reference, "peak_difference", difference.peak, "curve_difference",
           difference.curve, "extra_events", difference.extra_events, "events",
           list_of(difference.events, [](const MovedEvent& event) {
             return object("kind", event.kind, "detail", event.detail, "depth_m", event.place,
                           "refined_depth_m", event.refined_place);
           }));
  return json;
}

/// One fact for each source of error: its share, or that it is not estimated.
std::vector<Fact> trust_facts(const std::vector<ErrorSource>& sources, const StepPlan& plan) {
  std::vector<Fact> facts;
  for (const ErrorSource& source : sources) {
    std::string value = source.share ? percent(*source.share) : "not estimated";
    std::string why = source.obstacle.empty() ? source.estimate : source.obstacle;
    if (source.difference) {
      const RunDifference& difference = *source.difference;
      double shift = 0.0;
      long lost = difference.extra_events;
      for (const MovedEvent& event : difference.events) {
        if (!event.refined_place) { ++lost; }
        shift = std::max(shift, std::abs(event.refined_place.value_or(event.place) - event.place));
      }
      why = "of the peak, with " + source.how + ": " + percent(difference.peak) + " at the peak, " +
            percent(difference.curve) + " along the curve";
      if (shift > 1e-6) { why += "; events move by up to " + plain(mm * shift, "mm"); }
      if (lost > 0) { why += "; " + counted(lost, "event", "events") + " of one run alone"; }
    } else if (!source.share && source.obstacle.empty()) {
      why = "palpate run --refine";
    }
    if (source.of == "reduction" && !plan.far) { value = "none"; }
    if (source.of == "time" && plan.first_mode) {
      why += "; it damps the first mode with a ratio of " +
             plain_number(plan.stepped_damping_ratio, 3) + ", the material with " +
             plain_number(plan.first_mode->damping_ratio, 3);
    }
    facts.push_back({source.label, value, why});
  }
  return facts;
}

/// Returns true if a refined run can be compared: by a tool, a record or the oscillator.
bool has_measure(const LoadedScene& loaded) {
  const Scene& scene = loaded.file.scene;
  const bool recorded = std::ranges::any_of(scene.records, [](const Record& record) {
    return std::ranges::count(record.quantities, RecordedQuantity::position) > 0;
  });
  return loaded.network() == nullptr || scene.needle || scene.probe || recorded;
}

/// Checks that refined runs have something to refine and something to compare.
void refuse_without_measure(const RunOptions& options, const LoadedScene& loaded) {
  if (options.real_time) {
    throw InputError("--refine with --real-time: refined runs do not keep to the clock; use one");
  }
  if (!has_measure(loaded)) {
    throw InputError(options.scene.string() +
                     ": --refine compares the force on a tool or the positions of records, and "
                     "the scene has neither; add a [[record]]");
  }
  std::string reasons;
  for (const ErrorSource& source : error_sources(loaded)) {
    if (source.obstacle.empty()) { return; }
    reasons += "; " + source.label + ": " + source.obstacle;
  }
  throw InputError(options.scene.string() + ": --refine has nothing to refine" + reasons);
}

/// Warns of cells that come close to folding: their forces depend on the spacing.
void warn_of_closing_cells(const Trace& trace, std::vector<std::string>& warnings) {
  constexpr double close = 0.25;  // a shipped insertion has 0.33
  if (trace.inverted_cells > 0 || !(trace.smallest_jacobian < close)) { return; }
  warnings.push_back("a corner of a cell is left with " + percent(trace.smallest_jacobian) +
                     " of its volume at t = " + plain(trace.smallest_jacobian_at, "s") +
                     ": the force depends on the spacing there, and palpate run --refine measures "
                     "by how much");
}

/// Warns where a refined run differs by more than 5 % of the peak, or has an event that moves by
/// more than 5 % of its depth and 0.3 mm.
void warn_of_differences(const std::vector<ErrorSource>& sources,
                         std::vector<std::string>& warnings) {
  constexpr double share = 0.05;
  constexpr double depth = 3e-4;  // [m]
  for (const ErrorSource& source : sources) {
    if (!source.difference) { continue; }
    const RunDifference& difference = *source.difference;
    std::string found;
    for (const MovedEvent& event : difference.events) {
      if (!event.refined_place) { continue; }
      const double moved = std::abs(*event.refined_place - event.place);
      if (moved > std::max(depth, share * std::abs(event.place))) {
        found = "the " + event.kind + " of " + event.detail + " is at " +
                plain(mm * *event.refined_place, "mm") + ", not at " +
                plain(mm * event.place, "mm");
        break;
      }
    }
    if (found.empty() && std::max(difference.peak, difference.curve) > share) {
      found = "the force differs by " + percent(std::max(difference.peak, difference.curve)) +
              " of the peak";
    }
    if (!found.empty()) { warnings.push_back("not converged: with " + source.how + " " + found); }
  }
}

/// Measures every source of error that can be refined. Returns false if it was interrupted.
bool refine(const RunOptions& options, const LoadedScene& loaded, const Trace& trace,
            RunControl control, std::vector<ErrorSource>& sources) {
  const auto say = [&](const std::string& line) {
    if (!options.quiet) { std::printf("%s\n", line.c_str()); }
    std::fflush(stdout);
  };
  control.falcon = nullptr;
  control.device.observer = nullptr;
  for (const ErrorSource& source : sources) {
    say(source.obstacle.empty() ? "refine " + source.of + ": " + source.how + "; about " +
                                      plain_number(std::round(source.nodes), 9) + " nodes and " +
                                      plain(source.cost * trace.seconds, "s")
                                : "refine " + source.of + ": not done, " + source.obstacle);
  }
  // The cheapest first: an interruption keeps what is finished.
  std::vector<ErrorSource*> order;
  for (ErrorSource& source : sources) {
    if (source.obstacle.empty()) { order.push_back(&source); }
  }
  std::ranges::stable_sort(order, {}, &ErrorSource::cost);
  for (ErrorSource* source : order) {
    if (!measure(options, loaded, trace, control, *source)) { return false; }
    say("refined " + source->of + " in " + plain(source->seconds, "s") + ": " +
        (source->share ? percent(*source->share) + " of the peak" : source->obstacle));
  }
  return true;
}

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

/// Warns of a tip that left the tissue, and of a prescribed motion that the run did not finish.
std::vector<std::string> passage_warnings(const Scene& scene, const SpringNetwork& network,
                                          const Trace& trace) {
  const std::optional<Peaks> peaks = peaks_of(trace);
  if (!peaks || trace.diverged || trace.interrupted) { return {}; }
  std::vector<std::string> warnings;
  if (scene.needle) {
    const NeedlePath path(scene, network);
    const double end = path.knots().back().depth;
    const double spacing =
        path.knots().size() > 1 ? end - path.knots()[path.knots().size() - 2].depth : 0.0;
    if (peaks->deepest > end + spacing) {
      warnings.push_back("the tip left the tissue: it ends at " + quantity(mm * end, "mm") +
                         " on the needle's line, and the tip went to " +
                         quantity(mm * peaks->deepest, "mm") +
                         "; forces beyond are not those of tissue: use a larger block, or a "
                         "smaller drive.depth");
    }
  }
  const bool prescribed = scene.drive && scene.drive->kind == Drive::Kind::trajectory;
  constexpr double rounding = 1e-6;  // [m]
  if (prescribed && scene.drive->depth && peaks->deepest < *scene.drive->depth - rounding &&
      trace.count("bone") == 0) {
    warnings.push_back("drive.depth = " + quantity(mm * *scene.drive->depth, "mm") +
                       " is not reached: the run ends after " + quantity(trace.time.back(), "s") +
                       " at " + quantity(mm * peaks->deepest, "mm") +
                       "; use a longer simulation.duration or a higher drive.speed");
  }
  return warnings;
}

std::string summary_json(const LoadedScene& loaded, const FinishedRun& run,
                         const std::vector<ErrorSource>& sources, bool refined,
                         const std::string& hash_of_trace, const std::string& palpation_map) {
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
  if (const std::optional<Peaks> peaks = peaks_of(trace)) {
    add_keys(json, "peak_force_n", peaks->force, "peak_force_depth_m", peaks->force_depth);
    if (peaks->pressure) { json["peak_pressure_pa"] = *peaks->pressure; }
    json["deepest_m"] = peaks->deepest;
  }
  Json estimate = Json::object();
  for (const ErrorSource& source : sources) { add_keys(estimate, source.of.c_str(), source.share); }
  json["error_estimate"] = estimate;
  if (!run.subject) {
    json["trust"] = list_of(trust_facts(sources, plan), [](const Fact& fact) {
      return object("of", fact.label, "value", fact.value, "why", fact.explanation);
    });
  }
  if (refined) { json["refinement"] = list_of(sources, json_of); }
  if (run.subject) {
    json["subject"] = object("name", run.subject->name, "version", run.subject->version, "licence",
                             run.subject->licence, "carrier", run.subject->carrier, "capabilities",
                             names_of(run.subject->capabilities), "empty_call_s", run.control);
  }
  if (plan.first_mode && !run.subject) {
    json["first_mode"] =
        object("omega_rad_per_s", plan.first_mode->omega, "damping_ratio",
               plan.first_mode->damping_ratio, "stepped_damping_ratio", plan.stepped_damping_ratio);
  }
  add_keys(json, "nodes", network != nullptr ? network->network().node_count() : 1, "springs",
           network != nullptr ? network->network().springs.size() : 1, "ticks", trace.ticks,
           "steps", trace.steps, "integrator", trace.method, "integrator_reason",
           run.subject ? "the subject's own" : plan.integrator_reason, "substeps", trace.substeps,
           "integrator_step_s", trace.h, "omega_max_rad_per_s", plan.bounds.omega_estimate,
           "h_omega_max", trace.h * plan.bounds.omega_estimate, "load_s", loaded.load_seconds,
           "wall_s", trace.seconds, "slowest_tick_s", trace.slowest_tick, "ns_per_spring_step",
           run.ns_per_spring_step(simulation.spring_count()), "kernel",
           run.subject ? run.subject->carrier : plan.kernel);
  if (loaded.file.scene.simulation.solver_corrections > 0 && !run.subject) {
    const LimitedSteps limited = simulation.limited_steps();
    add_keys(json, "limited_steps", limited.count, "largest_last_correction",
             limited.largest_correction);
  }
  if (plan.sleep_force > 0.0 && !run.subject) { json["awake_share"] = simulation.awake_share(); }
  add_keys(json, "skipped", run.subject ? std::vector<std::string>{} : plan.skipped, "warnings",
           run.warnings, "zero_length_springs", simulation.zero_length_springs(), "energy",
           object("initial_j", trace.energy.initial, "final_j", trace.energy.final, "max_j",
                  trace.energy.maximum));
  if (run.falcon) { json["device"] = device_json(*run.falcon); }
  json["late_ticks"] = run.real_time ? Json(run.real_time->missed) : Json(nullptr);
  if (run.real_time) {
    const device::DeadlineFacts& facts = *run.real_time;
    json["real_time"] = object("ticks", facts.ticks, "missed", facts.missed, "worst_wake_s",
                               facts.worst_wake, "worst_lateness_s", facts.worst_lateness);
  }
  json["events"] = list_of(trace.events, [](const Event& event) {
    return object("time_s", event.time, "kind", event.kind, "detail", event.detail);
  });
  json["trace_sha256"] = hash_of_trace;
  if (!palpation_map.empty()) { json["palpation_sha256"] = io::sha256(palpation_map); }
  return sealed_text(std::move(json), 2);
}

/// Result of the last run in a folder; absent without one, or if its summary.json cannot be read.
std::optional<IndexLine> last_run_in(const std::filesystem::path& folder) {
  constexpr std::size_t most_bytes = std::size_t{1} << 26;
  try {
    return index_line_of_run(io::read_text(folder / "summary.json", most_bytes));
  } catch (const std::exception&) { return {}; }
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

void add_subject_facts(std::vector<Fact>& facts, const SubjectFacts& subject, double control) {
  facts.push_back(
      {"simulator", subject.name + " " + subject.version,
       subject.carrier + (control > 0.0 ? "; an empty call takes " + quantity(1e6 * control, "us")
                                        : std::string())});
  facts.push_back({"capabilities", names_of(subject.capabilities), "declared by the simulator"});
}

/// Mean computation time of a tick as a fraction of the tick period.
Fact tick_cost(const FinishedRun& run) {
  const double tick = run.trace.h * run.trace.substeps;
  const double mean =
      run.trace.ticks > 0 ? run.trace.seconds / static_cast<double>(run.trace.ticks) : 0.0;
  return {"time for a tick", quantity(1e3 * mean, "ms"),
          short_number(100.0 * mean / tick, 3) + " % of its " + quantity(1e3 * tick, "ms") +
              ", with " + std::to_string(run.trace.substeps) +
              (run.trace.substeps == 1 ? " step of " : " steps of ") + run.trace.method +
              "; the slowest took " + quantity(1e3 * run.trace.slowest_tick, "ms")};
}

std::string rate_text(double rate) {
  return rate < 1e3 ? plain(rate, "Hz") : plain(1e-3 * rate, "kHz");
}

/// Sentence about the time of a tick, mean and slowest, as shares of its period.
std::string shares_of_period(const FinishedRun& run) {
  const double period = run.trace.h * run.trace.substeps;
  const auto ticks = static_cast<double>(std::max<long>(1, static_cast<long>(run.trace.ticks)));
  return "At " + rate_text(run.rate) + " a tick takes " +
         short_number(100.0 * run.trace.seconds / ticks / period, 2) +
         " % of its period, the slowest " +
         short_number(100.0 * run.trace.slowest_tick / period, 2) + " %.";
}

/// Verdict on a run with the wall clock.
std::string punctuality_verdict(const FinishedRun& run) {
  return rate_text(run.rate) + (run.late() ? " is not held" : " is held");
}

/// Number and largest lateness of ticks that are late relative to the wall clock.
Fact punctuality(const FinishedRun& run) {
  const device::DeadlineFacts& facts = *run.real_time;
  return {"ticks too late", std::to_string(facts.missed),
          punctuality_verdict(run) + ": of " + std::to_string(facts.ticks) +
              ", by a period or more; latest by " + quantity(1e3 * facts.worst_lateness, "ms") +
              ", after a sleep by " + quantity(1e3 * facts.worst_wake, "ms")};
}

void add_cost_facts(std::vector<Fact>& facts, const LoadedScene& loaded, const FinishedRun& run) {
  const double simulated = run.trace.time.back();
  const int most = loaded.file.scene.simulation.solver_corrections;
  if (const LimitedSteps limited = loaded.simulation().limited_steps(); most > 0 && !run.subject) {
    facts.push_back({"steps ended by the limit of " + std::to_string(most) + " corrections",
                     std::to_string(limited.count) + " of " + std::to_string(run.trace.steps),
                     "their last correction: at most " +
                         short_number(100.0 * limited.largest_correction, 2) +
                         " % of the largest velocity"});
  }
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
                    const Palpation& palpation, const std::vector<ErrorSource>& sources,
                    const std::map<std::string, std::string>& provenance) {
  const Scene& scene = loaded.file.scene;
  const Trace& trace = run.trace;
  const StepPlan& plan = loaded.simulation().plan();
  RunReport report{.title = scene.title.empty() ? "Palpate run" : scene.title,
                   .held = !trace.diverged && trace.inverted_cells == 0 && !run.late(),
                   .facts = tool_facts(trace),
                   .tool_figures = falcon_figures(trace),
                   .skipped = run.subject ? std::vector<std::string>{} : plan.skipped,
                   .trust = run.subject ? std::vector<Fact>{} : trust_facts(sources, plan),
                   .warnings = run.warnings,
                   .provenance = facts_of_map(provenance),
                   .command = options.command};
  report.verdict = trace.diverged ? "Diverged at t = " + quantity(trace.diverged_at, "s")
                                  : (trace.interrupted ? "Interrupted at t = " : "Ran to t = ") +
                                        quantity(trace.time.back(), "s");
  report.detail = trace.diverged
                      ? "The motion left every bound; the traces are kept up to there."
                      : std::to_string(trace.ticks) + " ticks, every state finite and in bounds. " +
                            shares_of_period(run);
  if (const auto reasons = doubts(trace); !reasons.empty() && !trace.diverged) {
    report.verdict += ", but not reliable";
    report.detail = reasons.front() + ".";
  }
  if (run.real_time && !trace.diverged) { report.verdict += "; " + punctuality_verdict(run); }
  if (run.falcon) {
    append(report.facts, falcon_fact_list(*run.falcon));
    report.tool_figures.push_back(force_reach_figure(*run.falcon));
  }
  if (!report.facts.empty()) { report.facts.push_back(tick_cost(run)); }
  if (run.real_time) { report.facts.push_back(punctuality(run)); }
  append(report.facts, scene_facts(loaded));
  append(report.facts, patient_facts(scene));
  run.subject ? add_subject_facts(report.facts, *run.subject, run.control)
              : add_step_facts(report.facts, plan);
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
  if (const std::size_t count = report.warnings.size(); count > 0 && report.held) {
    report.detail +=
        count == 1 ? " One warning, below." : " " + std::to_string(count) + " warnings, below.";
  }
  return report;
}

void print_line(const char* label, const std::string& text) {
  std::printf("  %-14s %s\n", label, io::printable(text).c_str());
}

/// One line for each result that a reader looks for first.
void print_findings(const FinishedRun& run, const std::vector<ErrorSource>& sources,
                    const StepPlan& plan) {
  const Trace& trace = run.trace;
  if (const std::optional<Peaks> peaks = peaks_of(trace)) {
    print_line("peak force",
               plain(peaks->force, "N") +
                   (peaks->force > 0.0 ? " at " + plain(mm * peaks->force_depth, "mm") : ""));
    print_line("depth", plain(mm * peaks->deepest, "mm"));
    if (peaks->pressure) {
      print_line("peak pressure", plain(*peaks->pressure / pascals_per_mmhg, "mmHg"));
    }
  }
  constexpr std::size_t most_events = 8;
  for (std::size_t n = 0; n < std::min(trace.events.size(), most_events); ++n) {
    const Event& event = trace.events[n];
    print_line(n == 0 ? "events" : "", plain(event.time, "s") + "  " + event.kind +
                                           (event.detail.empty() ? "" : ", " + event.detail));
  }
  if (trace.events.size() > most_events) {
    print_line("", std::to_string(trace.events.size() - most_events) + " more in summary.json");
  }
  const double period = trace.h * trace.substeps;
  print_line("worst tick",
             plain(1e3 * trace.slowest_tick, "ms") + " of its " + plain(1e3 * period, "ms") + " (" +
                 std::to_string(std::lround(100.0 * trace.slowest_tick / period)) + " %)");
  if (run.subject) { return; }
  std::string trust;
  for (const Fact& fact : trust_facts(sources, plan)) {
    trust += (trust.empty() ? "" : "; ") + fact.label + " " + fact.value;
  }
  print_line("trust", "error by " + trust);
}

/// The command that a reader may want next.
std::string next_step(const RunOptions& options, const LoadedScene& loaded, const FinishedRun& run,
                      const std::vector<ErrorSource>& sources, const std::filesystem::path& page) {
  const std::string scene = in_shell_quotes(options.scene.string());
  if (run.trace.diverged) {
    std::string overrides;
    for (const std::string& each : options.overrides) {
      overrides += " --set " + in_shell_quotes(each);
    }
    return "palpate inspect " + scene + overrides + " (stable_step_s: largest stable step)";
  }
  if (run.late()) { return "palpate certify " + scene + " (is it this machine, or the scene?)"; }
  const bool open_question = std::ranges::any_of(
      sources, [](const ErrorSource& source) { return !source.share && source.obstacle.empty(); });
  const bool measurable =
      open_question && has_measure(loaded) && !run.subject && !options.real_time && !options.refine;
  return "open " + page.string() +
         (measurable ? ", or measure the error: " + options.command + " --refine" : "");
}

/// Returns text of a page in one line for a terminal, with plain spaces.
std::string for_terminal(std::string text) {
  constexpr std::string_view no_break = "\u00a0";
  for (auto at = text.find(no_break); at != text.npos; at = text.find(no_break)) {
    text.replace(at, no_break.size(), " ");
  }
  return io::printable(text);
}

/// What --verbose adds: the scene, how it was stepped, what that cost, and reasons of the trust.
void print_details(const LoadedScene& loaded, const FinishedRun& run,
                   const std::vector<ErrorSource>& sources) {
  std::vector<Fact> facts = scene_facts(loaded);
  if (run.subject) {
    add_subject_facts(facts, *run.subject, run.control);
  } else {
    add_step_facts(facts, loaded.simulation().plan());
    append(facts, trust_facts(sources, loaded.simulation().plan()));
  }
  add_cost_facts(facts, loaded, run);
  for (const Fact& fact : facts) {
    std::string text = fact.label + ": " + fact.value +
                       (fact.explanation.empty() ? "" : " (" + fact.explanation + ")");
    std::printf("  %s\n", for_terminal(std::move(text)).c_str());
  }
}

void tell(const RunOptions& options, const LoadedScene& loaded, const FinishedRun& run,
          const std::vector<ErrorSource>& sources, const std::filesystem::path& folder) {
  const std::filesystem::path page = folder / "report.html";
  for (const std::string& warning : run.warnings) {
    if (!options.quiet) {
      std::fprintf(stderr, "palpate: warning: %s\n", for_terminal(warning).c_str());
    }
  }
  if (run.trace.diverged) {
    std::fprintf(stderr, "palpate: diverged at t = %.6g s; the trace is kept up to there\n",
                 run.trace.diverged_at);
  }
  for (const std::string& reason : doubts(run.trace)) {
    std::fprintf(stderr, "palpate: unreliable: %s\n", for_terminal(reason).c_str());
  }
  const std::string status = status_of(run.trace);
  const std::string word = run.late() && status == "ok" ? "late" : status;
  std::printf("%s: %ld ticks x %d substeps of %s in %.3g s; %s\n",
              in_colour(word, word == "ok" ? Status::pass : Status::fail).c_str(), run.trace.ticks,
              run.trace.substeps, run.trace.method.c_str(), run.trace.seconds,
              io::printable(page.string()).c_str());
  if (options.quiet) { return; }
  if (run.real_time) {
    std::printf("real time: %ld of %ld ticks a period late or more, the latest by %.3g ms; %s\n",
                run.real_time->missed, run.real_time->ticks, 1e3 * run.real_time->worst_lateness,
                punctuality_verdict(run).c_str());
  }
  print_findings(run, sources, loaded.simulation().plan());
  if (options.verbose) { print_details(loaded, run, sources); }
  print_line("next", next_step(options, loaded, run, sources, page));
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

/// Returns the tool at each frame: the tip, and the end of a needle of 90 mm or a probe of 30 mm.
io::ToolLines tool_lines(const Scene& scene, const SpringNetwork& network, const Trace& trace) {
  const Column* place = trace.find("tool.insertion_m");
  if (place == nullptr || (!scene.needle && !scene.probe)) { return {}; }
  const NeedlePath path(scene, network);
  const double length = scene.needle ? 0.09 : 0.03;  // [m]
  io::ToolLines lines;
  for (const double time : trace.frames.time) {
    const auto after = std::ranges::lower_bound(trace.time, time);
    const auto row =
        std::min(static_cast<std::size_t>(after - trace.time.begin()), trace.rows() - 1);
    Eigen::Vector3d origin = path.origin();
    if (scene.probe) { origin.head<2>() = scene.probe->centre(time); }
    const Eigen::Vector3d tip = origin + place->values[row] * path.direction();
    lines.push_back({Eigen::Vector3d(tip - length * path.direction()), tip});
  }
  return lines;
}

/// Provenance in trace.h5: that of the page, and what `approve` needs to run the scene again.
std::map<std::string, std::string> provenance_with_inputs(
    const RunOptions& options, const LoadedScene& loaded,
    std::map<std::string, std::string> provenance) {
  namespace fs = std::filesystem;
  provenance["scene_file"] = fs::absolute(options.scene).string();
  if (!options.script.empty()) { provenance["script"] = fs::absolute(options.script).string(); }
  std::string inputs;
  for (const fs::path& file : loaded.file.inputs) {
    if (file == options.scene) { continue; }
    const fs::path beside = file.lexically_relative(options.scene.parent_path());
    inputs += (beside.empty() ? fs::absolute(file) : beside).string() + " " +
              io::sha256_of_file(file) + "\n";
  }
  if (!options.script.empty()) {
    inputs += "--script " + io::sha256_of_file(options.script) + "\n";
  }
  if (!inputs.empty()) { provenance["inputs"] = inputs; }
  std::string simulator;
  for (const fs::path& file : files_of_subject(options.subject.subject)) {
    simulator += fs::absolute(file).string() + " " + io::sha256_of_file(file) + "\n";
  }
  if (!simulator.empty()) { provenance["simulator_files"] = simulator; }
  if (options.no_skip) { provenance["no_skip"] = "yes"; }
  if (options.every) { provenance["every"] = exact_number(*options.every); }
  return provenance;
}

/// Ticks between rows of the trace. Throws InputError unless the time is a multiple of a tick.
long ticks_between_rows(const RunOptions& options, double rate) {
  if (!options.every) { return 1; }
  const double ticks = *options.every * rate;
  if (std::abs(ticks - std::round(ticks)) > 1e-6 * ticks || ticks < 0.5) {
    throw InputError("--every: " + plain_number(*options.every, 6) +
                     " s between rows; a multiple of a tick, which takes " +
                     plain_number(1.0 / rate, 6) + " s");
  }
  return std::lround(ticks);
}

int run_scene(const RunOptions& options) {
  for (const std::string& each : options.overrides) {
    if (each.find('\n') == each.npos) { continue; }
    throw InputError("--set " + each.substr(0, each.find('=')) +
                     ": has a line break, which trace.h5 cannot keep; \\n in its place");
  }
  LoadedScene loaded = load_scene(options.scene, options, options.no_skip);
  const Scene& scene = loaded.file.scene;
  const bool in_hand = scene.drive && scene.drive->kind == Drive::Kind::falcon;
  const double rate =
      in_hand ? scene.falcon.value_or(FalconDrive{}).rate : 1.0 / scene.simulation.step;
  refuse_without_line(options, scene, in_hand);
  const long every = ticks_between_rows(options, rate);
  if (options.refine) { refuse_without_measure(options, loaded); }
  if (options.refine && options.subject.foreign()) {
    throw InputError("--refine with --subject: only the model refines its scene; use one");
  }
  if (options.vtk && (loaded.network() == nullptr || scene.output.frames == 0)) {
    throw InputError(options.scene.string() +
                     ": --vtk writes nodes over time; a scene with tissue and output.frames > 0 "
                     "is needed");
  }
  const std::unique_ptr<Subject> foreign =
      foreign_subject(confined(options.subject, options), loaded);
  const device::falcon::FaultScript faults = faults_of(options);
  const std::vector<std::string> files{"packets.csv",  "palpation.csv", "report.html",
                                       "summary.json", "trace.csv",     "trace.h5",
                                       "trace.xdmf",   "vtk/"};
  const std::filesystem::path folder = options.make_folder(files);
  keep_results_of_interrupted();
  const std::optional<IndexLine> before = last_run_in(folder);
  // A run that fails or is killed leaves nothing of an earlier one.
  for (const std::string& file : files) {
    if (!file.ends_with('/')) { std::filesystem::remove(folder / file); }
  }
  SampleOptions samples{
      .every = every, .extremes = every > 1, .energy_range = true, .frames = scene.output.frames};
  const NetworkProblem* network = loaded.network();
  if (network != nullptr) { samples.cells = &network->network(); }
  if (network != nullptr && (!options.no_view || loaded.simulation().plan().far)) {
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
  if (foreign != nullptr) {
    result.subject = foreign->facts();
    std::vector<double> empty;
    for (int n = 0; n < 50; ++n) { empty.push_back(foreign->round_trip()); }
    result.control = comparison::quantile(empty, 0.5);
    if (foreign->node_positions().cols() == 0) {
      samples.frames = 0;
      samples.keyframes = 0;
      samples.cells = nullptr;
    }
  }
  result.trace = roll_out(foreign != nullptr ? *foreign : loaded.subject, scene, samples, control);
  result.rate = rate;
  if (clock) { result.real_time = clock->facts(); }
  const auto provenance = scene_provenance(loaded);
  std::optional<io::WholeWrite> whole(std::in_place);
  io::write_trace_csv(folder / "trace.csv", result.trace);
  io::write_trace_hdf5(folder / "trace.h5", result.trace,
                       network != nullptr ? network->network() : SpringNetwork{},
                       provenance_with_inputs(options, loaded, provenance));
  if (network != nullptr && !result.trace.frames.position.empty()) {
    io::write_xdmf(folder / "trace.xdmf", folder / "trace.h5", result.trace, network->network());
    if (options.vtk) {
      io::write_vtk(folder / "vtk", result.trace, network->network(),
                    tool_lines(scene, network->network(), result.trace));
      if (!options.quiet) {
        std::printf("%s\n", io::printable((folder / "vtk/trace.pvd").string()).c_str());
      }
    }
  }
  whole.reset();  // what follows may take minutes
  std::vector<ErrorSource> sources = error_sources(loaded);
  if (foreign == nullptr) {
    result.warnings = loaded.warnings();
    if (network != nullptr) {
      append(result.warnings, passage_warnings(scene, network->network(), result.trace));
    }
    estimate_reduction(loaded, result.trace, sources[2], result.warnings);
    warn_of_closing_cells(result.trace, result.warnings);
  } else {
    for (ErrorSource& source : sources) { source.share.reset(); }
  }
  if (packets) { write_packets(folder, *packets); }
  const Palpation palpation = palpate_skin(loaded);
  result.trace.interrupted = result.trace.interrupted || interrupted;
  if (palpation.figure) { io::replace_file(folder / "palpation.csv", palpation.csv); }
  const std::string hash_of_trace = io::sha256_of_file(folder / "trace.h5");
  const auto write = [&](bool refined) {
    const io::WholeWrite together;
    const std::string summary =
        summary_json(loaded, result, sources, refined, hash_of_trace, palpation.csv);
    io::replace_file(folder / "summary.json", summary);
    RunReport report = report_of(options, loaded, result, palpation, sources, provenance);
    if (before) { report.changes = changes_between(*before, index_line_of_run(summary)); }
    io::replace_file(folder / "report.html", to_html(report, result.trace));
  };
  write(false);
  bool finished = !result.trace.interrupted;
  if (options.refine && finished && !result.trace.diverged) {
    finished = refine(options, loaded, result.trace, control, sources);
    warn_of_differences(sources, result.warnings);
    write(true);
  }
  tell(options, loaded, result, sources, folder);
  if (!finished) { return interrupted_code; }
  const bool held = !result.trace.diverged && result.trace.inverted_cells == 0 && !result.late();
  return held ? done : fell_short;
}

}  // namespace

void add_run(Program& program) {
  const auto [command, options] = add_command(program, "run", "simulate one scene", run_scene);
  add_scene(command, options, options.scene);
  add_verbose(command, options, "print also how the scene was stepped, and why the error is so");
  add_json(command, options, "summary.json");
  command.add_flag("--no-skip", options.no_skip,
                   "compute what the scene does not need, and every node without a reduced-order "
                   "model; the same result within rounding and the error of that model");
  command.add_flag("--refine", options.refine,
                   "estimate the error: run again at half the step and half the spacing, and where "
                   "the scene has them without reduced-order model and solver tolerance");
  command.add_flag("--no-view", options.no_view,
                   "no 3-D view in report.html, and no data recorded for it");
  command.add_flag("--real-time", options.real_time,
                   "run every tick at its time on the wall clock; exit code 1 if one is late");
  add_value(command, "--every", options.every, "S",
            "time between two rows of the trace, for long runs; ticks with events and with the "
            "largest force, pressure and depth always have a row [every tick]")
      ->check(number_range(1e-9, 1e6));
  add_value(command, "--script", options.script, "FILE",
            "faults on the Falcon's line, by time (TOML, docs/falcon.md)");
  command.add_flag("--packets", options.packets,
                   "write packets.csv: all packets on the Falcon's line");
  command.add_flag("--vtk", options.vtk,
                   "write vtk/trace.pvd: the tissue's cells and the tool over time, for ParaView");
  add_subject_options(command, options.subject);
  command.footer(integrator_help());
}

}  // namespace palpate::cli
