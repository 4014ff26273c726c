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
    for (Vector<Real>* kept : {&kept_q_, &kept_v_, &kept_f_}) { kept->setZero(mass.size()); }
  }

  void force(double t, double gate, const Vector<Real>& q, const Vector<Real>& v,
             Vector<Real>& f) noexcept override {
    if (is_kept(t, gate, q, v)) {
      f = kept_f_;
    } else {
      network_.force(t, gate, q, v, f);
    }
    contact_.apply(t, q, v, f);
  }
  /// The same, and keeps what the network's springs say: a step that begins at a state that was looked
  /// at need not ask them again.
  void measure(double t, double gate, const Vector<Real>& q, const Vector<Real>& v,
               Vector<Real>& f) noexcept {
    if (!is_kept(t, gate, q, v)) {
      network_.force(t, gate, q, v, kept_f_);
      kept_t_ = t;
      kept_gate_ = gate;
      kept_q_ = q;
      kept_v_ = v;
    }
    f = kept_f_;
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
  [[nodiscard]] bool is_kept(double t, double gate, const Vector<Real>& q,
                             const Vector<Real>& v) const noexcept {
    return t == kept_t_ && gate == kept_gate_ && q == kept_q_ && v == kept_v_;
  }

  NetworkSystem<Real>& network_;
  ToolContact<Real>& contact_;
  double kept_t_ = -1.0;  ///< no run begins before 0
  double kept_gate_ = -1.0;
  Vector<Real> kept_q_, kept_v_, kept_f_;
};

}  // namespace palpate
