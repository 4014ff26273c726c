// SPDX-License-Identifier: MIT

#include <algorithm>
#include <boost/numeric/odeint/stepper/controlled_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <boost/version.hpp>
#include <cmath>
#include <limits>

#include "reference/integrate.hpp"
#include "reference/solvers.hpp"

namespace palpate::reference {

namespace {

namespace odeint = boost::numeric::odeint;
using State = std::vector<double>;

/// Error norm: largest |error| relative to its tolerance, as in the library's checker, but with an
/// absolute tolerance for each component, because positions and velocities need different ones.
class ErrorOfComponents {
 public:
  using value_type = double;
  using algebra_type = odeint::range_algebra;
  using operations_type = odeint::default_operations;

  ErrorOfComponents(double relative, State absolute)
      : relative_(relative), absolute_(std::move(absolute)) {}

  template <class Algebra>
  double error(Algebra&, const State& before, const State& rate, State& error, double h) const {
    double worst = 0.0;
    for (std::size_t i = 0; i < error.size(); ++i) {
      const double size = std::abs(before[i]) + std::abs(h * rate[i]);
      const double share = std::abs(error[i]) / (absolute_[i] + relative_ * size);
      if (std::isnan(share)) { return std::numeric_limits<double>::infinity(); }
      worst = std::max(worst, share);
    }
    return worst;
  }

 private:
  double relative_;
  State absolute_;
};

class DormandPrince final : public Integrator {
  using Stepper = odeint::runge_kutta_dopri5<State>;
  using Controlled = odeint::controlled_runge_kutta<Stepper, ErrorOfComponents>;

 public:
  DormandPrince(std::string name, const Problem& problem, const Tolerance& tolerance)
      : name_(std::move(name)),
        system_(problem),
        state_(static_cast<std::size_t>(system_.size())),
        absolute_(state_.size(), tolerance.relative * tolerance.velocity_scale),
        stepper_(checker(tolerance)) {
    system_.initial_state(state_.data());
  }

  [[nodiscard]] FirstOrderSystem& system() { return system_; }

  void begin(const Segment& segment) override {
    stepper_.reset();  // the stored derivative belongs to other loads
    time_ = segment.start;
    longest_ = segment.max_step;
    shortest_ = 1e-12 * (segment.end - segment.start);
    next_ = 1e-3 * longest_;
    steps_ = 0;
  }

  void advance(double time) override {
    while (time - time_ > shortest_) {
      const double wanted = std::min(next_, longest_);
      double h = std::min(wanted, time - time_);
      const bool shortened = h < wanted;
      const auto result = stepper_.try_step(
          [this](const State& y, State& dy, double t) { evaluate(y, dy, t); }, state_, time_, h);
      if (result == odeint::success) {
        ++steps_;
        next_ = shortened ? std::max(h, wanted) : h;  // a step cut for a stop says little
      } else {
        next_ = h;
        if (h < shortest_) { fail(name_, "try_step", "a step of no length", time_, ""); }
      }
      if (steps_ > step_limit) { fail(name_, "try_step", "too many steps", time_, ""); }
    }
    time_ = time;
  }

  [[nodiscard]] const double* state() const override { return state_.data(); }
  [[nodiscard]] long segment_steps() const override { return steps_; }

 private:
  ErrorOfComponents checker(const Tolerance& tolerance) {
    std::fill_n(absolute_.begin(), system_.dof(), tolerance.relative * tolerance.position_scale);
    return {tolerance.relative, absolute_};
  }

  void evaluate(const State& y, State& dy, double t) {
    bool finite = false;
    try {
      finite = system_.derivative(t, y.data(), dy.data());
    } catch (const std::exception& error) {
      fail(name_, "try_step", "an exception", t, error.what());
    }
    if (!finite) { fail(name_, "try_step", "an error", t, "the right-hand side is not finite"); }
  }

  std::string name_;
  FirstOrderSystem system_;
  State state_;
  State absolute_;
  Controlled stepper_;
  double time_ = 0.0;
  double next_ = 0.0;      ///< step proposed by the controller [s]
  double longest_ = 0.0;   ///< [s]
  double shortest_ = 0.0;  ///< [s]
  long steps_ = 0;
};

}  // namespace

Trace solve_odeint_dormand_prince(const Problem& problem, const std::vector<double>& times,
                                  const Tolerance& tolerance) {
  constexpr const char* name = "odeint-dormand-prince-5-4";
  DormandPrince integrator(name, problem, tolerance);
  return integrate({name, std::string("Boost ") + BOOST_LIB_VERSION}, integrator.system(), times,
                   tolerance, integrator);
}

}  // namespace palpate::reference
