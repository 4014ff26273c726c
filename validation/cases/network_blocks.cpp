// SPDX-License-Identifier: MIT
/// The paper's Figs. 13-15: blocks of tissue under every scheme, against references on which two
/// families of solvers agree.

#include "validation/cases/network_blocks.hpp"

#include <algorithm>
#include <cmath>

#include "model/stepping/stability.hpp"
#include "validation/cases/network_parts.hpp"

namespace palpate::networks {

namespace {

using Eigen::Index;

/// Coarsest substeps whose step is below half of the scheme's limit (an eighth where it takes the
/// whole limit to lose the energy that it makes), then halves.
std::vector<int> ladder(const CaseContext& context, const BlockStudy& study,
                        const IntegratorInfo& scheme, const SpectralBounds& bounds) {
  int first = study.implicit_substeps;
  int rungs = study.implicit_rungs;
  if (!scheme.implicit) {
    const double share = scheme.name == "euler" ? 0.125 : 0.5;
    const double wanted = study.scene.simulation.step / (share * stable_step(scheme, bounds));
    first = 1;
    while (first < wanted) { first *= 2; }
    rungs = context.quick ? 2 : 3;
  }
  std::vector<int> substeps;
  for (int rung = 0; rung < rungs; ++rung) { substeps.push_back(first << rung); }
  return substeps;
}

struct SchemeErrors {
  std::vector<double> steps{};  ///< [s]
  std::vector<double> maximum{};
  std::vector<double> l2{};
};

/// Every rung of one scheme.
SchemeErrors run_scheme(const CaseContext& context, const BlockStudy& study, const Truth& truth,
                        const IntegratorInfo& scheme, const std::vector<int>& rungs, Table& table,
                        Outcome& outcome) {
  SchemeErrors errors;
  for (const int substeps : rungs) {
    Scene scene = study.scene;
    scene.simulation.integrator = std::string(scheme.name);
    scene.simulation.substeps = substeps;
    const Motion motion = simulate(context, scene, &study.network);
    const TrajectoryError error = distance(motion, truth.solution);
    errors.steps.push_back(scene.simulation.step / substeps);
    errors.maximum.push_back(error.maximum);
    errors.l2.push_back(error.l2);
    table.rows.push_back({std::string(scheme.name), 1e3 * errors.steps.back(), error.maximum,
                          error.l2, error.final,
                          static_cast<double>(motion.steps * scheme.evaluations)});
    outcome.timings.push_back(
        {.name = std::string(scheme.name) + " at " + text(1e3 * errors.steps.back()) + " ms",
         .value = motion.seconds});
  }
  return errors;
}

/// Order over the finest halving of the step that the reference resolves: both errors a hundred
/// times its floor. NaN when there is none.
double resolved_order(const std::vector<double>& errors, double floor) {
  for (std::size_t n = errors.size(); n > 1; --n) {
    const double coarse = errors[n - 2];
    const double fine = errors[n - 1];
    if (std::isnan(fine) || fine > 100.0 * floor) { return std::log2(coarse / fine); }
  }
  return std::nan("");
}

void judge_scheme(const IntegratorInfo& scheme, const SchemeErrors& errors, const Truth& truth,
                  Outcome& outcome) {
  const std::string name(scheme.name);
  const auto order = static_cast<double>(scheme.order_damped);
  const std::string why =
      "theory: halving the step divides the error by 2^order, to the next term "
      "of the expansion";
  outcome.judge({.name = "order_maximum_" + name,
                 .value = resolved_order(errors.maximum, truth.worst_floor),
                 .lower = order - 0.3,
                 .upper = order + 0.3,
                 .bound_from = why});
  outcome.judge({.name = "order_l2_" + name,
                 .value = resolved_order(errors.l2, truth.l2_floor),
                 .lower = order - 0.3,
                 .upper = order + 0.3,
                 .bound_from = why});
  outcome.quantities.push_back({.name = "maximum_error_" + name, .value = errors.maximum.back()});
  outcome.quantities.push_back({.name = "l2_error_" + name, .value = errors.l2.back()});
}

Table empty_table(const BlockStudy& study) {
  return {.id = "errors",
          .title = "Errors on " + study.what,
          .caption =
              "Error of every scheme at its steps, over the peak displacement (largest, "
              "last) and over the root mean square of the motion; implicit schemes "
              "evaluate forces once per Newton iteration, counted as one a step.",
          .columns = {"scheme", "step (ms)", "largest error (1)", "L2 error (1)",
                      "error at the end (1)", "force evaluations"}};
}

void judge_schemes(const CaseContext& context, const BlockStudy& study, const Truth& truth,
                   const SpectralBounds& bounds, Outcome& outcome) {
  Table table = empty_table(study);
  Figure figure{.id = "error",
                .title = "Error against step on " + study.what,
                .caption =
                    "Every scheme falls with its order towards the floor of the reference "
                    "(dashed).",
                .x = {.label = "step (s)", .logarithmic = true},
                .y = {.label = "largest error / peak", .logarithmic = true}};
  double coarsest = 0.0;
  double finest = study.scene.simulation.step;
  for (const IntegratorInfo* scheme : integrators()) {
    const std::vector<int> rungs = ladder(context, study, *scheme, bounds);
    if (rungs.empty()) {
      outcome.notes.push_back("Quick form: " + std::string(scheme->name) + " not run here.");
      continue;
    }
    const SchemeErrors errors = run_scheme(context, study, truth, *scheme, rungs, table, outcome);
    judge_scheme(*scheme, errors, truth, outcome);
    coarsest = std::max(coarsest, errors.steps.front());
    finest = std::min(finest, errors.steps.back());
    figure.series.push_back(line(std::string(scheme->name), errors.steps, errors.maximum,
                                 Series::Style::line_and_points));
  }
  figure.series.push_back(line("floor of the reference", {finest, coarsest},
                               {truth.worst_floor, truth.worst_floor}, Series::Style::dashed));
  outcome.tables.push_back(std::move(table));
  outcome.figures.push_back(std::move(figure));
}

Figure motion_figure(const CaseContext& context, const BlockStudy& study,
                     const NetworkProblem& problem, const Truth& truth) {
  Figure figure{.id = "displacement",
                .title = "Displacement of the loaded node of " + study.what,
                .caption =
                    "Depth of the node under the load over time: the reference, and schemes "
                    "at the tick length divided so that each is stable.",
                .x = {.label = "time (ms)"},
                .y = {.label = "displacement along z (mm)"}};
  const Index c = problem.coordinate(study.probe) + 2;
  const auto shown = [&](const std::vector<double>& time, const Eigen::MatrixXd& position,
                         const std::string& label, Series::Style style) {
    Series series{.label = label, .style = style};
    for (std::size_t n = 0; n < time.size(); ++n) {
      series.x.push_back(1e3 * time[n]);
      series.y.push_back(1e3 * (position(c, static_cast<Index>(n)) - position(c, 0)));
    }
    figure.series.push_back(std::move(series));
  };
  shown(truth.solution.time, truth.solution.position, "reference", Series::Style::dashed);
  const SpectralBounds bounds = spectral_bounds(problem);
  for (const char* name : {"euler-cromer", "velocity-verlet"}) {
    Scene scene = study.scene;
    scene.simulation.integrator = name;
    scene.simulation.substeps = ladder(context, study, *find_integrator(name), bounds).front();
    const Motion motion = simulate(context, scene, &study.network);
    shown(motion.time, motion.position, name, Series::Style::line);
  }
  return figure;
}

/// Size of the displacement in the middle plane when the probe is furthest away.
Figure section_figure(const BlockStudy& study, const NetworkProblem& problem, const Truth& truth) {
  const Eigen::MatrixXd& q = truth.solution.position;
  const Index c = problem.coordinate(study.probe) + 2;
  Index peak = 0;
  (q.row(c).array() - q(c, 0)).abs().maxCoeff(&peak);
  HeatMap map{.label = "displacement (mm)"};
  const auto& nodes = study.shape.nodes;
  for (int i = 0; i < nodes[0]; ++i) { map.x.push_back(1e3 * study.shape.position(i, 0, 0).x()); }
  for (int l = 0; l < nodes[2]; ++l) {
    map.y.push_back(1e3 * study.shape.position(0, 0, l).z());
    for (int i = 0; i < nodes[0]; ++i) {
      const Index first = problem.coordinate(study.shape.index(i, nodes[1] / 2, l));
      const double moved =
          first < 0 ? 0.0 : (q.col(peak).segment<3>(first) - q.col(0).segment<3>(first)).norm();
      map.z.push_back(1e3 * moved);
    }
  }
  Figure figure{.id = "section",
                .title = "Middle section of " + study.what,
                .caption =
                    "Size of the displacement in the middle plane when the loaded node is "
                    "furthest from rest, from the reference.",
                .x = {.label = "x (mm)"},
                .y = {.label = "z (mm)"},
                .square = true};
  figure.heat_map = std::move(map);
  return figure;
}

void measure_cube(const CaseContext& context, Outcome& outcome) {
  const BlockStudy study = cube_study(context.quick);
  const Truth truth = judge_block(context, study, outcome);
  const NetworkProblem problem = problem_of(study.scene, study.network);
  const Index c = problem.coordinate(study.probe) + 2;
  const Eigen::MatrixXd& q = truth.solution.position;
  outcome.judge(
      {.name = "reference_tip",
       .value = q(c, q.cols() - 1) - q(c, 0),
       .unit = "m",
       .lower = 5.7313150e-4 * (1.0 - 2e-8),
       .upper = 5.7313150e-4 * (1.0 + 2e-8),
       .bound_from = "four outside solvers: 5.7313150e-4 m, to 1e-8 and its own rounding"});
  const auto tip = [&](const char* scheme, double expected, const char* who) {
    Scene scene = study.scene;
    scene.simulation.integrator = scheme;
    const Motion motion = simulate(context, scene, &study.network);
    const Index last = motion.position.cols() - 1;
    outcome.judge(
        {.name = std::string("tip_at_1_ms_") + scheme,
         .value = motion.diverged ? std::nan("") : motion.position(c, last) - motion.position(c, 0),
         .unit = "m",
         .lower = expected * (1.0 - 1e-9),
         .upper = expected * (1.0 + 1e-9),
         .bound_from = who});
  };
  tip("euler-cromer", 5.733796333e-4, "four other programs with this scheme, equal to ten digits");
  tip("rk4", 5.731306973e-4, "three other programs with this scheme, equal to ten digits");
}

}  // namespace

Truth judge_block(const CaseContext& context, const BlockStudy& study, Outcome& outcome) {
  const NetworkProblem problem = problem_of(study.scene, study.network);
  const double tick = study.scene.simulation.step;
  const long ticks = std::lround(study.scene.simulation.duration / tick);
  const Truth truth = find_truth(context, problem, instants(tick, ticks), study.settings);
  judge_truth(truth, study.settings, outcome);
  judge_schemes(context, study, truth, spectral_bounds(problem), outcome);
  outcome.figures.push_back(motion_figure(context, study, problem, truth));
  outcome.figures.push_back(section_figure(study, problem, truth));
  return truth;
}

std::vector<Case> block_cases() {
  return {{.name = "network/cube",
           .suite = "accuracy",
           .claim = "On a cube of 1000 masses every scheme converges to an independent reference "
                    "with its order, and stands where other programs stand.",
           .measure = measure_cube,
           .weight = 10.0},
          {.name = "network/seven-layers",
           .suite = "accuracy",
           .claim = "On seven layers from skin to dura every scheme converges to an independent "
                    "reference with its order.",
           .measure =
               [](const CaseContext& context, Outcome& outcome) {
                 judge_block(context, seven_layer_study(context.quick), outcome);
               },
           .weight = 10.0},
          {.name = "network/heterogeneous",
           .suite = "accuracy",
           .claim = "On a block whose springs and masses all differ every scheme converges to an "
                    "independent reference with its order.",
           .measure =
               [](const CaseContext& context, Outcome& outcome) {
                 judge_block(context, heterogeneous_study(context.quick), outcome);
               },
           .weight = 5.0}};
}

}  // namespace palpate::networks
