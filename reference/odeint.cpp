// SPDX-License-Identifier: MIT
/// Adaptive steppers of Boost.odeint: Dormand-Prince for any problem in double, and Fehlberg 7(8)
/// in long double. The right-hand sides in long double come from the physics alone: no force law,
/// load profile or Problem::force of the model is used.

#include <algorithm>
#include <array>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>
#include <boost/version.hpp>
#include <cmath>
#include <exception>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "model/problem/problem.hpp"
#include "reference/integrate.hpp"
#include "reference/solvers.hpp"

namespace palpate::reference {

namespace {

template <class Real> using State = std::vector<Real>;  ///< [u; v], u = q - q(0)

/// Equations of motion in the precision of Real.
template <class Real> class Equations {
 public:
  virtual ~Equations() = default;
  [[nodiscard]] virtual std::size_t dof() const = 0;
  [[nodiscard]] virtual State<Real> initial_state() const = 0;
  [[nodiscard]] virtual Real initial_position(std::size_t coordinate) const = 0;
  virtual void derivative(Real t, double gate, const State<Real>& y, State<Real>& dy) = 0;
};

/// Stepper with tolerances per coordinate, exact stops and a limit on steps.
template <class Stepper, class Real> class Adaptive final : public Integrator {
 public:
  Adaptive(std::string name, Equations<Real>& equations, const Tolerance& tolerance)
      : name_(std::move(name)),
        equations_(equations),
        tolerance_(tolerance),
        state_(equations.initial_state()),
        trial_(state_),
        error_(state_) {}

  void read(Eigen::Ref<Eigen::VectorXd> position,
            Eigen::Ref<Eigen::VectorXd> velocity) const override {
    const std::size_t n = equations_.dof();
    for (std::size_t c = 0; c < n; ++c) {
      const auto row = static_cast<Eigen::Index>(c);
      position(row) = static_cast<double>(equations_.initial_position(c) + state_[c]);
      velocity(row) = static_cast<double>(state_[n + c]);
    }
  }
  [[nodiscard]] long segment_steps() const override { return steps_; }
  [[nodiscard]] long evaluations() const override { return evaluations_; }

  void begin(const Segment& segment) override {
    forget_derivative();  // it belongs to other loads
    time_ = segment.start;
    gate_ = segment.gate;
    max_step_ = segment.max_step;
    step_ = max_step_ / 100;
    steps_ = 0;
  }

  void advance(double stop) override {
    const Real end = stop;
    const long last_step = steps_ + step_limit;
    while (time_ < end) {
      const bool reaches_end = time_ + step_ >= end;
      const Real h = reaches_end ? end - time_ : step_;
      const Real size = attempt(h);
      if (!std::isfinite(size)) {
        fail(name_, "do_step", "a result that is not finite", double(time_), "");
      }
      if (size <= 1) {
        state_.swap(trial_);
        time_ = reaches_end ? end : time_ + h;
        ++steps_;
      } else {
        forget_derivative();
      }
      const Real factor = std::clamp(
          Real(0.9L) * std::pow(std::max(size, Real(1e-10L)), -1 / Real(Stepper::order_value)),
          Real(0.2L), Real(4));
      if (size > 1 || factor * h > step_ || !reaches_end) {
        step_ = std::min(h * factor, max_step_);
      }
      if (step_ < 1e-16L * max_step_ || steps_ > last_step) {
        fail(name_, "do_step", "a vanishing step or too many steps", double(time_), "");
      }
    }
  }

 private:
  /// Discards the derivative that a stepper keeps from its last stage.
  void forget_derivative() {
    if constexpr (requires { stepper_.reset(); }) { stepper_.reset(); }
  }

  /// Computes a step of h [s]; returns its error relative to the tolerance. The new state is in
  /// trial_.
  Real attempt(Real h) {
    const auto system = [this](const State<Real>& y, State<Real>& dy, Real t) {
      ++evaluations_;
      equations_.derivative(t, gate_, y, dy);
    };
    try {
      stepper_.do_step(system, state_, time_, trial_, h, error_);
    } catch (const std::exception& error) {
      fail(name_, "do_step", "an exception", double(time_), error.what());
    }
    Real largest = 0;
    const std::size_t n = equations_.dof();
    for (std::size_t c = 0; c < 2 * n; ++c) {
      const Real scale = c < n ? tolerance_.position_scale : tolerance_.velocity_scale;
      const Real size =
          std::abs(error_[c]) / (Real(tolerance_.relative) * (scale + std::abs(state_[c])));
      if (!std::isfinite(size) || !std::isfinite(trial_[c])) {
        return std::numeric_limits<Real>::quiet_NaN();  // max() would ignore NaN
      }
      largest = std::max(largest, size);
    }
    return largest;
  }

  std::string name_;
  Equations<Real>& equations_;
  Tolerance tolerance_;
  Stepper stepper_{};
  State<Real> state_, trial_, error_;
  Real time_ = 0, step_ = 0, max_step_ = 0;
  double gate_ = 0.0;
  long steps_ = 0;
  long evaluations_ = 0;
};

template <template <class, class> class Stepper, class Real>
Trace solve(const char* name, Equations<Real>& equations, const Problem& problem,
            const std::vector<double>& times, const Tolerance& tolerance) {
  Adaptive<Stepper<State<Real>, Real>, Real> integrator(name, equations, tolerance);
  return integrate({name, std::string("Boost.odeint ") + BOOST_LIB_VERSION}, problem, times,
                   tolerance, integrator);
}

/// Equations of any problem, from its own force.
class ProblemEquations final : public Equations<double> {
 public:
  explicit ProblemEquations(const Problem& problem) : system_(problem) {}
  std::size_t dof() const override { return static_cast<std::size_t>(system_.dof()); }
  State<double> initial_state() const override {
    const Eigen::VectorXd y = system_.initial_state();
    return {y.begin(), y.end()};
  }
  double initial_position(std::size_t coordinate) const override {
    return system_.origin()(static_cast<Eigen::Index>(coordinate));
  }
  void derivative(double t, double gate, const State<double>& y, State<double>& dy) override {
    system_.set_gate(gate);
    if (!system_.derivative(t, y.data(), dy.data())) {
      throw SolverError("the right-hand side is not finite");
    }
  }

