// SPDX-License-Identifier: MIT

#include "reference/exact_problems.hpp"

#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "reference/solution.hpp"

namespace palpate::reference {

using Eigen::VectorXd;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Returns the problem itself, or the problem that a LinearProblem was made of.
const Problem& innermost(const Problem& problem) {
  const auto* linear = dynamic_cast<const LinearProblem*>(&problem);
  return linear != nullptr ? innermost(linear->base()) : problem;
}

ShapedLoad::Shape shape_of(Profile profile) {
  switch (profile) {
    case Profile::ramp: return ShapedLoad::Shape::ramp;
    case Profile::half_sine: return ShapedLoad::Shape::half_sine;
    case Profile::constant: break;
  }
  return ShapedLoad::Shape::constant;
}

/// Returns the force before the activation of any load.
VectorXd force_without_loads(const Problem& problem, const VectorXd& q, const VectorXd& v) {
  VectorXd f(problem.dof());
  problem.force(0.0, -infinity, q, v, f);
  return f;
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
    : DerivedProblem(innermost(base)),
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
    const Oscillator& o = oscillator->oscillator();
    return {{.shape = ShapedLoad::Shape::cosine,
             .amplitude = VectorXd::Constant(1, o.drive_amplitude),
             .start = -infinity,
             .end = infinity,
             .frequency = o.drive_frequency}};
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

using Eigen::ArrayXd;
using Eigen::Index;

namespace {

/// Ramp 1 + s^2 (3 - 2 s) and its derivatives with respect to t.
struct Ramp {
  double value;
  double first;
  double second;
};

Ramp ramp(double t, double duration) {
  const double s = t / duration;
  return {1.0 + s * s * (3.0 - 2.0 * s), 6.0 * s * (1.0 - s) / duration,
          (6.0 - 12.0 * s) / (duration * duration)};
}

}  // namespace

ManufacturedProblem::ManufacturedProblem(const Problem& base, const ManufacturedMotion& motion)
    : DerivedProblem(base),
      motion_(motion),
      origin_(base.initial_position()),
      amplitude_(base.dof()),
      frequency_(base.dof()),
      phase_(base.dof()) {
  for (Index i = 0; i < base.dof(); ++i) {
    // Multiples of the golden ratio, so that the motions of all coordinates differ.
    const double part = std::fmod(static_cast<double>(i) * std::numbers::phi, 1.0);
    amplitude_(i) = motion.amplitude * (0.5 + 0.5 * part);
    frequency_(i) = motion.frequency * (1.0 - 0.5 * part);
    phase_(i) = 2.0 * std::numbers::pi * part;
  }
}

VectorXd ManufacturedProblem::exact_position(double t) const {
  const Ramp r = ramp(t, motion_.duration);
  return origin_ + amplitude_ * r.value * (frequency_ * t + phase_).sin();
}

VectorXd ManufacturedProblem::exact_velocity(double t) const {
  const Ramp r = ramp(t, motion_.duration);
  const ArrayXd angle = frequency_ * t + phase_;
  return amplitude_ * (r.first * angle.sin() + r.value * frequency_ * angle.cos());
}

VectorXd ManufacturedProblem::exact_acceleration(double t) const {
  const Ramp r = ramp(t, motion_.duration);
  const ArrayXd angle = frequency_ * t + phase_;
  return amplitude_ * ((r.second - r.value * frequency_.square()) * angle.sin() +
                       2.0 * r.first * frequency_ * angle.cos());
}

void ManufacturedProblem::force(double t, double gate, const Eigen::Ref<const VectorXd>& q,
                                const Eigen::Ref<const VectorXd>& v, Eigen::Ref<VectorXd> f) const {
  VectorXd along(dof());
  base_->force(t, gate, exact_position(t), exact_velocity(t), along);
  base_->force(t, gate, q, v, f);
  f += mass().cwiseProduct(exact_acceleration(t)) - along;
}

double ManufacturedProblem::shortest_feature() const {
  return std::min(base_->shortest_feature(), 2.0 * std::numbers::pi / motion_.frequency);
}

}  // namespace palpate::reference
