// SPDX-License-Identifier: MIT
/// Every scheme against its own closed form, to rounding.

#include <cmath>
#include <limits>

#include "model/stepping/integrator.hpp"
#include "reference/discrete.hpp"
#include "validation/cases/oscillator_parts.hpp"
#include "validation/cases/oscillator_setting.hpp"

namespace palpate::oscillator {

namespace {

using reference::Amplification;
using reference::DiscreteState;

constexpr double epsilon = std::numeric_limits<double>::epsilon();

/// Floating-point operations of one step; an implicit one stops within 64 eps of its solution.
double operations(std::string_view scheme) {
  if (scheme == "rk4") { return 60.0; }
  if (scheme == "leapfrog") { return 30.0; }
  if (scheme == "velocity-verlet") { return 24.0; }
  if (scheme.starts_with("implicit")) { return 64.0 + 30.0; }
  return 10.0;
}

struct Closed {
  std::vector<double> position;
  std::vector<double> velocity;  ///< at the instant of the position, as the model gives it
  std::vector<double>
      rounding;  ///< what one eps per operation and step can add up to, per operation
};

Closed closed_form(std::string_view scheme, const Oscillator& oscillator, double h, long steps) {
  const auto omega = static_cast<long double>(natural_frequency(oscillator));
  const Amplification one = reference::amplification(scheme, oscillator, h);
  const bool staggered = reference::velocity_is_staggered(scheme);
  std::vector<long double> size;   // |state| in (x, v / omega0)
  std::vector<long double> power;  // |A^n| likewise
  Closed closed;
  Amplification product = Amplification::Identity();
  DiscreteState last = DiscreteState::Zero();
  for (long n = 0; n <= steps; ++n) {
    const DiscreteState state = reference::discrete_state(scheme, oscillator, h, n);
    size.push_back(std::hypot(state(0), state(1) / omega));
    Amplification weighted = product;
    weighted(0, 1) *= omega;
    weighted(1, 0) /= omega;
    power.push_back(weighted.norm());
    product = (one * product).eval();
    const long double v = n == 0      ? static_cast<long double>(oscillator.velocity)
                          : staggered ? (last(1) + state(1)) / 2
                                      : state(1);
    last = state;
    closed.position.push_back(static_cast<double>(state(0)));
    closed.velocity.push_back(static_cast<double>(v));
    long double sum = 0;
    for (std::size_t k = 0; k < size.size(); ++k) { sum += power[size.size() - 1 - k] * size[k]; }
    closed.rounding.push_back(static_cast<double>(sum) * epsilon);
  }
  return closed;
}

/// Largest difference in units of one eps per step, carried on as the scheme carries it.
double rounding_per_step(const Samples& found, const Closed& closed, double omega) {
  if (found.position.size() != closed.position.size()) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  double largest = 0.0;
  for (std::size_t n = 0; n < closed.position.size(); ++n) {
    const double dx = found.position[n] - closed.position[n];
    const double dv = (found.velocity[n] - closed.velocity[n]) / omega;
    largest = worse(largest, std::hypot(dx, dv) / closed.rounding[n]);
  }
  return largest;
}

void measure_discrete(const CaseContext& context, Outcome& outcome, std::string_view scheme) {
  const long steps = context.quick ? 200 : 500;
  const double limit = operations(scheme);
  Figure figure{.id = "difference",
                .title = "Model minus closed form of " + std::string(scheme),
                .caption =
                    "The position differs from the scheme's own closed form by rounding "
                    "only, at every step and damping.",
                .x = {.label = "time (s)"},
                .y = {.label = "absolute difference (m)", .logarithmic = true}};
  const auto judge = [&](const std::string& label, const Oscillator& oscillator, double h) {
    const Samples found = samples_of(run(context, oscillator, scheme, h, steps));
    const Closed closed = closed_form(scheme, oscillator, h, steps);
    outcome.judge({.name = "rounding per step, " + label,
                   .value = rounding_per_step(found, closed, natural_frequency(oscillator)),
                   .unit = "eps",
                   .upper = limit,
                   .bound_from = "one eps for each of the " + text(limit) +
                                 " operations of a step, carried on by the powers of its matrix"});
    Series series{.label = label, .style = Series::Style::points};
    for (std::size_t n = 0; n < found.position.size() && n < closed.position.size(); ++n) {
      const double difference = std::abs(found.position[n] - closed.position[n]);
      if (!(difference > 0.0)) { continue; }  // a logarithmic axis has no zero
      series.x.push_back(found.time[n]);
      series.y.push_back(difference);
    }
    figure.series.push_back(std::move(series));
  };
  for (const double c : {0.0, 0.1, 1.0, 2.0, 3.0}) {
    judge("c = " + text(c) + " N s/m", paper_oscillator(c), 0.1);
  }
  // Neither mass nor stiffness nor initial velocity of one or zero hides a factor.
  judge("m = 0.7 kg, k = 3 N/m, c = 0.4 N s/m",
        {.mass = 0.7, .stiffness = 3.0, .viscosity = 0.4, .displacement = 0.3, .velocity = -1.1},
        0.08);
  outcome.figures.push_back(std::move(figure));
}

}  // namespace

std::vector<Case> discrete_cases() {
  std::vector<Case> cases;
  for (const IntegratorInfo* info : integrators()) {
    const std::string scheme(info->name);
    cases.push_back(
        {.name = "oscillator/discrete/" + scheme,
         .suite = "accuracy",
         .claim = "The model steps " + scheme + " exactly as its definition says, to rounding.",
         .measure = [scheme](const CaseContext& context,
                             Outcome& outcome) { measure_discrete(context, outcome, scheme); },
         .weight = 0.3});
  }
  return cases;
}

}  // namespace palpate::oscillator
