// SPDX-License-Identifier: MIT
#pragma once
/// A network with a tool in it, as an integrator sees it. The tool's forces are added to those of the
/// network; under an applied force the tool's place is the last coordinate.

#include "model/stepping/network_system.hpp"
#include "model/stepping/tool_contact.hpp"

namespace palpate {

template <class Real>
class ToolSystem final : public System<Real> {
 public:
  /// Both outlive this.
  ToolSystem(NetworkSystem<Real>& network, ToolContact<Real>& contact)
      : network_(network), contact_(contact) {
    Eigen::VectorXd mass = network.mass().template cast<double>();
    if (contact.is_coordinate()) {
      mass.conservativeResize(mass.size() + 1);
      mass(mass.size() - 1) = contact.mass();
    }
    this->set_mass(mass);
  }

  void force(double t, double gate, const Vector<Real>& q, const Vector<Real>& v,
             Vector<Real>& f) noexcept override {
    network_.force(t, gate, q, v, f);
    contact_.apply(t, q, v, f);
  }
  void add_loads(double t, double gate, Real weight, Vector<Real>& f) noexcept override {
    network_.add_loads(t, gate, weight, f);
  }
  void damping(const Vector<Real>& q, const Vector<Real>& w, Vector<Real>& f) noexcept override {
    network_.damping(q, w, f);
  }
  void jacobian(const Vector<Real>& q, const Vector<Real>& v, Real on_damping, Real on_stiffness,
                Eigen::SparseMatrix<Real>& a) noexcept override {
    network_.jacobian(q, v, on_damping, on_stiffness, a);
    if (contact_.is_coordinate()) {
      a.valuePtr()[a.nonZeros() - 1] =
          static_cast<Real>(contact_.mass()) +
          on_damping * static_cast<Real>(contact_.coupling().viscosity) +
          on_stiffness * static_cast<Real>(contact_.coupling().stiffness);
    }
  }
  void pattern(Eigen::SparseMatrix<Real>& a) override {
    network_.pattern(a);
    if (!contact_.is_coordinate()) { return; }
    const Eigen::Index last = this->dof() - 1;
    a.conservativeResize(last + 1, last + 1);
    a.insert(last, last) = Real(0);
    a.makeCompressed();
  }
  void hold(const Vector<Real>& x, Vector<Real>& product) noexcept override {
    contact_.hold(x, this->mass(), product);
  }
  void learn_response(
      const std::function<void(const Vector<Real>&, Vector<Real>&)>& solve) override {
    contact_.learn_response(this->dof(), solve);
  }
  void begin_holding() noexcept override { contact_.begin_holding(); }
  void hold_solution(const Vector<Real>& r, Vector<Real>& solution) noexcept override {
    contact_.hold_solution(r, solution);
  }

 private:
  NetworkSystem<Real>& network_;
  ToolContact<Real>& contact_;
};

}  // namespace palpate