 private:
  FirstOrderSystem system_;
};

using Extended = long double;
using ExtendedState = State<Extended>;
using ExtendedEquations = Equations<Extended>;

/// Equation m x'' = F0 cos(W t) - k x - c x'.
class OscillatorEquations final : public ExtendedEquations {
 public:
  explicit OscillatorEquations(const Oscillator& oscillator) : o_(oscillator) {}
  std::size_t dof() const override { return 1; }
  ExtendedState initial_state() const override { return {0, o_.velocity}; }
  Extended initial_position(std::size_t) const override { return o_.displacement; }
  void derivative(Extended t, double, const ExtendedState& y, ExtendedState& dy) override {
    const Extended x = Extended(o_.displacement) + y[0];
    const Extended drive =
        Extended(o_.drive_amplitude) * std::cos(Extended(o_.drive_frequency) * t);
    dy[0] = y[1];
    dy[1] =
        (drive - Extended(o_.stiffness) * x - Extended(o_.viscosity) * y[1]) / Extended(o_.mass);
  }

 private:
  Oscillator o_;
};

using Triple = std::array<Extended, 3>;

/// Equations of a network: springs pull their ends together when stretched, dampers oppose the rate
/// of stretching, cells resist changes of their mean volume and the collapse of their corners,
/// loads act from start to end, weight acts always, and fixed nodes do not move.
class NetworkEquations final : public ExtendedEquations {
 public:
  explicit NetworkEquations(const NetworkProblem& problem) : problem_(problem) {
    const SpringNetwork& network = problem.network();
    const bool displaced = network.initial_displacement.cols() > 0;
    for (Eigen::Index i = 0; i < network.rest_position.cols(); ++i) {
      const auto node = static_cast<std::size_t>(i);
      Triple place{};
      for (int axis = 0; axis < 3; ++axis) {
        place[static_cast<std::size_t>(axis)] =
            Extended(network.rest_position(axis, i)) +
            (displaced ? Extended(network.initial_displacement(axis, i)) : Extended(0));
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
  ExtendedState initial_state() const override {
    ExtendedState y(2 * dof() + branches_, 0);
    const NodeVectors& velocity = problem_.network().initial_velocity;
    if (velocity.cols() == 0) { return y; }
    for (std::size_t c = 0; c < dof(); ++c) {
      const auto node = static_cast<Eigen::Index>(moving_[c / 3]);
      y[dof() + c] = velocity(static_cast<Eigen::Index>(c % 3), node);
    }
    return y;
  }

  Extended initial_position(std::size_t coordinate) const override {
    return place_[moving_[coordinate / 3]][coordinate % 3];
  }

  void derivative(Extended t, double gate, const ExtendedState& y, ExtendedState& dy) override {
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
      const Extended mass = problem_.network().mass(static_cast<Eigen::Index>(moving_[c / 3]));
      dy[dof() + c] =
          dy[dof() + c] / mass + Extended(problem_.gravity()(static_cast<Eigen::Index>(c % 3)));
    }
  }

 private:
  void add_spring(const Spring& spring, const ExtendedState& y, ExtendedState& dy) const {
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
    const Extended length =
        std::sqrt(apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2]);
    if (length < 1e-12L) { return; }
    const Extended shortening =
        (apart[0] * closing[0] + apart[1] * closing[1] + apart[2] * closing[2]) / length;
    const Extended stretch = (length - Extended(spring.rest_length)) / Extended(spring.rest_length);
    Extended pull = Extended(spring.stiffness) * Extended(spring.rest_length) *
                    (spring.law > 0 ? stiffened(law(spring.law).stiffening, stretch) : stretch);
    pull = relaxed(spring.law, pull, y, dy) - Extended(spring.viscosity) * shortening;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const Extended component = pull * apart[axis] / length;
      if (offset[0] >= 0) { dy[dof() + static_cast<std::size_t>(offset[0]) + axis] += component; }
      if (offset[1] >= 0) { dy[dof() + static_cast<std::size_t>(offset[1]) + axis] -= component; }
    }
  }

