// SPDX-License-Identifier: MIT
#include "validation/cases/gate_sample.hpp"

#include <algorithm>

#include "reference/cvode.hpp"
#include "validation/gate/approval.hpp"

namespace palpate::gating {

namespace {

constexpr double step = 2e-4;  ///< [s]
constexpr long steps = 600;
constexpr int instants_of_nodes = 6;
constexpr int orders = 8;  ///< of summation, that tell the spread

Figure path_figure(const Motion& motion, int probe) {
  return {.id = "path",
          .title = "Path of the pushed node",
          .x = {.label = "time (s)"},
          .y = {.label = "position along z (m)"},
          .series = {networks::line("node", motion.time, networks::row(motion.position, 3 * probe + 2))}};
}

Figure node_figure(const Motion& motion) {
  Figure figure{.id = "nodes",
                .title = "How far every node has moved",
                .x = {.label = "coordinate (1)"},
                .y = {.label = "displacement (m)"}};
  for (int n = 1; n <= instants_of_nodes; ++n) {
    const Eigen::Index at = (motion.position.cols() - 1) * n / instants_of_nodes;
    const Eigen::VectorXd moved = motion.position.col(at) - motion.position.col(0);
    Series series{.label = "instant " + std::to_string(n), .style = Series::Style::points};
    for (Eigen::Index i = 0; i < moved.size(); ++i) {
      series.x.push_back(static_cast<double>(i));
      series.y.push_back(moved(i));
    }
    figure.series.push_back(std::move(series));
  }
  return figure;
}

}  // namespace

Study block_study(bool loaded) {
  const networks::Block block{.relaxation = 2e-4};
  Study study{.network = networks::block_network(block)};
  networks::hold(study.network, Face::z_max);
  study.scene = scene_of("velocity-verlet", step, steps * step);
  study.probe = 5;
  study.scene.loads = {
      {.nodes = {study.probe}, .force = {0.0, 2e-3, 8e-3}, .end = 0.04, .profile = Profile::half_sine}};
  Scene known = study.scene;
  if (!loaded) { known.loads.clear(); }
  const NetworkProblem problem = networks::problem_of(known, study.network);
  study.truth = reference::solve_cvode_adams(problem, networks::instants(step, steps), {});
  return study;
}

Outcome outcome_of(const CaseContext& context, const Study& study) {
  const Motion motion = simulate(context, study.scene, &study.network, {.energy = true});
  Outcome outcome{.name = "block", .suite = "accuracy", .claim = "A pushed block moves as its equations say."};
  const TrajectoryError error = networks::distance(motion, study.truth);
  outcome.judge({.name = "largest_error", .value = error.maximum, .upper = 0.05, .bound_from = "of a sample"});
  outcome.judge({.name = "final_energy", .value = motion.energy.back(), .unit = "J"});
  outcome.judge({.name = "largest_energy", .value = *std::ranges::max_element(motion.energy), .unit = "J"});
  outcome.judge({.name = "work", .value = static_cast<double>(motion.steps), .unit = "evaluations"});
  outcome.figures = {path_figure(motion, study.probe), node_figure(motion)};
  conclude(outcome);
  return outcome;
}

CaseContext in_order(CaseContext context, std::uint64_t seed) {
  context.order = seed;
  return context;
}

gate::Baseline accepted(const CaseContext& context, const Study& study) {
  gate::Acceptance acceptance{.reason = "sample", .outcomes = {outcome_of(context, study)}};
  for (int n = 1; n <= orders; ++n) {
    acceptance.variants.push_back({outcome_of(in_order(context, static_cast<std::uint64_t>(n)), study)});
  }
  return gate::accept({}, acceptance);
}

}  // namespace palpate::gating
