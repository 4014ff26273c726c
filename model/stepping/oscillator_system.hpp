// SPDX-License-Identifier: MIT
#pragma once
/// The single spring-mass-damper as an integrator sees it.

#include <cmath>

#include "model/dynamics/scene.hpp"
#include "model/stepping/system.hpp"

namespace palpate {

template <class Real>
class OscillatorSystem final : public System<Real> {
 public:
  explicit OscillatorSystem(const Oscillator& oscillator) : o_(oscillator) {
    this->set_mass(Eigen::VectorXd::Constant(1, oscillator.mass));
  }
  void force(double t, double /*gate*/, const Vector<Real>& q, const Vector<Real>& v,
             Vector<Real>& f) noexcept override {
    f(0) = static_cast<Real>(drive(t)) - static_cast<Real>(o_.stiffness) * q(0) -
           static_cast<Real>(o_.viscosity) * v(0);
  }
  /// The drive never switches, so both halves of a kick see the same and nothing changes.
  void add_loads(double t, double /*gate*/, Real weight, Vector<Real>& f) noexcept override {
    f(0) += weight * static_cast<Real>(drive(t));
  }
  void damping(const Vector<Real>& /*q*/, const Vector<Real>& w, Vector<Real>& f) noexcept override {
    f(0) = static_cast<Real>(o_.viscosity) * w(0);
  }
  void jacobian(const Vector<Real>& /*q*/, const Vector<Real>& /*v*/, Real on_damping,
                Real on_stiffness, Eigen::SparseMatrix<Real>& a) noexcept override {
    a.valuePtr()[0] = static_cast<Real>(o_.mass) + on_damping * static_cast<Real>(o_.viscosity) +
                      on_stiffness * static_cast<Real>(o_.stiffness);
  }
  void pattern(Eigen::SparseMatrix<Real>& a) override {
    a.resize(1, 1);
    a.insert(0, 0) = Real(0);
    a.makeCompressed();
  }
  [[nodiscard]] double energy(const Vector<Real>& q, const Vector<Real>& v) const noexcept {
    const double x = static_cast<double>(q(0));
    const double speed = static_cast<double>(v(0));
    return 0.5 * o_.mass * speed * speed + 0.5 * o_.stiffness * x * x;
  }

 private:
  [[nodiscard]] double drive(double t) const noexcept {
    return o_.drive_amplitude == 0.0 ? 0.0
                                     : o_.drive_amplitude * std::cos(o_.drive_frequency * t);
  }
  Oscillator o_;
};

}  // namespace palpate
