// SPDX-License-Identifier: MIT
#include "reference/long_double.hpp"

#include <algorithm>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>
#include <boost/version.hpp>
#include <chrono>
#include <cmath>
#include <limits>
#include <string>

#include "reference/extended_equations.hpp"
#include "reference/march.hpp"

namespace palpate::reference {

namespace {

constexpr const char* name = "long-double-fehlberg-7-8";

/// Step control of our own: tolerances per coordinate, exact stops, and an end to every run.
class AdaptiveFehlberg {
 public:
  AdaptiveFehlberg(const ExtendedEquations& equations, const Tolerance& tolerance)
      : equations_(equations),
        tolerance_(tolerance),
        state_(equations.initial_state()),
        trial_(state_),
        error_(state_) {}

  [[nodiscard]] const ExtendedState& state() const { return state_; }
  [[nodiscard]] long steps() const { return steps_; }
  [[nodiscard]] long evaluations() const { return evaluations_; }

  void begin(const Segment& segment) {
    time_ = segment.start;
    gate_ = segment.gate;
    max_step_ = segment.max_step;
    step_ = max_step_ / 100;
  }

  void advance(Extended end) {
    const long last_step = steps_ + step_limit;
    while (time_ < end) {
      const bool reaches_end = time_ + step_ >= end;
      const Extended h = reaches_end ? end - time_ : step_;
      const Extended size = attempt(h);
      if (!std::isfinite(size)) {
        fail(name, "do_step", "a result that is not finite", double(time_), "");
      }
      if (size <= 1) {
        state_.swap(trial_);
        time_ = reaches_end ? end : time_ + h;
        ++steps_;
      }
      const Extended factor =
          std::clamp(Extended(0.9L) * std::pow(std::max(size, Extended(1e-10L)), -1 / Extended(8)),
                     Extended(0.2L), Extended(4));
      if (size > 1 || factor * h > step_ || !reaches_end) {
        step_ = std::min(h * factor, max_step_);
      }
      if (step_ < 1e-16L * max_step_ || steps_ > last_step) {
        fail(name, "do_step", "a vanishing step or too many steps", double(time_), "");
      }
    }
  }

 private:
  /// Error of a step of h over its tolerance; the new state is in trial_.
  Extended attempt(Extended h) {
    const auto system = [this](const ExtendedState& y, ExtendedState& dy, Extended t) {
      ++evaluations_;
      equations_.derivative(t, gate_, y, dy);
    };
    stepper_.do_step(system, state_, time_, trial_, h, error_);
    Extended largest = 0;
    const std::size_t n = equations_.dof();
    for (std::size_t c = 0; c < 2 * n; ++c) {
      const Extended scale = c < n ? tolerance_.position_scale : tolerance_.velocity_scale;
      const Extended size =
          std::abs(error_[c]) / (Extended(tolerance_.relative) * (scale + std::abs(state_[c])));
      if (!std::isfinite(size) || !std::isfinite(trial_[c])) {
        return std::numeric_limits<Extended>::quiet_NaN();  // max() would drop it
      }
      largest = std::max(largest, size);
    }
    return largest;
  }

  const ExtendedEquations& equations_;
  Tolerance tolerance_;
  boost::numeric::odeint::runge_kutta_fehlberg78<ExtendedState, Extended> stepper_{};
  ExtendedState state_, trial_, error_;
  Extended time_ = 0, step_ = 0, max_step_ = 0;
  double gate_ = 0.0;
  long steps_ = 0;
  long evaluations_ = 0;
};

void store(const ExtendedEquations& equations, const ExtendedState& y, std::size_t output,
           Solution& solution) {
  const std::size_t n = equations.dof();
  for (std::size_t c = 0; c < n; ++c) {
    const auto row = static_cast<Eigen::Index>(c);
    const auto column = static_cast<Eigen::Index>(output);
    solution.position(row, column) = static_cast<double>(equations.initial_position(c) + y[c]);
    solution.velocity(row, column) = static_cast<double>(y[n + c]);
  }
}

}  // namespace

Solution solve_long_double(const Problem& problem, const std::vector<double>& times,
                           const Tolerance& tolerance) {
  const auto begun = std::chrono::steady_clock::now();
  const auto equations = extended_equations(problem);
  if (!equations) { throw SolverError(std::string(name) + ": only networks and the oscillator"); }
  const std::vector<Segment> segments = segments_of(problem, times);
  AdaptiveFehlberg integrator(*equations, tolerance);
  Solution solution{.solver = name,
                    .version = std::string("Boost.odeint ") + BOOST_LIB_VERSION,
                    .relative_tolerance = tolerance.relative,
                    .time = times};
  solution.position.resize(problem.dof(), static_cast<Eigen::Index>(times.size()));
  solution.velocity.resizeLike(solution.position);
  store(*equations, integrator.state(), 0, solution);
  for (const Segment& segment : segments) {
    integrator.begin(segment);
    for (const Stop& stop : segment.stops) {
      integrator.advance(stop.time);
      if (stop.output) { store(*equations, integrator.state(), *stop.output, solution); }
    }
  }
  if (!solution.position.allFinite() || !solution.velocity.allFinite()) {
    throw SolverError(std::string(name) + ": the solution is not finite as double");
  }
  solution.steps = integrator.steps();
  solution.evaluations = integrator.evaluations();
  solution.seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return solution;
}

}  // namespace palpate::reference
