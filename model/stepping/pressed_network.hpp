// SPDX-License-Identifier: MIT
#pragma once
/// Dent of a network alone under a needle that presses its skin (model/EQUATIONS.md, "Large dent of
/// a skin").

#include <vector>

#include "model/kernels/network_system.hpp"
#include "model/problem/needle_path.hpp"
#include "model/stepping/integrator.hpp"

namespace palpate {

/// Network with a force along a needle on the tissue at a depth of its path [m].
template <class Real> class PressedNetwork final : public System<Real> {
 public:
  PressedNetwork(NetworkSystem<Real>& network, const NeedlePath& path, double depth)
      : network_(network) {
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
  void add_loads(double /*t*/, double /*gate*/, Real weight, Vector<Real>& f) noexcept override {
    network_.add_loads(0.0, 0.0, weight, f);
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

 private:
  NetworkSystem<Real>& network_;
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
