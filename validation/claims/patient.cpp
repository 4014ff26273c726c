// SPDX-License-Identifier: MIT
/// Network of a patient: 4,650 nodes and 49,727 springs sampled from a lumbar MRI, loaded on the
/// middle of its posterior plane for 50 ms and released.

#include <algorithm>
#include <cmath>

#include "reference/solver_cross_check.hpp"
#include "validation/claims/groups.hpp"
#include "validation/signal.hpp"

namespace palpate {

namespace {

constexpr int pressed_node = 2324;
constexpr double tick = 1e-3;      // s
constexpr double duration = 0.1;   // s
constexpr double released = 0.05;  // s
constexpr double demanded_digits = 8.0;

Load press() {
  Load load;
  load.nodes = {pressed_node};
  load.force = {0.0, 0.0, 0.02};  // inwards
  load.end = released;
  return load;
}

/// One scheme with the substeps a tick at which it is shown. Every explicit scheme is inside its
/// stability limit there; the numbers double, so that orders can be read off;
/// implicit Euler, slow and rough here, is shown once.
struct Rungs {
  const char* scheme;
  double order;  ///< of a damped network, from the theory of the scheme
  std::vector<int> substeps;
};

const std::vector<Rungs>& ladder() {
  static const std::vector<Rungs> rungs{{"euler", 1.0, {20, 40, 80}},
                                        {"euler-cromer", 1.0, {20, 40, 80}},
                                        {"feynman-newton", 1.0, {20, 40, 80}},
                                        {"feynman-newton-printed", 1.0, {20, 40, 80}},
                                        {"leapfrog", 2.0, {10, 20}},
                                        {"velocity-verlet", 2.0, {20, 40, 80}},
                                        {"rk4", 4.0, {16, 32, 64}},
                                        {"implicit-euler", 1.0, {1}},
                                        {"implicit-midpoint", 2.0, {1, 2}}};
  return rungs;
}

std::vector<double> ticks() {
  std::vector<double> times;
  for (int n = 0; n <= static_cast<int>(std::lround(duration / tick)); ++n) {
    times.push_back(n * tick);
  }
  return times;
}

reference::Reference references(const CaseContext& context, const NetworkProblem& problem) {
  using reference::solver_named;
  return reference::establish(
      problem, ticks(), {.relative = 1e-11},
      {solver_named("arkode-fehlberg-7-8"), solver_named("cvode-adams"), solver_named("gsl-rk8pd")},
      {.demanded_digits = demanded_digits, .cache = context.cache});
}

void judge_references(const reference::Reference& truth, Outcome& outcome) {
  outcome.judge({.name = "digits to which the references agree, at every stored instant",
                 .value = truth.agreed_digits,
                 .lower = demanded_digits,
                 .bound_from = "two families of solvers"});
  outcome.judge({.name = "references trustworthy",
                 .value = truth.trustworthy ? 1.0 : 0.0,
                 .lower = 1.0,
                 .bound_from = "agreement, ladder of tolerances, steps" +
                               (truth.reason.empty() ? "" : ": " + truth.reason)});
  outcome.judge({.name = "digits of velocity to which the references agree",
                 .value = truth.agreed_velocity_digits});
  for (const std::string& note : truth.notes) { outcome.notes.push_back(note); }
  outcome.timings.push_back({truth.solution.method, truth.solution.seconds});
  for (const auto& other : truth.second_opinions) {
    outcome.timings.push_back({other.method, other.seconds});
  }
}

/// Result of one scheme at one number of substeps.
struct Shown {
  const Rungs* rungs;
  int substeps;
  Trace motion;
  TrajectoryError error;
};

Shown show(const CaseContext& context, const SpringNetwork& network, const Rungs& rungs,
           int substeps, const Trace& truth) {
  Scene scene = scene_of(rungs.scheme, tick, duration, substeps);
  scene.loads = {press()};
  Shown shown{&rungs, substeps, roll_out(context, scene, &network, {.position = true}), {}};
  shown.error = trajectory_error(shown.motion.position, truth.position, truth.position.col(0));
  return shown;
}

/// Order between the two finest rungs of each scheme, and the error itself where theory bounds it.
void judge_scheme(const std::vector<Shown>& all, const Rungs& rungs, double floor,
                  Outcome& outcome) {
  std::vector<const Shown*> mine;
  for (const Shown& each : all) {
    if (each.rungs == &rungs) { mine.push_back(&each); }
  }
  const Shown& fine = *mine.back();
  const std::string name = rungs.scheme;
  const bool high_order = rungs.order >= 4.0;
  outcome.judge({.name = "largest error of " + name + ", finest step",
                 .value = fine.error.maximum,
                 .unit = "of peak",
                 .upper = high_order ? 1e-4 : unbounded,
                 .bound_from = high_order ? "asked of order four at omega_max h = 0.15" : ""});
  if (mine.size() < 2) { return; }
  const Shown& coarse = **(mine.end() - 2);
  const double order = std::log(coarse.error.maximum / fine.error.maximum) /
                       std::log(static_cast<double>(fine.substeps) / coarse.substeps);
  const bool at_floor = fine.error.maximum < 100.0 * floor;
  if (at_floor) {
    outcome.notes.push_back("The order of " + name +
                            " is not judged: its error is below a hundred times the floor of the "
                            "references.");
  }
  outcome.judge({.name = "order of " + name + " between its two finest steps",
                 .value = order,
                 .lower = at_floor ? -unbounded : rungs.order - 0.3,
                 .upper = at_floor ? unbounded : rungs.order + 0.3,
                 .bound_from = at_floor ? "" : "theory, two rungs"});
}

Table table_of(const std::vector<Shown>& all) {
  Table table{.id = "schemes",
              .title = "Every integrator on the patient's network",
              .caption =
                  "Errors are over all nodes and ticks, relative to the peak displacement; "
                  "evaluations are of the force.",
              .columns = {"integrator", "substeps a tick", "h (s)", "largest error (1)",
                          "L2 error (1)", "steps (1)"}};
  for (const Shown& each : all) {
    table.rows.push_back({std::string(each.rungs->scheme), static_cast<double>(each.substeps),
                          each.motion.h, each.error.maximum, each.error.l2,
                          static_cast<double>(each.motion.steps)});
  }
  return table;
}

Figure error_figure(const std::vector<Shown>& all, double floor, bool over_cost) {
  Figure figure{
      .id = over_cost ? "error-over-cost" : "error-over-step",
      .title = over_cost ? "Error against run time" : "Error against step",
      .caption = over_cost
                     ? "What each digit costs on this machine; left and below is better."
                     : "Each scheme's error falls with its order towards the references' floor.",
      .x = {.label = over_cost ? "wall time (s)" : "step h (s)", .logarithmic = true},
      .y = {.label = "largest error (of peak displacement)", .logarithmic = true},
      .timing = over_cost};
  double least = unbounded;
  double most = 0.0;
  for (const Rungs& rungs : ladder()) {
    Series series{.label = rungs.scheme, .style = Series::Style::line_and_points};
    for (const Shown& each : all) {
      if (each.rungs != &rungs) { continue; }
      const double x = over_cost ? each.motion.seconds : each.motion.h;
      series.x.push_back(x);
      series.y.push_back(each.error.maximum);
      least = std::min(least, x);
      most = std::max(most, x);
    }
    figure.series.push_back(std::move(series));
  }
  figure.series.push_back({.label = "floor of the references",
                           .style = Series::Style::dashed,
                           .x = {least, most},
                           .y = {floor, floor}});
  return figure;
}

Figure motion_figure(const NetworkProblem& problem, const std::vector<Shown>& all,
                     const Trace& truth) {
  const Eigen::Index z = problem.coordinate(pressed_node) + 2;
  Figure figure{.id = "pressed-node",
                .title = "The pressed node",
                .caption =
                    "Inward displacement under 0.02 N for 50 ms and free afterwards: the "
                    "reference, and the coarsest run of three schemes.",
                .x = {.label = "time (s)"},
                .y = {.label = "displacement along z (m)"}};
  const auto add = [&](const std::string& label, const Eigen::MatrixXd& position,
                       Series::Style style) {
    Series series{.label = label, .style = style};
    for (Eigen::Index n = 0; n < position.cols(); ++n) {
      series.x.push_back(truth.time[static_cast<std::size_t>(n)]);
      series.y.push_back(position(z, n) - truth.position(z, 0));
    }
    figure.series.push_back(std::move(series));
  };
  add("reference", truth.position, Series::Style::line);
  for (const char* scheme : {"euler-cromer", "rk4", "implicit-euler"}) {
    const auto found = std::ranges::find_if(
        all, [&](const Shown& each) { return each.rungs->scheme == std::string_view(scheme); });
    add(scheme, found->motion.position, Series::Style::dashed);
  }
  return figure;
}

Figure floor_figure(const reference::Reference& truth) {
  Figure figure{.id = "floor",
                .title = "How well the references agree",
                .caption = "Largest disagreement of the solver families at each stored instant.",
                .x = {.label = "time (s)"},
                .y = {.label = "disagreement (of peak)", .logarithmic = true}};
  figure.series = {{.label = "position", .x = truth.solution.time, .y = truth.position_floor},
                   {.label = "velocity", .x = truth.solution.time, .y = truth.velocity_floor}};
  return figure;
}

void measure_lumbar(const CaseContext& context, Outcome& outcome) {
  const auto network =
      context.outside_network ? context.outside_network("lumbar_network") : std::nullopt;
  if (!network) {
    outcome.skip(
        "the data set lumbar_network is absent (--data DIR or PALPATE_DATA names its folder)");
    return;
  }
  const NetworkProblem problem(*network, {press()});
  const reference::Reference truth = references(context, problem);
  judge_references(truth, outcome);
  const double floor = std::ranges::max(truth.position_floor);
  std::vector<Shown> all;
  for (const Rungs& rungs : ladder()) {
    for (const int substeps : rungs.substeps) {
      all.push_back(show(context, *network, rungs, substeps, truth.solution));
      const Shown& last = all.back();
      outcome.timings.push_back(
          {std::string(rungs.scheme) + ", " + std::to_string(substeps) + " substeps",
           last.motion.seconds});
    }
    judge_scheme(all, rungs, floor, outcome);
  }
  outcome.judge({.name = "peak displacement",
                 .value = reference::peak_displacement(truth.solution.position),
                 .unit = "m"});
  outcome.tables.push_back(table_of(all));
  outcome.figures = {motion_figure(problem, all, truth.solution), error_figure(all, floor, false),
                     error_figure(all, floor, true), floor_figure(truth)};
}

}  // namespace

std::vector<Case> patient_cases() {
  std::vector<Case> cases = patient_tissue_cases();
  cases.push_back(
      {.name = "patient/lumbar",
       .suite = "accuracy",
       .claim = "On a network sampled from a patient's MRI, pressed and let go, every scheme "
                "converges at its order to what independent solvers agree on",
       .measure = measure_lumbar,
       .quick = false,
       .weight = 100.0});
  return cases;
}

}  // namespace palpate
