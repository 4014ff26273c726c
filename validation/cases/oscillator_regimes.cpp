// SPDX-License-Identifier: MIT
/// The exact motion of every regime against evaluations that know no regimes.

#include <cmath>
#include <limits>
#include <numbers>

#include "reference/cvode.hpp"
#include "reference/long_double.hpp"
#include "validation/cases/oscillator_parts.hpp"
#include "validation/cases/oscillator_setting.hpp"

namespace palpate::oscillator {

namespace {

using Extended = long double;
using Generator = Eigen::Matrix<Extended, 4, 4>;
using ExtendedVector = Eigen::Matrix<Extended, 4, 1>;

constexpr double sampling = 0.25;  ///< [s]
constexpr long sample_count = 100;

/// d/dt (x, v, cos W t, sin W t): one linear system, whatever the regime.
Generator generator_of(const Oscillator& o) {
  const Extended mass = o.mass;
  const Extended w = o.drive_frequency;
  Generator g = Generator::Zero();
  g(0, 1) = 1;
  g(1, 0) = -static_cast<Extended>(o.stiffness) / mass;
  g(1, 1) = -static_cast<Extended>(o.viscosity) / mass;
  g(1, 2) = static_cast<Extended>(o.drive_amplitude) / mass;
  g(2, 3) = -w;
  g(3, 2) = w;
  return g;
}

/// Its motion by Taylor series from sample to sample, in long double.
Samples taylor_motion(const Oscillator& o) {
  const Generator g = generator_of(o);
  ExtendedVector y(o.displacement, o.velocity, 1, 0);
  Samples samples{.time = instants(sampling, sample_count)};
  for (long n = 0; n <= sample_count; ++n) {
    samples.position.push_back(static_cast<double>(y(0)));
    samples.velocity.push_back(static_cast<double>(y(1)));
    ExtendedVector term = y;
    for (int k = 1; k <= 40; ++k) {  // |g| h < 1: the last term is below 1e-47
      term = (g * term * static_cast<Extended>(sampling) / static_cast<Extended>(k)).eval();
      y += term;
    }
  }
  return samples;
}

/// Largest difference over the size of (x, v / omega0) then, or, for a driven motion, so far.
double relative_difference(const Oscillator& o, const Samples& found, const Samples& truth) {
  if (found.position.size() != truth.position.size()) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const double omega = natural_frequency(o);
  double so_far = 0.0;
  double largest = 0.0;
  for (std::size_t n = 0; n < truth.time.size(); ++n) {
    const double size = std::hypot(truth.position[n], truth.velocity[n] / omega);
    so_far = o.drive_amplitude == 0.0 ? size : std::max(so_far, size);
    if (so_far == 0.0) { continue; }  // rest before the drive has acted
    largest = worse(largest, std::hypot(found.position[n] - truth.position[n],
                                        (found.velocity[n] - truth.velocity[n]) / omega) /
                                 so_far);
  }
  return largest;
}

struct Named {
  std::string name;
  Oscillator oscillator;
};

std::vector<Named> regimes() {
  std::vector<Named> all;
  const auto add = [&all](const std::string& name, double c, double v0 = 0.0, double drive = 0.0,
                          double frequency = 0.0) {
    Oscillator o = paper_oscillator(c);
    o.velocity = v0;
    o.drive_amplitude = drive;
    o.drive_frequency = frequency;
    if (drive != 0.0) { o.displacement = 0.0; }
    all.push_back({name, o});
  };
  for (const double c : swept_viscosities) { add("c = " + text(c), c); }
  for (const double gap : {1e-3, 1e-6, 1e-9, 1e-12, 1e-15}) {
    add("S = 1 - " + text(gap), 2.0 * (1.0 - gap), 0.5);
    add("S = 1 + " + text(gap), 2.0 * (1.0 + gap), 0.5);
  }
  for (const double s : {-0.05, -0.5, -1.0, -1.5}) { add("S = " + text(s), 2.0 * s); }
  add("driven below resonance", 0.1, 0.0, 1.0, 0.5);
  add("driven at resonance, damped", 0.1, 0.0, 1.0, 1.0);
  add("driven at resonance, undamped", 0.0, 0.0, 1.0, 1.0);
  add("driven 1e-9 beside resonance", 0.0, 0.0, 1.0, 1.0 + 1e-9);
  add("driven above resonance", 0.3, 0.0, 1.0, 3.0);
  add("driven, critically damped", 2.0, 0.0, 1.0, 0.7);
  add("driven, overdamped", 3.0, 0.0, 1.0, 0.7);
  add("pushed by a constant force", 0.7, 0.0, 1.0, 0.0);
  return all;
}

void judge_closed_form(Outcome& outcome) {
  Table table{.id = "differences",
              .title = "Exact motion against a Taylor series in long double",
              .caption = "Largest difference over 25 s relative to the motion then, by regime.",
              .columns = {"motion", "S (1)", "class", "relative difference (1)"}};
  Figure figure{.id = "regimes",
                .title = "One oscillator, all regimes",
                .caption =
                    "The exact free motion passes smoothly from undamped through critical "
                    "(c = 2) to overdamped (c = 3).",
                .x = {.label = "time (s)"},
                .y = {.label = "position (m)"}};
  double free = 0.0;
  double near_critical = 0.0;
  double driven = 0.0;
  for (const Named& one : regimes()) {
    const Samples truth = taylor_motion(one.oscillator);
    const Samples found = exact_samples(one.oscillator, truth.time);
    const double difference = relative_difference(one.oscillator, found, truth);
    const bool is_driven = one.oscillator.drive_amplitude != 0.0;
    double& worst = is_driven ? driven : one.name.starts_with("S = 1") ? near_critical : free;
    worst = worse(worst, difference);
    table.rows.push_back({one.name, damping_ratio(one.oscillator),
                          std::string(damping_class(one.oscillator)), difference});
    if (one.name.starts_with("c = ")) {
      figure.series.push_back({.label = one.name, .x = found.time, .y = found.position});
    }
  }
  const auto judge = [&](const std::string& name, double value) {
    outcome.judge({.name = name,
                   .value = value,
                   .upper = 1e-13,
                   .bound_from = "the closed form is required to 1e-13; the series errs by 1e-17"});
  };
  judge("free motion", free);
  judge("free motion within 1e-3 of critical damping", near_critical);
  judge("driven motion", driven);
  outcome.tables.push_back(std::move(table));
  outcome.figures.push_back(std::move(figure));
}

/// Two solvers that somebody else wrote, on the equation of motion itself.
void judge_solvers(Outcome& outcome) {
  const std::vector<double> times = instants(sampling, sample_count);
  const auto judge = [&](const std::string& name, const Oscillator& oscillator) {
    const OscillatorProblem problem(oscillator);
    const Samples exact = exact_samples(oscillator, times);
    const auto difference = [&](const reference::Solution& solution) {
      const Samples found{.time = times,
                          .position = {solution.position.data(),
                                       solution.position.data() + solution.position.size()},
                          .velocity = {solution.velocity.data(),
                                       solution.velocity.data() + solution.velocity.size()}};
      return peak_distance(exact.position, found.position);
    };
    const auto accurate = reference::solve_long_double(problem, times, {1e-16, 1.0, 1.0});
    outcome.judge({.name = name + ", Fehlberg 7(8) in long double",
                   .value = difference(accurate),
                   .upper = 1e-13,
                   .bound_from = "the closed form is required to 1e-13"});
    const double tolerance = 1e-11;
    const auto adams = reference::solve_cvode_adams(problem, times, {tolerance, 1.0, 1.0});
    outcome.judge(
        {.name = name + ", CVODE Adams",
         .value = difference(adams),
         .upper = 2.0 * std::numbers::sqrt2 * tolerance * static_cast<double>(adams.steps),
         .bound_from = "its local errors, an RMS of 1e-11 (1 + |y|) over two states, add "
                       "up over its " +
                       std::to_string(adams.steps) + " steps at most"});
  };
  for (const double c : {0.0, 0.1, 2.0, 3.0}) { judge("c = " + text(c), paper_oscillator(c)); }
  judge("driven", driven_oscillator());
}

/// The model's own classical Runge-Kutta at a small step, in every regime that does not grow.
void judge_model(const CaseContext& context, Outcome& outcome) {
  const double h = 0.02;
  const long steps = 1250;
  double worst = 0.0;
  for (const Named& one : regimes()) {
    const Oscillator& o = one.oscillator;
    if (o.viscosity < 0.0) { continue; }
    const Samples found = samples_of(run(context, o, "rk4", h, steps));
    const double error =
        peak_distance(found.position, exact_samples(o, instants(h, steps)).position);
    // The energy norm never grows, so local errors of (h |G|)^5 / 120 only add up; a drive of unit
    // force adds its own size to that of the motion.
    const double norm = static_cast<double>(generator_of(o).norm());
    const double bound = static_cast<double>(steps) * std::pow(h * norm, 5.0) / 120.0;
    worst = worse(worst, error / bound);
  }
  outcome.judge({.name = "Runge-Kutta run over its error bound",
                 .value = worst,
                 .upper = 1.0,
                 .bound_from = "Taylor remainder (h |G|)^5 / 120 per step"});
}

void measure_regimes(const CaseContext& context, Outcome& outcome) {
  judge_closed_form(outcome);
  judge_solvers(outcome);
  judge_model(context, outcome);
  Table names{.id = "classes",
              .title = "Classes of damping",
              .caption = "What the paper's settings are, with m = 1 kg and k = 1 N/m.",
              .columns = {"c (N s/m)", "S (1)", "class", "the paper's text"}};
  int agreeing = 0;
  for (const double c : swept_viscosities) {
    const Oscillator o = paper_oscillator(c);
    const std::string found = damping_class(o);
    const std::string expected = c == 0.0   ? "undamped"
                                 : c < 2.0  ? "underdamped"
                                 : c == 2.0 ? "critically damped"
                                            : "overdamped";
    agreeing += found == expected ? 1 : 0;
    names.rows.push_back({c, damping_ratio(o), found,
                          std::string(c == 0.7   ? "overdamped"
                                      : c == 1.8 ? "critically damped"
                                                 : "")});
  }
  outcome.judge({.name = "settings in the class that c^2 - 4 m k says",
                 .value = static_cast<double>(agreeing),
                 .lower = static_cast<double>(swept_viscosities.size()),
                 .bound_from = "sign of c^2 - 4 m k"});
  outcome.tables.push_back(std::move(names));
  outcome.notes.emplace_back(
      "The paper's text calls c = 0.7 N s/m overdamped and c = 1.8 N s/m critically damped; with "
      "m = 1 kg and k = 1 N/m they have S = 0.35 and S = 0.9 and are both underdamped. Critical "
      "damping is c = 2 N s/m.");
}

}  // namespace

std::vector<Case> regime_cases() {
  return {{.name = "oscillator/regimes",
           .suite = "accuracy",
           .claim = "The exact motion is right to 1e-13 in every regime, driven or not.",
           .measure = measure_regimes,
           .weight = 1.0}};
}

}  // namespace palpate::oscillator
