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
#include "reference/network_equations.hpp"
#include "reference/solvers.hpp"

namespace palpate::reference {

namespace {

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

/// Returns the equations, or null for an unknown kind of problem.
std::unique_ptr<ExtendedEquations> extended_equations(const Problem& problem) {
  if (const auto* oscillator = dynamic_cast<const OscillatorProblem*>(&problem)) {
    return std::make_unique<OscillatorEquations>(oscillator->oscillator());
  }
  if (const auto* network = dynamic_cast<const NetworkProblem*>(&problem)) {
    return std::make_unique<NetworkEquations<Extended>>(*network);
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
