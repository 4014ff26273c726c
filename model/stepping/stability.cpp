// SPDX-License-Identifier: MIT
#include "model/stepping/stability.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include <Eigen/LU>

#include "model/stepping/oscillator_system.hpp"

namespace palpate {

namespace {

/// What the conditions of stability may be missed by: rounding.
constexpr double rounding = 1e-13;

/// Of the fastest rate: a scheme that amplifies so short a step is taken to amplify every one.
constexpr double shortest_step = 1e-4;
constexpr double longest_step = 100.0;

/// One scheme on oscillators of unit mass, with workspace made once.
class ScalarStepper {
 public:
  ScalarStepper(const IntegratorInfo& scheme, double omega, double damping)
      : system_({.mass = 1.0, .stiffness = omega * omega, .viscosity = damping}),
        scheme_(scheme.make<double>()),
        state_{Eigen::VectorXd::Zero(1), Eigen::VectorXd::Zero(1)},
        implicit_(scheme.implicit) {
    if (!implicit_) { scheme_->prepare(system_, state_, 1.0); }
  }

  /// Of (position, h times velocity) over one step.
  Eigen::Matrix2d step_matrix(double h) {
    if (implicit_) { scheme_->prepare(system_, state_, h); }
    Eigen::Matrix2d step;
    for (int column = 0; column < 2; ++column) {
      state_.position(0) = column == 0 ? 1.0 : 0.0;
      state_.velocity(0) = column == 0 ? 0.0 : 1.0 / h;  // scaled: position per step
      scheme_->step(system_, state_, 0.0, h);
      step.col(column) << state_.position(0), state_.velocity(0) * h;
    }
    return step;
  }

 private:
  OscillatorSystem<double> system_;
  std::unique_ptr<Integrator<double>> scheme_;
  State<double> state_;
  bool implicit_;
};

/// Both eigenvalues within the unit circle, by the conditions of Jury: unlike the eigenvalues
/// themselves these lose no digits where two of them meet.
bool keeps_bounded(const Eigen::Matrix2d& step) {
  const double determinant = step.determinant();
  return determinant <= 1.0 + rounding && std::abs(step.trace()) <= 1.0 + determinant + rounding;
}

/// As stable_step(); what is `enough` or longer counts as infinite.
double stable_step_below(double enough, const IntegratorInfo& scheme, double omega, double damping) {
  const double rate = std::max(omega, damping);
  if (scheme.implicit || !(rate > 0.0)) { return std::numeric_limits<double>::infinity(); }
  ScalarStepper stepper(scheme, omega, damping);
  const auto stable = [&](double h) { return keeps_bounded(stepper.step_matrix(h)); };
  if (!stable(shortest_step / rate)) { return 0.0; }
  // Upwards in steps of 5 % until the first growth, then bisection.
  double low = shortest_step / rate;
  double high = 10.0 * low;
  const double longest = std::min(enough, longest_step / rate);
  while (low < longest && stable(high)) {
    low = high;
    high *= 1.05;
  }
  if (low >= longest) { return std::numeric_limits<double>::infinity(); }
  for (int n = 0; n < 45; ++n) {
    const double middle = 0.5 * (low + high);
    (stable(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace

double amplification(const IntegratorInfo& scheme, double omega, double damping, double h) {
  const Eigen::Matrix2d step = ScalarStepper(scheme, omega, damping).step_matrix(h);
  const double half_trace = 0.5 * step.trace();
  const std::complex<double> root =
      std::sqrt(std::complex<double>(half_trace * half_trace - step.determinant(), 0.0));
  return std::max(std::abs(half_trace + root), std::abs(half_trace - root));
}

double stable_step(const IntegratorInfo& scheme, double omega, double damping) {
  return stable_step_below(std::numeric_limits<double>::infinity(), scheme, omega, damping);
}

double stable_step(const IntegratorInfo& scheme, const SpectralBounds& bounds) {
  if (scheme.implicit) { return std::numeric_limits<double>::infinity(); }
  constexpr int grid = 12;
  double smallest = std::numeric_limits<double>::infinity();
  for (int i = grid; i >= 0; --i) {  // from the fastest oscillator, which mostly decides, to pure drag (omega = 0)
    const double omega = bounds.omega_upper * i / grid;
    const double least = std::min(bounds.relaxation_lower * omega * omega, bounds.damping_upper);
    for (int j = 0; j <= grid; ++j) {
      const double damping = least + (bounds.damping_upper - least) * j / grid;
      smallest = std::min(smallest, stable_step_below(smallest, scheme, omega, damping));
    }
  }
  return smallest;
}

}  // namespace palpate
