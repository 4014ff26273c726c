// SPDX-License-Identifier: MIT
#include "reference/first_order.hpp"

#include "reference/solution.hpp"

namespace palpate::reference {

using Eigen::Index;
using Eigen::VectorXd;
using ConstVectorMap = Eigen::Map<const VectorXd>;
using VectorMap = Eigen::Map<VectorXd>;

FirstOrderSystem::FirstOrderSystem(const Problem& problem)
    : problem_(&problem),
      origin_(problem.initial_position()),
      inverse_mass_(problem.mass().cwiseInverse()),
      position_(origin_) {}

void FirstOrderSystem::initial_state(double* y) const {
  VectorMap(y, dof()).setZero();
  VectorMap(y + dof(), dof()) = problem_->initial_velocity();
}

bool FirstOrderSystem::derivative(double t, const double* y, double* dy) {
  ++evaluations_;
  const ConstVectorMap velocity(y + dof(), dof());
  VectorMap acceleration(dy + dof(), dof());
  position_ = origin_ + ConstVectorMap(y, dof());
  problem_->force(t, gate_, position_, velocity, acceleration);
  acceleration.array() *= inverse_mass_.array();
  VectorMap(dy, dof()) = velocity;
  return VectorMap(dy, size()).allFinite();
}

FirstOrderJacobian::FirstOrderJacobian(const FirstOrderSystem& system)
    : system_(&system), inverse_mass_(system.problem().mass().cwiseInverse()) {
  std::vector<double> y(static_cast<std::size_t>(system.size()));
  system.initial_state(y.data());
  evaluate(y.data());
  const Index n = system.dof();
  const auto add = [this](Index row, double value) {
    rows_.push_back(row);
    values_.push_back(value);
    return values_.size() - 1;
  };
  using Entry = Eigen::SparseMatrix<double>::InnerIterator;
  for (Index j = 0; j < n; ++j) {
    column_starts_.push_back(static_cast<Index>(rows_.size()));
    add(j, 0.0);
    for (Entry k(stiffness_, j); k; ++k) { stiffness_slots_.push_back(add(n + k.row(), 0.0)); }
  }
  for (Index j = 0; j < n; ++j) {
    column_starts_.push_back(static_cast<Index>(rows_.size()));
    add(j, 1.0);
    bool has_diagonal = false;
    for (Entry c(damping_, j); c; ++c) {
      has_diagonal = has_diagonal || c.row() == j;
      damping_slots_.push_back(add(n + c.row(), 0.0));
    }
    if (!has_diagonal) { add(n + j, 0.0); }
  }
  column_starts_.push_back(static_cast<Index>(rows_.size()));
}

void FirstOrderJacobian::evaluate(const double* y) {
  const Index n = system_->dof();
  const VectorXd position = system_->origin() + ConstVectorMap(y, n);
  system_->problem().jacobian(position, ConstVectorMap(y + n, n), stiffness_, damping_);
  stiffness_.makeCompressed();
  damping_.makeCompressed();
}

void FirstOrderJacobian::update(const double* y) {
  evaluate(y);
  if (static_cast<std::size_t>(stiffness_.nonZeros()) != stiffness_slots_.size() ||
      static_cast<std::size_t>(damping_.nonZeros()) != damping_slots_.size()) {
    throw SolverError("first order: the pattern of the problem's Jacobian has changed");
  }
  const auto scatter = [this](const Eigen::SparseMatrix<double>& matrix,
                              const std::vector<std::size_t>& slots) {
    for (std::size_t s = 0; s < slots.size(); ++s) {
      const auto entry = static_cast<Index>(s);
      const Index row = matrix.innerIndexPtr()[entry];
      values_[slots[s]] = -matrix.valuePtr()[entry] * inverse_mass_(row);
    }
  };
  scatter(stiffness_, stiffness_slots_);
  scatter(damping_, damping_slots_);
}

}  // namespace palpate::reference
