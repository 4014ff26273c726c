// SPDX-License-Identifier: MIT
#pragma once
/// Network with a tool, as the system of an integrator. The tool's forces are added to those of the
/// network. Under an applied force the tool's position is the last coordinate.

#include "model/kernels/network_system.hpp"
#include "model/stepping/tool_contact.hpp"

namespace palpate {

template <class Real> class ToolSystem final : public System<Real> {
 public:
  /// Refers to both arguments, which must outlive this object.
  ToolSystem(NetworkSystem<Real>& network, ToolContact<Real>& contact)
      : network_(network), contact_(contact) {
    if (contact.is_coordinate()) {
      Eigen::VectorXd mass = network.mass().template cast<double>();
      mass.conservativeResize(mass.size() + 1);
      mass(mass.size() - 1) = contact.mass();
      this->set_mass(mass);
    } else {
      this->share_mass(network);
    }
    kept_f_.setZero(this->dof());
  }
  /// Returns the memory in addition to that of the network.
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    const Eigen::Index masses = contact_.is_coordinate() ? 2 * this->dof() : 0;
    return static_cast<std::size_t>(kept_f_.size() + masses) * sizeof(Real);
  }

  void force(double t, double gate, const Vector<Real>& q, const Vector<Real>& v,
             Vector<Real>& f) noexcept override {
    if (kept_ == Instant{t, gate, &q, &v}) {
      f.swap(kept_f_);
    } else {
      network_.force(t, gate, q, v, f);
    }
    forget();
    contact_.apply(t, q, v, f);
  }
  /// Computes the force and keeps the network's force until the next force() or forget(). A step
  /// that begins with the same vectors reuses it. Returns the elastic energy [J].
  double measure(double t, double gate, const Vector<Real>& q, const Vector<Real>& v,
                 Vector<Real>& f) noexcept {
    const double energy = network_.measure(t, gate, q, v, kept_f_);
    kept_ = {t, gate, &q, &v};
    f = kept_f_;
    contact_.apply(t, q, v, f);
    return energy;
  }
  /// Discards the kept force; call it after a change of the measured state.
  void forget() noexcept { kept_ = {}; }
  void add_loads(double t, double gate, Real weight, Vector<Real>& f) noexcept override {
    network_.add_loads(t, gate, weight, f);
  }
  [[nodiscard]] bool has_dampers() const override { return network_.has_dampers(); }
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
  void learn_compliance(
      const std::function<void(const Vector<Real>&, Vector<Real>&)>& solve) override {
    contact_.learn_compliance(this->dof(), solve);
  }
  [[nodiscard]] long constraint_set() const noexcept override { return contact_.constraint_set(); }
  void begin_linear_solve() noexcept override { contact_.begin_linear_solve(); }
  void constrain_solution(const Vector<Real>& r, Vector<Real>& solution) noexcept override {
    contact_.constrain_solution(r, solution);
  }

 private:
  struct Instant {
    double t = 0.0;
    double gate = 0.0;
    const Vector<Real>* q = nullptr;
    const Vector<Real>* v = nullptr;
    bool operator==(const Instant&) const = default;
  };

  NetworkSystem<Real>& network_;
  ToolContact<Real>& contact_;
  Instant kept_{};
  Vector<Real> kept_f_;  ///< force of the network for the kept state [N]
};

}  // namespace palpate
