// SPDX-License-Identifier: MIT
#include "reference/manufactured.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate::reference {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// 1 + s^2 (3 - 2 s) and its derivatives with respect to t.
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
    : base_(&base),
      motion_(motion),
      origin_(base.initial_position()),
      amplitude_(base.dof()),
      frequency_(base.dof()),
      phase_(base.dof()) {
  for (Index i = 0; i < base.dof(); ++i) {
    // Multiples of the golden ratio: neighbours differ and no two coordinates move alike.
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
