// SPDX-License-Identifier: MIT
#include "reference/linear_problem.hpp"

#include <limits>

#include "reference/solution.hpp"

namespace palpate::reference {

using Eigen::VectorXd;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// The problem itself, or what a LinearProblem was made of.
const Problem& innermost(const Problem& problem) {
  const auto* linear = dynamic_cast<const LinearProblem*>(&problem);
  return linear != nullptr ? innermost(linear->base()) : problem;
}

ShapedLoad::Shape shape_of(Profile profile) {
  switch (profile) {
    case Profile::ramp:
      return ShapedLoad::Shape::ramp;
    case Profile::half_sine:
      return ShapedLoad::Shape::half_sine;
    case Profile::constant:
      break;
  }
  return ShapedLoad::Shape::constant;
}

/// A gate before every load: only what is always there acts.
VectorXd force_without_loads(const Problem& problem, const VectorXd& q, const VectorXd& v) {
  VectorXd f(problem.dof());
  problem.force(0.0, -infinity, q, v, f);
  return f;
}

ShapedLoad drive_of(const Oscillator& oscillator) {
  return {.shape = ShapedLoad::Shape::cosine,
          .amplitude = VectorXd::Constant(1, oscillator.drive_amplitude),
          .start = -infinity,
          .end = infinity,
          .frequency = oscillator.drive_frequency};
}

}  // namespace

VectorXd rest_coordinates(const Problem& problem) {
  const Problem& base = innermost(problem);
  if (const auto* network = dynamic_cast<const NetworkProblem*>(&base)) {
    VectorXd rest(network->dof());
    for (const int i : network->free_nodes()) {
      rest.segment<3>(network->coordinate(i)) = network->network().rest_position.col(i);
    }
    return rest;
  }
  if (dynamic_cast<const OscillatorProblem*>(&base) != nullptr) { return VectorXd::Zero(1); }
  return base.initial_position();
}

LinearProblem::LinearProblem(const Problem& base)
    : base_(&innermost(base)),
      rest_(rest_coordinates(base)),
      still_(VectorXd::Zero(base.dof())),
      unloaded_force_(dynamic_cast<const OscillatorProblem*>(base_) != nullptr
                          ? VectorXd::Zero(1)
                          : force_without_loads(*base_, rest_, still_)) {
  base_->jacobian(rest_, still_, stiffness_, damping_);
}

void LinearProblem::force(double t, double gate, const Eigen::Ref<const VectorXd>& q,
                          const Eigen::Ref<const VectorXd>& v, Eigen::Ref<VectorXd> f) const {
  base_->force(t, gate, rest_, still_, f);
  f.noalias() -= stiffness_ * (q - rest_);
  f.noalias() -= damping_ * v;
}

void LinearProblem::jacobian(const Eigen::Ref<const VectorXd>& /*q*/,
                             const Eigen::Ref<const VectorXd>& /*v*/,
                             Eigen::SparseMatrix<double>& stiffness,
                             Eigen::SparseMatrix<double>& damping) const {
  stiffness = stiffness_;
  damping = damping_;
}

double LinearProblem::energy(const Eigen::Ref<const VectorXd>& q,
                             const Eigen::Ref<const VectorXd>& v) const {
  const VectorXd u = q - rest_;
  return 0.5 * v.cwiseAbs2().dot(mass()) + 0.5 * u.dot(stiffness_ * u) - unloaded_force_.dot(u);
}

std::vector<ShapedLoad> shaped_loads(const LinearProblem& problem) {
  const Problem& base = problem.base();
  if (const auto* oscillator = dynamic_cast<const OscillatorProblem*>(&base)) {
    return {drive_of(oscillator->oscillator())};
  }
  const auto* network = dynamic_cast<const NetworkProblem*>(&base);
  if (network == nullptr) {
    throw SolverError("modal: the loads of this kind of problem are not known in closed form");
  }
  std::vector<ShapedLoad> shaped;
  shaped.push_back(
      {.amplitude = force_without_loads(base, problem.rest(), VectorXd::Zero(base.dof())),
       .start = -infinity,
       .end = infinity});
  for (const Load& load : network->loads()) {
    ShapedLoad item{.shape = shape_of(load.profile),
                    .amplitude = VectorXd::Zero(base.dof()),
                    .start = load.start,
                    .end = load.end};
    for (const int node : load.nodes) {
      const Eigen::Index c = network->coordinate(node);
      if (c >= 0) { item.amplitude.segment<3>(c) += load.force; }
    }
    shaped.push_back(std::move(item));
  }
  return shaped;
}

}  // namespace palpate::reference
