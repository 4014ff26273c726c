// SPDX-License-Identifier: MIT
#include <cmath>
#include <limits>
#include <numbers>

#include "model/dynamics/problem.hpp"

namespace palpate {

OscillatorProblem::OscillatorProblem(const Oscillator& oscillator)
    : oscillator_(oscillator), mass_(Eigen::VectorXd::Constant(1, oscillator.mass)) {}

Eigen::VectorXd OscillatorProblem::initial_position() const {
  return Eigen::VectorXd::Constant(1, oscillator_.displacement);
}

Eigen::VectorXd OscillatorProblem::initial_velocity() const {
  return Eigen::VectorXd::Constant(1, oscillator_.velocity);
}

void OscillatorProblem::force(double t, double /*gate*/, const Eigen::Ref<const Eigen::VectorXd>& q,
                              const Eigen::Ref<const Eigen::VectorXd>& v,
                              Eigen::Ref<Eigen::VectorXd> f) const {
  f(0) = oscillator_.drive_amplitude * std::cos(oscillator_.drive_frequency * t) -
         oscillator_.stiffness * q(0) - oscillator_.viscosity * v(0);
}

void OscillatorProblem::jacobian(const Eigen::Ref<const Eigen::VectorXd>& /*q*/,
                                 const Eigen::Ref<const Eigen::VectorXd>& /*v*/,
                                 Eigen::SparseMatrix<double>& stiffness,
                                 Eigen::SparseMatrix<double>& damping) const {
  for (auto* matrix : {&stiffness, &damping}) {
    matrix->resize(1, 1);
    matrix->insert(0, 0) = matrix == &stiffness ? oscillator_.stiffness : oscillator_.viscosity;
    matrix->makeCompressed();
  }
}

double OscillatorProblem::shortest_feature() const {
  if (oscillator_.drive_amplitude == 0.0 || oscillator_.drive_frequency == 0.0) {
    return std::numeric_limits<double>::infinity();
  }
  return 2.0 * std::numbers::pi / std::abs(oscillator_.drive_frequency);
}

double OscillatorProblem::energy(const Eigen::Ref<const Eigen::VectorXd>& q,
                                 const Eigen::Ref<const Eigen::VectorXd>& v) const {
  return 0.5 * oscillator_.mass * v(0) * v(0) + 0.5 * oscillator_.stiffness * q(0) * q(0);
}

}  // namespace palpate
