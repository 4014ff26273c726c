// SPDX-License-Identifier: MIT
/// Seven layers against the same insertion as a hybrid differential equation, whose events are roots
/// that CVODE finds: what happens when, and the force in between.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "model/dynamics/network_builder.hpp"
#include "reference/insertion.hpp"
#include "validation/cases/tool_setting.hpp"
#include "validation/metrics.hpp"

namespace palpate::tools {

namespace {

using Kind = reference::InsertionEvent::Kind;

struct Told {
  Kind kind;
  const char* name;
};
constexpr std::array told{Told{Kind::contact, "contact"}, Told{Kind::puncture, "puncture"},
                          Told{Kind::loss_of_resistance, "loss-of-resistance"},
                          Told{Kind::dural_puncture, "dural-puncture"}};

struct Technique {
  const char* name;
  double speed;     ///< [m/s]
  double duration;  ///< [s]
  Drive::Technique technique = Drive::Technique::continuous;
};

Scene scene_of_technique(const Technique& technique) {
  Scene scene = seven_soft_layers();
  scene.drive->speed = technique.speed;
  scene.drive->technique = technique.technique;
  scene.drive->advance = 0.003;
  scene.drive->pause = 0.1;
  scene.simulation = {.duration = technique.duration, .step = 1e-3, .integrator = "velocity-verlet"};
  return scene;
}

std::vector<double> ticks_of(const Scene& scene) {
  std::vector<double> times;
  const long count = std::lround(scene.simulation.duration / scene.simulation.step);
  for (long n = 0; n <= count; ++n) {
    times.push_back(static_cast<double>(n) * scene.simulation.step);
  }
  return times;
}

/// Largest distance of an event of the model from the reference's [s]; NaN when one is missing.
double event_error(const Insertion& run, const reference::Insertion& truth,
                   std::vector<std::vector<Cell>>* rows) {
  double worst = 0.0;
  long expected = 0;
  for (const reference::InsertionEvent& event : truth.events) {
    const auto found = std::ranges::find(told, event.kind, &Told::kind);
    if (found == told.end()) { continue; }
    ++expected;
    const double time = run.time_of(found->name, event.layer);
    worst = std::isnan(time) || std::isnan(worst) ? std::nan("")
                                                  : std::max(worst, std::abs(time - event.time));
    if (rows != nullptr) {
      rows->push_back({std::string(found->name), event.layer, event.time, 1e6 * (time - event.time)});
    }
  }
  return expected == static_cast<long>(run.events.size()) ? worst : std::nan("");
}

/// Peak force of the layer in which the reference is at each tick.
std::vector<double> layer_peaks(const std::vector<std::string>& layer,
                                const reference::Insertion& truth) {
  std::map<std::string, double> peak;
  for (std::size_t n = 0; n < layer.size(); ++n) {
    double& most = peak[layer[n]];
    most = std::max(most, truth.instants[n].total);
  }
  std::vector<double> peaks;
  for (const std::string& one : layer) { peaks.push_back(peak[one]); }
  return peaks;
}

void measure_against_reference(const CaseContext& context, Outcome& outcome,
                               const Technique& technique) {
  const Scene scene = scene_of_technique(technique);
  const std::vector<double> times = ticks_of(scene);
  const reference::Insertion truth =
      reference::solve_insertion(scene, build_network(scene), times, {.relative = 1e-9});
  const Insertion run = insert_tool(context, scene);
  std::vector<std::vector<Cell>> rows;
  const double tick = scene.simulation.step;
  outcome.judge({.name = "largest_error_of_an_event",
                 .value = event_error(run, truth, &rows),
                 .unit = "s",
                 .upper = tick,
                 .bound_from = "one tick; the reference finds its events as roots to 1e-8 s"});
  Scene fine = scene;
  fine.simulation.substeps = 8 * run.substeps;
  const double finer = event_error(insert_tool(context, fine), truth, nullptr);
  outcome.judge({.name = "largest_error_of_an_event_eight_times_finer",
                 .value = finer,
                 .unit = "s",
                 .upper = 2.0 * run.h / 8.0 + 1e-7,
                 .bound_from = "theory: modes change at the ends of steps, so within two of them; "
                               "1e-7 s of the reference"});

  const std::vector<double> peaks = layer_peaks(run.layer, truth);
  double worst = 0.0;
  long compared = 0;
  std::vector<double> depth, model, exact;
  for (std::size_t n = 0; n < std::min(run.tool.size(), truth.instants.size()); ++n) {
    depth.push_back(1e3 * truth.instants[n].place);
    model.push_back(run.tool[n].forces.total);
    exact.push_back(truth.instants[n].total);
    const bool event = std::ranges::any_of(truth.events, [&](const auto& e) {
      return e.kind != Kind::knot_passed && std::abs(times[n] - e.time) <= 2.0 * tick;
    });
    if (event || peaks[n] <= 0.0) { continue; }
    const double error = std::abs(model.back() - exact.back()) / peaks[n];
    worst = std::isnan(error) ? error : std::max(worst, error);
    ++compared;
  }
  outcome.judge({.name = "largest_force_error_over_peak_of_the_layer",
                 .value = compared > 0 ? worst : std::nan(""),
                 .upper = 0.01,
                 .bound_from = "one hundredth; two ticks around each event left out, where forces "
                               "jump"});
  outcome.judge({.name = "share_of_ticks_compared",
                 .value = static_cast<double>(compared) / static_cast<double>(times.size()),
                 .lower = 0.5,
                 .bound_from = "most of the insertion lies between events"});
  outcome.tables.push_back({.id = "events",
                            .title = "Events and how far the model is off",
                            .columns = {"event", "layer", "reference (s)", "model - reference (us)"},
                            .rows = rows});
  Figure figure{.id = "force-depth",
                .title = "Force over depth",
                .caption = "The model at ticks of 1 ms over the reference with its events as roots.",
                .x = {.label = "place of the tip (mm)"},
                .y = {.label = "force (N)"}};
  figure.series = {curve("model", depth, model),
                   curve("reference", depth, exact, Series::Style::dashed)};
  outcome.figures.push_back(std::move(figure));
}

/// Before the first puncture nothing switches: there the schemes keep their orders.
void measure_order(const CaseContext& context, Outcome& outcome) {
  Scene scene = scene_of_technique({"", 0.02, 0.012});
  const std::vector<double> times = ticks_of(scene);
  const reference::Insertion truth =
      reference::solve_insertion(scene, build_network(scene), times, {.relative = 1e-12});
  std::vector<std::vector<Cell>> rows;
  for (const auto& [name, order] : {std::pair{"velocity-verlet", 2.0}, {"rk4", 4.0}}) {
    std::vector<double> steps, errors;
    scene.simulation.integrator = name;
    for (const int substeps : {25, 35, 50, 70, 100, 140}) {
      scene.simulation.substeps = substeps;
      const Insertion run = insert_tool(context, scene);
      double error = 0.0;
      for (std::size_t n = 4; n < run.tool.size(); ++n) {
        error = std::fmax(error,
                          std::abs(run.tool[n].forces.total - truth.instants[n].total));
      }
      steps.push_back(run.h);
      errors.push_back(error / truth.instants.back().total);
    }
    for (std::size_t n = 0; n < steps.size(); ++n) {
      rows.push_back({std::string(name), 1e6 * steps[n], errors[n]});
    }
    const ObservedOrder observed = observed_order(steps, errors, 2e-14);
    outcome.judge({.name = std::string("observed_order_") + name,
                   .value = observed.slope,
                   .lower = order - 0.15,
                   .upper = order + 0.15,
                   .bound_from = "theory: sticking is a smooth constraint"});
    outcome.judge({.name = std::string("rungs_") + name,
                   .value = static_cast<double>(observed.rungs),
                   .lower = 4.0,
                   .bound_from = "fewer do not make an order"});
  }
  outcome.tables.push_back({.id = "errors",
                            .title = "Largest force error before the first puncture",
                            .columns = {"integrator", "step (us)", "error / force"},
                            .rows = rows});
}

}  // namespace

std::vector<Case> reference_cases() {
  std::vector<Case> cases;
  constexpr std::array techniques{
      Technique{"continuous-20-mm-s", 0.020, 1.2}, Technique{"continuous-5-mm-s", 0.005, 4.8},
      Technique{"continuous-1-mm-s", 0.001, 11.0},
      Technique{"intermittent", 0.020, 1.9, Drive::Technique::intermittent}};
  for (const Technique& technique : techniques) {
    cases.push_back({.name = std::string("needle/reference/") + technique.name,
                     .suite = "accuracy",
                     .claim = "Events come within a tick of a reference that finds them as roots, "
                              "and the force in between within 1 % of the layer's peak.",
                     .measure = [technique](const CaseContext& context, Outcome& outcome) {
                       measure_against_reference(context, outcome, technique);
                     },
                     .quick = technique.speed > 0.01,
                     .weight = 10.0});
  }
  cases.push_back({.name = "needle/order",
                   .suite = "accuracy",
                   .claim = "Away from events an insertion converges with the order of its scheme.",
                   .measure = measure_order,
                   .weight = 4.0});
  return cases;
}

}  // namespace palpate::tools
