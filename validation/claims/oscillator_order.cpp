// SPDX-License-Identifier: MIT
/// Exact motion of every regime compared with evaluations that do not distinguish regimes.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "model/stepping/integrator.hpp"
#include "reference/oscillator.hpp"
#include "reference/solvers.hpp"
#include "validation/claims/oscillator_fixture.hpp"
#include "validation/signal.hpp"

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

/// Judges the closed form with two external solvers for the equation of motion.
void judge_solvers(Outcome& outcome) {
  const std::vector<double> times = instants(sampling, sample_count);
  const auto judge = [&](const std::string& name, const Oscillator& oscillator) {
    const OscillatorProblem problem(oscillator);
    const Samples exact = exact_samples(oscillator, times);
    const auto difference = [&](const Trace& solution) {
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

// Every scheme against its own closed form, to rounding.

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

// Observed order of every scheme on the undamped, the damped and the driven oscillator.

namespace {

/// Taylor expansion of one step against the exact motion (PHYSICS, section 3): what each scheme
/// must show, written down here and not taken from the registry.
struct Theory {
  std::string_view scheme;
  int undamped;
  int damped;
  std::string_view because;
};
constexpr std::array theory{
    Theory{"euler", 1, 1, "one-sided differences"},
    Theory{"euler-cromer", 1, 1, "its velocity belongs half a step away from t = 0"},
    Theory{"feynman-newton", 2, 1, "centred, but the damping uses the velocity of h/2 ago"},
    Theory{"feynman-newton-printed", 1, 1, "its velocity belongs half a step away from t = 0"},
    Theory{"leapfrog", 2, 2, "centred, damping too"},
    Theory{"velocity-verlet", 2, 2, "trapezoidal velocity with a predicted damping"},
    Theory{"rk4", 4, 4, "Taylor series to the fourth power"},
    Theory{"implicit-euler", 1, 1, "one-sided differences"},
    Theory{"implicit-midpoint", 2, 2, "symmetric in time"}};

constexpr double duration = 10.0;  ///< [s] 1.6 periods
constexpr double tolerance = 0.15;
constexpr double round_off = 1e3 * std::numeric_limits<double>::epsilon();

struct Setting {
  std::string name;
  Oscillator oscillator;
  int order;
};

struct Ladder {
  std::vector<double> h;
  std::vector<double> position_error;
  std::vector<double> velocity_error;
};

/// A start from rest is special: there the velocity of a one-sided scheme gains an order.
Oscillator thrown(Oscillator oscillator) {
  oscillator.velocity = 0.6;
  return oscillator;
}

/// Step counts grow by 1.37, so no rung is an integer multiple of another.
Ladder climb(const CaseContext& context, const Setting& setting, std::string_view scheme) {
  const double coarsest = setting.order == 1 ? 800.0 : setting.order == 2 ? 100.0 : 40.0;
  Ladder ladder;
  for (int rung = 0; rung < (context.quick ? 5 : 7); ++rung) {
    const long steps = std::lround(coarsest * std::pow(1.37, rung));
    const double h = duration / static_cast<double>(steps);
    const Samples found = samples_of(run(context, setting.oscillator, scheme, h, steps));
    const Samples exact = exact_samples(setting.oscillator, instants(h, steps));
    ladder.h.push_back(h);
    ladder.position_error.push_back(peak_distance(found.position, exact.position));
    ladder.velocity_error.push_back(peak_distance(found.velocity, exact.velocity));
  }
  return ladder;
}

void judge_slope(Outcome& outcome, const std::string& what, int order, const ObservedOrder& found) {
  const double p = order;
  outcome.judge(
      {.name = "order of " + what,
       .value = found.slope,
       .lower = p - tolerance,
       .upper = p + tolerance,
       .bound_from = "Taylor expansion of one step gives order " + std::to_string(order)});
  outcome.judge({.name = "rungs used for " + what,
                 .value = static_cast<double>(found.rungs),
                 .lower = 4.0,
                 .bound_from = "fewer than four errors show no slope"});
  outcome.judge({.name = "errors of " + what + " fall with h",
                 .value = found.monotone ? 1.0 : 0.0,
                 .lower = 1.0,
                 .bound_from = "convergence"});
  outcome.judge({.name = "r^2 of " + what, .value = found.r_squared});
}

void draw(Figure& figure, const std::string& name, const Ladder& ladder,
          const ObservedOrder& order) {
  figure.series.push_back({.label = name + ", measured",
                           .style = Series::Style::points,
                           .x = ladder.h,
                           .y = ladder.position_error});
  Series fit{.label = name + ", slope " + text(std::round(100.0 * order.slope) / 100.0),
             .style = Series::Style::dashed,
             .x = ladder.h};
  double level = 0.0;  // the line through the middle of the errors
  for (std::size_t n = 0; n < ladder.h.size(); ++n) {
    level += std::log(ladder.position_error[n]) - order.slope * std::log(ladder.h[n]);
  }
  level /= static_cast<double>(ladder.h.size());
  for (const double h : ladder.h) { fit.y.push_back(std::exp(level + order.slope * std::log(h))); }
  figure.series.push_back(std::move(fit));
}

void judge_registry(Outcome& outcome, const IntegratorInfo& info, const Theory& expected) {
  const auto same = [&](const std::string& name, int announced, int order) {
    outcome.judge({.name = name,
                   .value = static_cast<double>(announced),
                   .lower = static_cast<double>(order),
                   .upper = static_cast<double>(order),
                   .bound_from = "Taylor expansion of one step"});
  };
  same("announced order, undamped", info.order_undamped, expected.undamped);
  same("announced order, damped", info.order_damped, expected.damped);
}

void measure_order(const CaseContext& context, Outcome& outcome, const IntegratorInfo& info,
                   const Theory& expected) {
  judge_registry(outcome, info, expected);
  Figure figure{.id = "error-over-step",
                .title = "Convergence of " + std::string(info.name),
                .caption = "Largest position error over " + text(duration) +
                           " s against the exact motion, relative to its peak, falls with the "
                           "step at the slope that the dashed lines show.",
                .x = {.label = "step h (s)", .logarithmic = true},
                .y = {.label = "largest error over peak (1)", .logarithmic = true}};
  Table table{.id = "errors",
              .title = "Errors on the ladder of steps",
              .caption = "Largest errors relative to the peak of the exact motion.",
              .columns = {"oscillator", "h (s)", "position error (1)", "velocity error (1)"}};
  for (const Setting& setting :
       {Setting{"undamped", thrown(paper_oscillator(0.0)), expected.undamped},
        Setting{"damped", thrown(paper_oscillator(0.5)), expected.damped},
        Setting{"driven", thrown(driven_oscillator()), expected.damped}}) {
    const Ladder ladder = climb(context, setting, info.name);
    const ObservedOrder position = observed_order(ladder.h, ladder.position_error, round_off);
    const ObservedOrder velocity = observed_order(ladder.h, ladder.velocity_error, round_off);
    judge_slope(outcome, "position, " + setting.name, setting.order, position);
    judge_slope(outcome, "velocity, " + setting.name, setting.order, velocity);
    draw(figure, setting.name, ladder, position);
    for (std::size_t n = 0; n < ladder.h.size(); ++n) {
      table.rows.push_back(
          {setting.name, ladder.h[n], ladder.position_error[n], ladder.velocity_error[n]});
    }
  }
  outcome.figures.push_back(std::move(figure));
  outcome.tables.push_back(std::move(table));
  outcome.notes.push_back(std::string(info.name) + ": order " + std::to_string(expected.undamped) +
                          " undamped and " + std::to_string(expected.damped) + " damped, because " +
                          std::string(expected.because) + ".");
}

}  // namespace

std::vector<Case> order_cases() {
  std::vector<Case> cases;
  for (const IntegratorInfo* info : integrators()) {
    const auto* expected = std::ranges::find(theory, info->name, &Theory::scheme);
    const std::string orders = expected == theory.end()
                                   ? "a known order"
                                   : "order " + std::to_string(expected->undamped) +
                                         " without damping and " +
                                         std::to_string(expected->damped) + " with it";
    cases.push_back({.name = "oscillator/order/" + std::string(info->name),
                     .suite = "accuracy",
                     .claim = "The error of " + std::string(info->name) + " falls with " + orders +
                              ", driven or not.",
                     .measure =
                         [info, expected](const CaseContext& context, Outcome& outcome) {
                           if (expected == theory.end()) {
                             throw std::invalid_argument("no order is known from theory for " +
                                                         std::string(info->name));
                           }
                           measure_order(context, outcome, *info, *expected);
                         },
                     .weight = 1.0});
  }
  return cases;
}

// All schemes over all dampings.

namespace {

/// Errors of one scheme at one damping for h = 0.1 and 0.01 s against the exact motion, and the
/// same from the closed form.
void sweep_scheme(const CaseContext& context, Outcome& outcome, const IntegratorInfo& info,
                  Table& table) {
  const std::string scheme(info.name);
  double surprise = 0.0;
  for (const double h : {0.1, 0.01}) {
    const long steps = std::lround((context.quick ? 5.0 : paper_duration) / h);
    std::vector<Cell> row{scheme, h};
    for (const double c : swept_viscosities) {
      const Oscillator oscillator = paper_oscillator(c);
      const std::vector<double> exact = exact_samples(oscillator, instants(h, steps)).position;
      const std::vector<double> closed = closed_positions(scheme, oscillator, h, steps);
      const std::vector<double> found =
          samples_of(run(context, oscillator, scheme, h, steps)).position;
      const double error = peak_distance(found, exact);
      surprise = worse(surprise, std::abs(error - peak_distance(closed, exact)));
      row.emplace_back(error);
    }
    const Samples driven = exact_samples(driven_oscillator(), instants(h, steps));
    row.emplace_back(peak_distance(
        samples_of(run(context, driven_oscillator(), scheme, h, steps)).position, driven.position));
    table.rows.push_back(std::move(row));
  }
  const double steps = paper_duration / 0.01;
  outcome.judge({.name = "error less the closed form's error, " + scheme,
                 .value = surprise,
                 .upper = 100.0 * steps * epsilon,
                 .bound_from = "closed form; at most 100 operations a step at one eps each"});
  const std::size_t last = table.rows.size() - 1;
  const double coarse = std::get<double>(table.rows[last - 1].back());
  const double fine = std::get<double>(table.rows[last].back());
  outcome.judge({.name = "decades of error per decade of step, driven, " + scheme,
                 .value = std::log10(coarse / fine),
                 .lower = info.order_damped - 0.15,
                 .upper = info.order_damped + 0.15,
                 .bound_from = "order of the scheme with damping"});
}

void measure_sweep(const CaseContext& context, Outcome& outcome) {
  Table table{.id = "errors",
              .title = "Errors of every scheme over the sweep of damping",
              .caption =
                  "Largest position error against the exact motion relative to its peak, "
                  "for free motions by c and for the driven one.",
              .columns = {"scheme", "h (s)"}};
  for (const double c : swept_viscosities) { table.columns.push_back("c = " + text(c) + " (1)"); }
  table.columns.emplace_back("driven (1)");
  for (const IntegratorInfo* info : integrators()) { sweep_scheme(context, outcome, *info, table); }
  Figure figure{.id = "errors",
                .title = "Error over damping, h = 0.01 s",
                .caption =
                    "The order of a scheme sets its error at every damping; of the half-step "
                    "methods only the centred damping keeps it.",
                .x = {.label = "c (N s/m)"},
                .y = {.label = "largest error over peak (1)", .logarithmic = true}};
  for (std::size_t n = 1; n < table.rows.size(); n += 2) {
    Series series{.label = std::get<std::string>(table.rows[n][0]),
                  .style = Series::Style::line_and_points};
    for (std::size_t i = 0; i < swept_viscosities.size(); ++i) {
      series.x.push_back(swept_viscosities[i]);
      series.y.push_back(std::get<double>(table.rows[n][i + 2]));
    }
    figure.series.push_back(std::move(series));
  }
  outcome.tables.push_back(std::move(table));
  outcome.figures.push_back(std::move(figure));
}

}  // namespace

std::vector<Case> sweep_cases() {
  return {{.name = "oscillator/sweep",
           .suite = "accuracy",
           .claim = "Every scheme errs by what its closed form predicts, from no damping to "
                    "overdamped.",
           .measure = measure_sweep,
           .weight = 3.0}};
}

}  // namespace palpate::oscillator
