// SPDX-License-Identifier: MIT
/// Work of the loads = change of energy + what the dampers took, for the reference exactly and for
/// each scheme to its order.

#include <algorithm>
#include <array>
#include <cmath>

#include "model/stepping/integrator.hpp"
#include "validation/cases/network_parts.hpp"
#include "validation/cases/network_support.hpp"

namespace palpate::networks {

namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double duration = 0.02;  ///< [s]

SpringNetwork loaded_network() {
  const Block block{.nodes = {3, 3, 4}, .relaxation = 5e-4};
  SpringNetwork network = block_network(block);
  hold(network, Face::z_max);
  return network;
}

Scene loaded_scene(const std::string& scheme, long ticks, int substeps) {
  Scene scene = scene_of(scheme, duration / static_cast<double>(ticks), duration, substeps);
  scene.loads = {{.face = Face::z_min,
                  .force = {4e-3, -2e-3, 8e-3},
                  .end = duration,
                  .profile = Profile::half_sine}};
  return scene;
}

/// Power of the loads less that of the dampers [W].
double power(const NetworkProblem& problem, double t, const VectorXd& q, const VectorXd& v) {
  double sum = 0.0;
  for (const Load& load : problem.loads()) {
    for (const int node : load.nodes) {
      sum += load_factor(load, t, 0.5 * duration) *
             load.force.dot(v.segment<3>(problem.coordinate(node)));
    }
  }
  const NodeVectors held = problem.network().initial_position();
  for (const Spring& s : problem.network().springs) {
    const Index a = problem.coordinate(s.a);
    const Index b = problem.coordinate(s.b);
    const auto place = [&](Index c, int node) -> Eigen::Vector3d {
      return c < 0 ? Eigen::Vector3d(held.col(node)) : Eigen::Vector3d(q.segment<3>(c));
    };
    const auto speed = [&](Index c) -> Eigen::Vector3d {
      return c < 0 ? Eigen::Vector3d::Zero() : Eigen::Vector3d(v.segment<3>(c));
    };
    const double rate = (speed(b) - speed(a)).dot((place(b, s.b) - place(a, s.a)).normalized());
    sum -= s.viscosity * rate * rate;
  }
  return sum;
}

/// Composite Boole's rule: error O(h^6).
double integral(const std::vector<double>& values, double h) {
  constexpr std::array weight{7.0, 32.0, 12.0, 32.0};
  double sum = -7.0 * (values.front() + values.back());
  for (std::size_t n = 0; n < values.size(); ++n) {
    sum += (n % 4 == 0 ? 14.0 : weight[n % 4]) * values[n];
  }
  return sum * 2.0 * h / 45.0;
}

/// |energy change + dissipation - work| over the largest energy.
double imbalance(const NetworkProblem& problem, const Eigen::MatrixXd& position,
                 const Eigen::MatrixXd& velocity) {
  const auto samples = position.cols();
  if (samples % 4 != 1 || velocity.cols() != samples) { return std::nan(""); }
  const double h = duration / static_cast<double>(samples - 1);
  std::vector<double> powers;
  double peak = 0.0;
  for (Index n = 0; n < samples; ++n) {
    const VectorXd q = position.col(n);
    const VectorXd v = velocity.col(n);
    powers.push_back(power(problem, static_cast<double>(n) * h, q, v));
    peak = worse(peak, problem.energy(q, v));
  }
  const double change = problem.energy(position.rightCols<1>(), velocity.rightCols<1>()) -
                        problem.energy(position.col(0), velocity.col(0));
  return std::abs(change - integral(powers, h)) / peak;
}

void judge_scheme(const CaseContext& context, const NetworkProblem& problem,
                  const IntegratorInfo& scheme, Figure& figure, Outcome& outcome) {
  std::vector<double> steps;
  std::vector<double> errors;
  const SpringNetwork& network = problem.network();
  for (const long ticks : {128L, 256L, 512L, 1024L, 2048L}) {
    const Motion motion = simulate(context, loaded_scene(std::string(scheme.name), ticks, 1),
                                   &network, {.velocity = true});
    steps.push_back(motion.h);
    errors.push_back(motion.diverged ? std::nan("")
                                     : imbalance(problem, motion.position, motion.velocity));
  }
  const ObservedOrder order = observed_order(steps, errors, 1e-12, 1.0);
  outcome.judge(
      {.name = "order_" + std::string(scheme.name),
       .value = order.slope,
       .lower = scheme.order_damped - 0.15,
       .bound_from = "theory: the balance closes at least as fast as the motion converges"});
  outcome.quantities.push_back(
      {.name = "imbalance_" + std::string(scheme.name), .value = errors.back()});
  figure.series.push_back(
      line(std::string(scheme.name), steps, errors, Series::Style::line_and_points));
}

void measure(const CaseContext& context, Outcome& outcome) {
  const SpringNetwork network = loaded_network();
  const NetworkProblem problem = problem_of(loaded_scene("rk4", 64, 1), network);
  constexpr long samples = 512;
  const TruthSettings settings{.tolerance = {.relative = 1e-12}};
  const Truth truth = find_truth(context, problem, instants(duration / samples, samples), settings);
  judge_truth(truth, settings, outcome);
  const double reference = imbalance(problem, truth.solution.position, truth.solution.velocity);
  outcome.judge({.name = "imbalance_reference",
                 .value = reference,
                 .upper = 1e-9,
                 .bound_from = "theory; 512 samples of Boole's rule at (omega h)^6 and the "
                               "reference's own tolerance"});
  Figure figure{.id = "imbalance",
                .title = "Energy balance under load",
                .caption =
                    "What is missing between the work of the loads, the change of energy and "
                    "the dissipation, over the largest energy; the reference is dashed.",
                .x = {.label = "step (s)", .logarithmic = true},
                .y = {.label = "imbalance (1)", .logarithmic = true}};
  for (const IntegratorInfo* scheme : integrators()) {
    if (scheme->implicit && context.quick) { continue; }
    judge_scheme(context, problem, *scheme, figure, outcome);
  }
  figure.series.push_back(line("reference", {duration / 2048, duration / 128},
                               {reference, reference}, Series::Style::dashed));
  outcome.figures.push_back(std::move(figure));
}

}  // namespace

std::vector<Case> work_cases() {
  return {{.name = "network/conservation/work",
           .suite = "accuracy",
           .claim = "The work of the loads is the change of energy plus the dissipation, for the "
                    "reference at once and for every scheme as its step falls.",
           .measure = measure,
           .weight = 1.5}};
}

}  // namespace palpate::networks
