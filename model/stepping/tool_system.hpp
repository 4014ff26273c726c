// SPDX-License-Identifier: MIT
#pragma once
/// Network under the forces of a tool, as the system of an integrator.

#include <utility>
#include <vector>

#include "model/kernels/network_system.hpp"
#include "model/stepping/integrator.hpp"
#include "model/stepping/tool_contact.hpp"

namespace palpate {

/// Network under further forces, which a derived class adds. The rest is that of the network.
template <class Real> class LoadedNetwork : public System<Real> {
 public:
  /// The network must outlive this object.
  explicit LoadedNetwork(NetworkSystem<Real>& network) : network_(network) {}
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
  }
  void pattern(Eigen::SparseMatrix<Real>& a) override { network_.pattern(a); }
  [[nodiscard]] NodeVectors places() const override { return network_.places(); }

 protected:
  NetworkSystem<Real>& network_;
};

/// Network with a tool, whose forces are added to those of the network. Under an applied force the
/// tool's position is the last coordinate.
template <class Real> class ToolSystem final : public LoadedNetwork<Real> {
 public:
  /// Refers to both arguments, which must outlive this object.
  ToolSystem(NetworkSystem<Real>& network, ToolContact<Real>& contact)
      : LoadedNetwork<Real>(network), contact_(contact) {
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
  void jacobian(const Vector<Real>& q, const Vector<Real>& v, Real on_damping, Real on_stiffness,
                Eigen::SparseMatrix<Real>& a) noexcept override {
    LoadedNetwork<Real>::jacobian(q, v, on_damping, on_stiffness, a);
    if (contact_.is_coordinate()) {
      a.valuePtr()[a.nonZeros() - 1] =
          static_cast<Real>(contact_.mass()) +
          on_damping * static_cast<Real>(contact_.coupling().viscosity) +
          on_stiffness * static_cast<Real>(contact_.coupling().stiffness);
    }
  }
  void pattern(Eigen::SparseMatrix<Real>& a) override {
    LoadedNetwork<Real>::pattern(a);
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

  using LoadedNetwork<Real>::network_;
  ToolContact<Real>& contact_;
  Instant kept_{};
  Vector<Real> kept_f_;  ///< force of the network for the kept state [N]
};

/// Network with a force along a needle on the tissue at a depth of its path [m].
template <class Real> class PressedNetwork final : public LoadedNetwork<Real> {
 public:
  PressedNetwork(NetworkSystem<Real>& network, const NeedlePath& path, double depth)
      : LoadedNetwork<Real>(network) {
    this->share_mass(network);
    share_.setZero(this->dof());
    const NodeLayout& layout = network.layout();
    const NeedlePath::Place at = path.place(depth);
    for (const auto& [knot, part] : {std::pair{at.knot, 1.0 - at.share}, {at.knot + 1, at.share}}) {
      if (part == 0.0) { continue; }
      for (const NeedlePath::Support& s : path.supports(path.knots()[knot])) {
        const Eigen::Index first = layout.first[static_cast<std::size_t>(s.node)];
        for (Eigen::Index n = 0; first >= 0 && n < 3; ++n) {
          share_(first + n * layout.stride) +=
              static_cast<Real>(part * s.weight * path.direction()(n));
        }
      }
    }
  }
  void press(double force) noexcept { pressed_ = static_cast<Real>(force); }
  /// Returns the mean place of the pressed nodes along the needle [m].
  [[nodiscard]] double place(const Vector<Real>& q) const noexcept {
    return static_cast<double>(share_.dot(q));
  }

  /// Time does not pass: tissue does not relax, and no later load begins.
  void force(double /*t*/, double /*gate*/, const Vector<Real>& q, const Vector<Real>& v,
             Vector<Real>& f) noexcept override {
    network_.force(0.0, 0.0, q, v, f);
    f += pressed_ * share_;
  }

 private:
  using LoadedNetwork<Real>::network_;
  Vector<Real> share_;  ///< of each coordinate in the force
  Real pressed_ = 0;    ///< [N]
};

/// Returns the dents of a network without a contact [m] under forces [N] of 0, step, 2 step and so
/// on, at rest, that press at a depth of the path [m]. Returns an empty list if it finds no
/// equilibrium. Allocates.
template <class Real>
std::vector<double> dents_of_grid(NetworkSystem<Real>& network, const NeedlePath& path,
                                  double depth, double step, std::size_t count) {
  constexpr double length = 10.0;  // of a step of implicit Euler, which damps every mode [s]
  constexpr int steps = 4;         // of every force
  PressedNetwork<Real> pressed(network, path, depth);
  State<Real> state{network.initial_position(), Vector<Real>::Zero(pressed.dof())};
  const std::unique_ptr<Integrator<Real>> scheme =
      find_integrator("implicit-euler")->template make<Real>();
  scheme->set_tolerance(1e-6, 0);
  scheme->prepare(pressed, state, length);
  std::vector<double> dents;
  double begin = 0.0;
  for (std::size_t n = 0; n < count; ++n) {
    pressed.press(static_cast<double>(n) * step);
    for (int k = 0; k < steps; ++k) { scheme->step(pressed, state, 0.0, length); }
    const double place = pressed.place(state.position);
    if (!std::isfinite(place) || !state.position.allFinite()) { return {}; }
    if (n == 0) { begin = place; }
    dents.push_back(place - begin);
  }
  return dents;
}

}  // namespace palpate