  /// Adds the forces of a cell, from the twelve edges along its axes. The volume at a corner is the
  /// determinant of its three edges, and an edge has the cross product of the other two as
  /// gradient.
  void add_cell(const VolumeCell& cell, const ExtendedState& y, ExtendedState& dy) const {
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
    std::array<Extended, 8> volume{};
    Extended mean = 0;
    Extended rate = 0;
    const Extended whole = cell.volume;
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
    const Extended resisting = relaxed(cell.law, Extended(cell.stiffness) * (mean - 1), y, dy);
    for (std::size_t n = 0; n < 8; ++n) {
      const Extended pressure = (resisting + Extended(cell.viscosity) * rate +
                                 Extended(cell.collapse) * collapse_slope(volume[n])) /
                                8;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t c = 0; c < 3; ++c) {
          const Extended force = pressure * gradient[n][axis][c];
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
  static Extended stiffened(const Stiffening& s, Extended stretch) {
    const Extended largest = s.largest;
    const Extended size = std::abs(stretch);
    const Extended sign = stretch < 0 ? -1 : 1;
    if (s.law == Stiffening::Law::exponential) {
      const Extended a = s.rate;
      if (a == 0) { return stretch; }
      const Extended end = std::log(largest) / a;
      if (size <= end) { return sign * std::expm1(a * size) / a; }
      return sign * ((largest - 1) / a + largest * (size - end));
    }
    const Extended b = s.quadratic;
    const Extended c = s.cubic;
    const auto bent = [&](Extended e) { return e * (1 + e * (b + c * e)); };
    const auto slope = [&](Extended e) { return 1 + e * (2 * b + 3 * c * e); };
    if (slope(size) <= largest) { return sign * bent(size); }
    Extended low = 0;
    Extended high = size;
    for (int n = 0; n < 200; ++n) {
      const Extended middle = (low + high) / 2;
      (slope(middle) <= largest ? low : high) = middle;
    }
    return sign * (bent(low) + largest * (size - low));
  }
  /// Returns what the branches of the next element leave of its elastic tension, and writes the
  /// rates of their tensions.
  Extended relaxed(int number, Extended tension, const ExtendedState& y, ExtendedState& dy) const {
    if (number == 0) { return tension; }
    Extended left = tension;
    for (const RelaxationBranch& branch : law(number).branches) {
      left -= Extended(branch.share) * y[branch_];
      dy[branch_] = (tension - y[branch_]) / Extended(branch.time);
      ++branch_;
    }
    return left;
  }

  /// Slope of -J_b (1 - s)^2 ln s, s = J / J_b, with J_b = 0.3; linear below s = 0.1.
  static Extended collapse_slope(Extended j) {
    if (j >= 0.3L) { return 0; }
    const Extended s = std::max(j / 0.3L, 0.1L);
    const Extended slope = (1 - s) * (2 * std::log(s) - (1 - s) / s);
    if (j >= 0.03L) { return slope; }
    const Extended curvature = (4 / s - 4 + (1 - s) * (1 - s) / (s * s) - 2 * std::log(s)) / 0.3L;
    return slope + (j - 0.03L) * curvature;
  }

  void add_force(int node, std::size_t axis, Extended force, ExtendedState& dy) const {
    const std::ptrdiff_t offset = offset_[static_cast<std::size_t>(node)];
    if (offset >= 0) { dy[dof() + static_cast<std::size_t>(offset) + axis] += force; }
  }

  void add_loads(Extended t, double gate, ExtendedState& dy) const {
    for (const Load& load : problem_.loads()) {
      if (!(load.start <= gate && gate < load.end)) { continue; }
      Extended strength = 1;
      if (load.profile != Profile::constant) {
        strength = (t - Extended(load.start)) / (Extended(load.end) - Extended(load.start));
      }
      if (load.profile == Profile::half_sine) {
        strength = std::sin(std::numbers::pi_v<Extended> * strength);
      }
      for (const int node : load.nodes) {
        const std::ptrdiff_t offset = offset_[static_cast<std::size_t>(node)];
        for (std::size_t axis = 0; offset >= 0 && axis < 3; ++axis) {
          dy[dof() + static_cast<std::size_t>(offset) + axis] +=
              strength * Extended(load.force(static_cast<Eigen::Index>(axis)));
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

/// Returns the equations, or null for an unknown kind of problem.
std::unique_ptr<ExtendedEquations> extended_equations(const Problem& problem) {
  if (const auto* oscillator = dynamic_cast<const OscillatorProblem*>(&problem)) {
    return std::make_unique<OscillatorEquations>(oscillator->oscillator());
  }
  if (const auto* network = dynamic_cast<const NetworkProblem*>(&problem)) {
    return std::make_unique<NetworkEquations>(*network);
  }
  return nullptr;
}

}  // namespace

Trace solve_odeint_dormand_prince(const Problem& problem, const std::vector<double>& times,
                                  const Tolerance& tolerance) {
  ProblemEquations equations(problem);
  return solve<boost::numeric::odeint::runge_kutta_dopri5>("odeint-dormand-prince-5-4", equations,
                                                           problem, times, tolerance);
}

Trace solve_long_double(const Problem& problem, const std::vector<double>& times,
                        const Tolerance& tolerance) {
  constexpr const char* name = "long-double-fehlberg-7-8";
  const auto equations = extended_equations(problem);
  if (!equations) { throw SolverError(std::string(name) + ": only networks and the oscillator"); }
  return solve<boost::numeric::odeint::runge_kutta_fehlberg78>(name, *equations, problem, times,
                                                               tolerance);
}

}  // namespace palpate::reference
