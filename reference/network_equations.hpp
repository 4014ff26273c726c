// SPDX-License-Identifier: MIT
#pragma once
/// Equations of motion of a network, from the physics alone: no force law, load profile or
/// Problem::force of the model is used.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "model/problem/problem.hpp"

namespace palpate::reference {

/// [u; v], u = q - q(0), and further states.
template <class Real> using State = std::vector<Real>;

/// Equations of motion in the precision of Real.
template <class Real> class Equations {
 public:
  virtual ~Equations() = default;
  [[nodiscard]] virtual std::size_t dof() const = 0;
  [[nodiscard]] virtual State<Real> initial_state() const = 0;
  [[nodiscard]] virtual Real initial_position(std::size_t coordinate) const = 0;
  virtual void derivative(Real t, double gate, const State<Real>& y, State<Real>& dy) = 0;
};

/// Equations of a network: springs pull their ends together when stretched, dampers oppose the rate
/// of stretching, cells resist changes of their mean volume and the collapse of their corners,
/// loads act from start to end, weight acts always, and fixed nodes do not move.
template <class Real> class NetworkEquations final : public Equations<Real> {
 public:
  explicit NetworkEquations(const NetworkProblem& problem) : problem_(problem) {
    const SpringNetwork& network = problem.network();
    const bool displaced = network.initial_displacement.cols() > 0;
    for (Eigen::Index i = 0; i < network.rest_position.cols(); ++i) {
      const auto node = static_cast<std::size_t>(i);
      Triple place{};
      for (int axis = 0; axis < 3; ++axis) {
        place[static_cast<std::size_t>(axis)] =
            Real(network.rest_position(axis, i)) +
            (displaced ? Real(network.initial_displacement(axis, i)) : Real(0));
      }
      place_.push_back(place);
      const bool moves = network.fixed[node] == 0;
      offset_.push_back(moves ? static_cast<std::ptrdiff_t>(3 * moving_.size()) : -1);
      if (moves) { moving_.push_back(node); }
    }
    const auto count = [&](int number) {
      if (number > 0) { branches_ += law(number).branches.size(); }
    };
    for (const Spring& spring : network.springs) { count(spring.law); }
    for (const VolumeCell& cell : network.cells) { count(cell.stiffness > 0.0 ? cell.law : 0); }
  }

  std::size_t dof() const override { return 3 * moving_.size(); }
  /// Displacements and velocities, then the tension z of every branch of the springs and cells that
  /// relax, tau z' = T - z with the elastic tension T.
  State<Real> initial_state() const override {
    State<Real> y(2 * dof() + branches_, 0);
    const NodeVectors& velocity = problem_.network().initial_velocity;
    if (velocity.cols() == 0) { return y; }
    for (std::size_t c = 0; c < dof(); ++c) {
      const auto node = static_cast<Eigen::Index>(moving_[c / 3]);
      y[dof() + c] = velocity(static_cast<Eigen::Index>(c % 3), node);
    }
    return y;
  }

  /// Returns, for every branch, the tension of its element under a displacement [m]: in N of a
  /// spring and Pa of a cell.
  std::vector<double> branch_scales(double displacement) const {
    std::vector<double> scales;
    const auto add = [&](int number, double scale) {
      if (number > 0) { scales.resize(scales.size() + law(number).branches.size(), scale); }
    };
    for (const Spring& spring : problem_.network().springs) {
      add(spring.law, spring.stiffness * displacement);
    }
    for (const VolumeCell& cell : problem_.network().cells) {
      if (cell.stiffness == 0.0) { continue; }
      add(cell.law, cell.stiffness * displacement / std::cbrt(double(cell.volume)));
    }
    return scales;
  }

  Real initial_position(std::size_t coordinate) const override {
    return place_[moving_[coordinate / 3]][coordinate % 3];
  }

  void derivative(Real t, double gate, const State<Real>& y, State<Real>& dy) override {
    dy.resize(y.size());
    for (std::size_t c = 0; c < dof(); ++c) {
      dy[c] = y[dof() + c];
      dy[dof() + c] = 0;
    }
    branch_ = 2 * dof();
    for (const Spring& spring : problem_.network().springs) { add_spring(spring, y, dy); }
    for (const VolumeCell& cell : problem_.network().cells) { add_cell(cell, y, dy); }
    add_loads(t, gate, dy);
    for (std::size_t c = 0; c < dof(); ++c) {
      const Real mass = problem_.network().mass(static_cast<Eigen::Index>(moving_[c / 3]));
      dy[dof() + c] =
          dy[dof() + c] / mass + Real(problem_.gravity()(static_cast<Eigen::Index>(c % 3)));
    }
  }

 private:
  using Triple = std::array<Real, 3>;

  void add_spring(const Spring& spring, const State<Real>& y, State<Real>& dy) const {
    const auto a = static_cast<std::size_t>(spring.a);
    const auto b = static_cast<std::size_t>(spring.b);
    const std::ptrdiff_t offset[2] = {offset_[a], offset_[b]};
    Triple apart{}, closing{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      apart[axis] = place_[b][axis] - place_[a][axis];
      for (int end = 0; end < 2; ++end) {
        if (offset[end] < 0) { continue; }
        const auto c = static_cast<std::size_t>(offset[end]) + axis;
        apart[axis] += end == 1 ? y[c] : -y[c];
        closing[axis] += end == 1 ? -y[dof() + c] : y[dof() + c];
      }
    }
    const Real length = std::sqrt(apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2]);
    if (length < Real(1e-12L)) { return; }
    const Real shortening =
        (apart[0] * closing[0] + apart[1] * closing[1] + apart[2] * closing[2]) / length;
    const Real stretch = (length - Real(spring.rest_length)) / Real(spring.rest_length);
    Real pull = Real(spring.stiffness) * Real(spring.rest_length) *
                (spring.law > 0 ? stiffened(law(spring.law).stiffening, stretch) : stretch);
    pull = relaxed(spring.law, pull, y, dy) - Real(spring.viscosity) * shortening;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Real component = pull * apart[axis] / length;
      if (offset[0] >= 0) { dy[dof() + static_cast<std::size_t>(offset[0]) + axis] += component; }
      if (offset[1] >= 0) { dy[dof() + static_cast<std::size_t>(offset[1]) + axis] -= component; }
    }
  }

  /// Adds the forces of a cell, from the twelve edges along its axes. The volume at a corner is the
  /// determinant of its three edges, and an edge has the cross product of the other two as
  /// gradient.
  void add_cell(const VolumeCell& cell, const State<Real>& y, State<Real>& dy) const {
    if (cell.stiffness == 0.0) { return; }
    std::array<Triple, 8> x{};
    std::array<Triple, 8> v{};
    for (std::size_t n = 0; n < 8; ++n) {
      const auto node = static_cast<std::size_t>(cell.nodes[n]);
      x[n] = place_[node];
      for (std::size_t axis = 0; offset_[node] >= 0 && axis < 3; ++axis) {
        const auto c = static_cast<std::size_t>(offset_[node]) + axis;
        x[n][axis] += y[c];
        v[n][axis] = y[dof() + c];
      }
    }
    const auto minus = [](const Triple& a, const Triple& b) {
      return Triple{a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    };
    const auto dot = [](const Triple& a, const Triple& b) {
      return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    };
    // Edge of corner n along an axis, from its lower to its upper end.
    const auto lower = [](std::size_t n, std::size_t axis) {
      return n & ~(std::size_t{1} << axis);
    };
    const auto upper = [](std::size_t n, std::size_t axis) { return n | (std::size_t{1} << axis); };
    std::array<std::array<Triple, 3>, 8> gradient{};
    std::array<Real, 8> volume{};
    Real mean = 0;
    Real rate = 0;
    const Real whole = cell.volume;
    for (std::size_t n = 0; n < 8; ++n) {
      std::array<Triple, 3> edge{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        edge[axis] = minus(x[upper(n, axis)], x[lower(n, axis)]);
      }
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const Triple& a = edge[(axis + 1) % 3];
        const Triple& b = edge[(axis + 2) % 3];
        gradient[n][axis] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                             a[0] * b[1] - a[1] * b[0]};
        rate += dot(gradient[n][axis], minus(v[upper(n, axis)], v[lower(n, axis)])) / (8 * whole);
      }
      volume[n] = dot(edge[0], gradient[n][0]) / whole;
      mean += volume[n] / 8;
    }
    const Real resisting = relaxed(cell.law, Real(cell.stiffness) * (mean - 1), y, dy);
    for (std::size_t n = 0; n < 8; ++n) {
      const Real pressure = (resisting + Real(cell.viscosity) * rate +
                             Real(cell.collapse) * collapse_slope(volume[n])) /
                            8;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t c = 0; c < 3; ++c) {
          const Real force = pressure * gradient[n][axis][c];
          add_force(cell.nodes[lower(n, axis)], c, force, dy);
          add_force(cell.nodes[upper(n, axis)], c, -force, dy);
        }
      }
    }
  }

  const MaterialLaw& law(int number) const {
    return problem_.network().laws[static_cast<std::size_t>(number) - 1];
  }
  /// Tension of a spring in units of k L0 that stiffens up to a largest slope.
  static Real stiffened(const Stiffening& s, Real stretch) {
    const Real largest = s.largest;
    const Real size = std::abs(stretch);
    const Real sign = stretch < 0 ? -1 : 1;
    if (s.law == Stiffening::Law::exponential) {
      const Real a = s.rate;
      if (a == 0) { return stretch; }
      const Real end = std::log(largest) / a;
      if (size <= end) { return sign * std::expm1(a * size) / a; }
      return sign * ((largest - 1) / a + largest * (size - end));
    }
    const Real b = s.quadratic;
    const Real c = s.cubic;
    const auto bent = [&](Real e) { return e * (1 + e * (b + c * e)); };
    const auto slope = [&](Real e) { return 1 + e * (2 * b + 3 * c * e); };
    if (slope(size) <= largest) { return sign * bent(size); }
    Real low = 0;
    Real high = size;
    for (int n = 0; n < 200; ++n) {
      const Real middle = (low + high) / 2;
      (slope(middle) <= largest ? low : high) = middle;
    }
    return sign * (bent(low) + largest * (size - low));
  }
  /// Returns what the branches of the next element leave of its elastic tension, and writes the
  /// rates of their tensions.
  Real relaxed(int number, Real tension, const State<Real>& y, State<Real>& dy) const {
    if (number == 0) { return tension; }
    Real left = tension;
    for (const RelaxationBranch& branch : law(number).branches) {
      left -= Real(branch.share) * y[branch_];
      dy[branch_] = (tension - y[branch_]) / Real(branch.time);
      ++branch_;
    }
    return left;
  }

  /// Slope of -J_b (1 - s)^2 ln s, s = J / J_b, with J_b = 0.3; linear below s = 0.1.
  static Real collapse_slope(Real j) {
    if (j >= Real(0.3L)) { return 0; }
    const Real s = std::max(j / Real(0.3L), Real(0.1L));
    const Real slope = (1 - s) * (2 * std::log(s) - (1 - s) / s);
    if (j >= Real(0.03L)) { return slope; }
    const Real curvature = (4 / s - 4 + (1 - s) * (1 - s) / (s * s) - 2 * std::log(s)) / Real(0.3L);
    return slope + (j - Real(0.03L)) * curvature;
  }

  void add_force(int node, std::size_t axis, Real force, State<Real>& dy) const {
    const std::ptrdiff_t offset = offset_[static_cast<std::size_t>(node)];
    if (offset >= 0) { dy[dof() + static_cast<std::size_t>(offset) + axis] += force; }
  }

  void add_loads(Real t, double gate, State<Real>& dy) const {
    for (const Load& load : problem_.loads()) {
      if (!(load.start <= gate && gate < load.end)) { continue; }
      Real strength = 1;
      if (load.profile != Profile::constant) {
        strength = (t - Real(load.start)) / (Real(load.end) - Real(load.start));
      }
      if (load.profile == Profile::half_sine) {
        strength = std::sin(std::numbers::pi_v<Real> * strength);
      }
      for (const int node : load.nodes) {
        const std::ptrdiff_t offset = offset_[static_cast<std::size_t>(node)];
        for (std::size_t axis = 0; offset >= 0 && axis < 3; ++axis) {
          dy[dof() + static_cast<std::size_t>(offset) + axis] +=
              strength * Real(load.force(static_cast<Eigen::Index>(axis)));
        }
      }
    }
  }

  const NetworkProblem& problem_;
  std::vector<Triple> place_{};           ///< initial positions of all nodes [m]
  std::vector<std::size_t> moving_{};     ///< nodes that are not fixed, ascending
  std::vector<std::ptrdiff_t> offset_{};  ///< of a node in u; -1 when fixed
  std::size_t branches_ = 0;              ///< of all springs and cells
  mutable std::size_t branch_ = 0;        ///< of the next element in y
};

}  // namespace palpate::reference
