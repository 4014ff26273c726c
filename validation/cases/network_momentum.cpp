// SPDX-License-Identifier: MIT
/// A free network can neither make nor lose momentum.

#include <Eigen/Geometry>
#include <cmath>

#include "model/stepping/integrator.hpp"
#include "model/stepping/list_network.hpp"
#include "validation/cases/network_parts.hpp"
#include "validation/cases/network_support.hpp"

namespace palpate::networks {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

using Columns = Eigen::Map<const NodeVectors>;

/// Flying, spinning and shaking: random velocities about a mean, nothing held.
SpringNetwork free_flight(double relaxation) {
  const Block block{.nodes = {4, 4, 4}, .relaxation = relaxation};
  SpringNetwork network = block_network(block);
  displace(network, 0.1 * block.spacing, 3);
  Random random(4);
  network.initial_velocity = NodeVectors(3, network.node_count());
  for (Index i = 0; i < network.node_count(); ++i) {
    network.initial_velocity.col(i) = Vector3d(0.3, -0.2, 0.1) + Vector3d(random.vector(3, 0.1));
  }
  return network;
}

Vector3d momentum(const Eigen::VectorXd& mass, const Eigen::Ref<const Eigen::VectorXd>& v) {
  return Columns(v.data(), 3, v.size() / 3) * mass;
}

Vector3d angular_momentum(const Eigen::VectorXd& mass, const Eigen::Ref<const Eigen::VectorXd>& q,
                          const Eigen::Ref<const Eigen::VectorXd>& v) {
  Vector3d sum = Vector3d::Zero();
  for (Index i = 0; i < mass.size(); ++i) {
    sum += mass(i) * Vector3d(q.segment<3>(3 * i)).cross(Vector3d(v.segment<3>(3 * i)));
  }
  return sum;
}

struct Drift {
  double linear = 0.0;   ///< largest change over sum m |v|
  double angular = 0.0;  ///< over sum m |x| |v|
};

Drift drift_of(const SpringNetwork& network, const Motion& motion) {
  const auto& mass = network.mass;
  const double scale = mass.dot(network.initial_velocity.colwise().norm().transpose());
  const double reach = network.initial_position().colwise().norm().maxCoeff();
  const Vector3d p0 = momentum(mass, motion.velocity.col(0));
  const Vector3d l0 = angular_momentum(mass, motion.position.col(0), motion.velocity.col(0));
  Drift drift;
  for (Index n = 0; n < motion.velocity.cols(); ++n) {
    const auto q = motion.position.col(n);
    const auto v = motion.velocity.col(n);
    drift.linear = worse(drift.linear, (momentum(mass, v) - p0).norm() / scale);
    drift.angular =
        worse(drift.angular, (angular_momentum(mass, q, v) - l0).norm() / (scale * reach));
  }
  if (motion.diverged) { drift.linear = drift.angular = std::nan(""); }
  return drift;
}

void judge_momentum(const CaseContext& context, Outcome& outcome) {
  const SpringNetwork network = free_flight(1e-3);
  const double steps = context.quick ? 400.0 : 2000.0;
  const double h = 2e-5;
  Table table{.id = "momentum",
              .title = "Momentum of a free, damped network",
              .caption = "Largest change of linear and angular momentum over " + text(steps) +
                         " steps, over the sum of all nodes' shares.",
              .columns = {"scheme", "linear (1)", "angular (1)"}};
  for (const IntegratorInfo* scheme : integrators()) {
    const std::string name(scheme->name);
    const double taken = scheme->implicit ? steps / 10.0 : steps;
    const Motion motion =
        simulate(context, scene_of(name, h, taken * h), &network, {.velocity = true});
    const Drift drift = drift_of(network, motion);
    // An implicit step ends when Newton's correction is below 64 epsilon of the velocity.
    const double per_step = (scheme->implicit ? 64.0 : 4.0) * epsilon;
    outcome.judge({.name = "momentum_drift_" + name,
                   .value = drift.linear,
                   .upper = taken * per_step,
                   .bound_from = scheme->implicit ? "64 epsilon a step: where its Newton stops"
                                                  : "4 roundings of the velocity a step"});
    const bool keeps_spin =
        name == "euler-cromer" || name == "feynman-newton-printed" || name == "implicit-midpoint";
    if (keeps_spin) {
      outcome.judge({.name = "angular_drift_" + name,
                     .value = drift.angular,
                     .upper = 4.0 * taken * per_step,
                     .bound_from = "theory: x' x m v' = x x m v exactly; 4 products a step"});
    }
    table.rows.push_back({name, drift.linear, drift.angular});
  }
  outcome.tables.push_back(std::move(table));
}

/// The kernels' forces in random states.
void judge_balance(const CaseContext& context, Outcome& outcome) {
  const SpringNetwork network = candidate(context, free_flight(1e-3));
  const NetworkProblem problem(network);
  ListNetwork<double> system(problem, {}, 1e-4, true);
  Random random(5);
  double force = 0.0;
  double torque = 0.0;
  for (int state = 0; state < 20; ++state) {
    const Vector<double> q = problem.initial_position() + random.vector(problem.dof(), 1e-3);
    const Vector<double> v = random.vector(problem.dof(), 0.1);
    Vector<double> f(problem.dof());
    system.force(0.0, 0.0, q, v, f);
    const Columns forces(f.data(), 3, f.size() / 3);
    const double size = forces.colwise().norm().sum();
    force = worse(force, forces.rowwise().sum().norm() / size);
    const Vector3d about = angular_momentum(Eigen::VectorXd::Ones(f.size() / 3), q, f);
    torque = worse(torque, about.norm() / (size * q.lpNorm<Eigen::Infinity>()));
  }
  // Each of up to 26 springs of a node rounds its share once more.
  outcome.judge({.name = "internal_force_sum",
                 .value = force,
                 .upper = 26.0 * epsilon,
                 .bound_from = "Newton's third law; one rounding per spring and node"});
  outcome.judge({.name = "internal_torque_sum",
                 .value = torque,
                 .upper = 4.0 * 26.0 * epsilon,
                 .bound_from = "central forces; a few roundings per spring and node"});
}

void measure_momentum(const CaseContext& context, Outcome& outcome) {
  judge_momentum(context, outcome);
  judge_balance(context, outcome);
}

}  // namespace

std::vector<Case> momentum_cases() {
  return {{.name = "network/conservation/momentum",
           .suite = "accuracy",
           .claim = "A free network keeps its momentum to rounding, and its internal forces and "
                    "torques cancel.",
           .measure = measure_momentum,
           .weight = 0.3}};
}

}  // namespace palpate::networks
