// SPDX-License-Identifier: MIT
/// Exact motion of every regime compared with evaluations that do not distinguish regimes.

#include <algorithm>
#include <numbers>

#include "reference/solvers.hpp"
#include "validation/claims/groups.hpp"
#include "validation/claims/oscillator_fixture.hpp"

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
  Samples samples{.time = tick_times(sampling, sample_count)};
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
  Largest largest;
  for (std::size_t n = 0; n < truth.time.size(); ++n) {
    const double size = std::hypot(truth.position[n], truth.velocity[n] / omega);
    so_far = o.drive_amplitude == 0.0 ? size : std::max(so_far, size);
    if (so_far == 0.0) { continue; }  // rest before the drive has acted
    largest.add(std::hypot(found.position[n] - truth.position[n],
                           (found.velocity[n] - truth.velocity[n]) / omega) /
                so_far);
  }
  return largest.value();
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
  Table& table =
      outcome.table("differences", "Exact motion against a Taylor series in long double",
                    "Largest difference over 25 s relative to the motion then, by regime.",
                    {"motion", "S (1)", "class", "relative difference (1)"});
  Figure& figure = outcome.plot(
      "regimes", "One oscillator, all regimes",
      "The exact free motion, undamped through critical (c = 2) to overdamped (c = 3).",
      {"time (s)"}, {"position (m)"});
  Largest free;
  Largest near_critical;
  Largest driven;
  for (const Named& one : regimes()) {
    const Samples truth = taylor_motion(one.oscillator);
    const Samples found = exact_samples(one.oscillator, truth.time);
    const double difference = relative_difference(one.oscillator, found, truth);
    const bool is_driven = one.oscillator.drive_amplitude != 0.0;
    (is_driven ? driven : one.name.starts_with("S = 1") ? near_critical : free).add(difference);
    table.rows.push_back({one.name, reference::damping_ratio(one.oscillator),
                          reference::damping_class(one.oscillator), difference});
    if (one.name.starts_with("c = ")) { figure.add(one.name, found.time, found.position); }
  }
  const auto judge = [&](const std::string& name, const Largest& found) {
    outcome.judge_at_most(name, found.value(), 1e-13,
                          "the closed form is required to 1e-13; the series errs by 1e-17");
  };
  judge("free motion", free);
  judge("free motion within 1e-3 of critical damping", near_critical);
  judge("driven motion", driven);
}

/// Judges the closed form with two external solvers for the equation of motion.
void judge_solvers(Outcome& outcome) {
  const std::vector<double> times = tick_times(sampling, sample_count);
  const auto judge = [&](const std::string& name, const Oscillator& oscillator) {
    const OscillatorProblem problem(oscillator);
    const Samples exact = exact_samples(oscillator, times);
    const auto difference = [&](const Trace& solution) {
      const std::vector<double> found{solution.position.data(),
                                      solution.position.data() + solution.position.size()};
      return peak_distance(exact.position, found);
    };
    const auto accurate = reference::solve_long_double(problem, times, {1e-16, 1.0, 1.0});
    outcome.judge_at_most(name + ", Fehlberg 7(8) in long double", difference(accurate), 1e-13,
                          "the closed form is required to 1e-13");
    const double tolerance = 1e-11;
    const auto adams = reference::solve_cvode_adams(problem, times, {tolerance, 1.0, 1.0});
    outcome.judge_at_most(
        name + ", CVODE Adams", difference(adams),
        2.0 * std::numbers::sqrt2 * tolerance * static_cast<double>(adams.steps),
        "its local errors, an RMS of 1e-11 (1 + |y|) over two states, add up over its " +
            std::to_string(adams.steps) + " steps at most");
  };
  for (const double c : {0.0, 0.1, 2.0, 3.0}) { judge("c = " + text(c), paper_oscillator(c)); }
  judge("driven", driven_oscillator());
}

/// The model's own classical Runge-Kutta at a small step, in every regime that does not grow.
void judge_model(const CaseContext& context, Outcome& outcome) {
  const double h = 0.02;
  const long steps = 1250;
  Largest worst;
  for (const Named& one : regimes()) {
    const Oscillator& o = one.oscillator;
    if (o.viscosity < 0.0) { continue; }
    const Samples found = run(context, o, "rk4", h, steps);
    const double error =
        peak_distance(found.position, exact_samples(o, tick_times(h, steps)).position);
    // The energy norm never grows, so local errors of (h |G|)^5 / 120 only add up; a drive of unit
    // force adds its own size to that of the motion.
    const double norm = static_cast<double>(generator_of(o).norm());
    const double bound = static_cast<double>(steps) * std::pow(h * norm, 5.0) / 120.0;
    worst.add(error / bound);
  }
  outcome.judge_at_most("Runge-Kutta run over its error bound", worst.value(), 1.0,
                        "Taylor remainder (h |G|)^5 / 120 per step");
}

void measure_regimes(const CaseContext& context, Outcome& outcome) {
  judge_closed_form(outcome);
  judge_solvers(outcome);
  judge_model(context, outcome);
  Table& names = outcome.table("classes", "Classes of damping",
                               "What the paper's settings are, with m = 1 kg and k = 1 N/m.",
                               {"c (N s/m)", "S (1)", "class", "the paper's text"});
  int agreeing = 0;
  for (const double c : swept_viscosities) {
    const Oscillator o = paper_oscillator(c);
    const std::string found = reference::damping_class(o);
    const std::string expected = c == 0.0   ? "undamped"
                                 : c < 2.0  ? "underdamped"
                                 : c == 2.0 ? "critically damped"
                                            : "overdamped";
    agreeing += found == expected ? 1 : 0;
    names.rows.push_back({c, reference::damping_ratio(o), found,
                          c == 0.7   ? "overdamped"
                          : c == 1.8 ? "critically damped"
                                     : ""});
  }
  outcome.judge_at_least("settings in the class that c^2 - 4 m k says", agreeing,
                         static_cast<double>(swept_viscosities.size()), "sign of c^2 - 4 m k");
  outcome.notes.emplace_back(
      "The paper's text calls c = 0.7 N s/m overdamped and c = 1.8 N s/m critically damped; with m "
      "= 1 kg and k = 1 N/m they have S = 0.35 and S = 0.9 and are both underdamped. Critical "
      "damping is c = 2 N s/m.");
}

// Every scheme against its own closed form, to rounding.

using reference::Amplification;
using reference::DiscreteState;

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
  Largest largest;
  for (std::size_t n = 0; n < closed.position.size(); ++n) {
    const double dx = found.position[n] - closed.position[n];
    const double dv = (found.velocity[n] - closed.velocity[n]) / omega;
    largest.add(std::hypot(dx, dv) / closed.rounding[n]);
  }
  return largest.value();
}

void measure_discrete(const IntegratorInfo& info, const CaseContext& context, Outcome& outcome) {
  const std::string scheme(info.name);
  const long steps = context.quick ? 200 : 500;
  const double limit = operations(scheme);
  Figure& figure =
      outcome.plot("difference", "Model minus closed form of " + scheme,
                   "The position differs from the closed form of the scheme by rounding only.",
                   {"time (s)"}, logarithmic("absolute difference (m)"));
  const auto judge = [&](const std::string& label, const Oscillator& oscillator, double h) {
    const Samples found = run(context, oscillator, scheme, h, steps);
    const Closed closed = closed_form(scheme, oscillator, h, steps);
    outcome.judge_at_most("rounding per step, " + label,
                          rounding_per_step(found, closed, natural_frequency(oscillator)), limit,
                          "one eps for each of the " + text(limit) +
                              " operations of a step, carried on by the powers of its matrix",
                          "eps");
    Series& series = figure.add(label, Series::Style::points);
    for (std::size_t n = 0; n < found.position.size() && n < closed.position.size(); ++n) {
      const double difference = std::abs(found.position[n] - closed.position[n]);
      if (!(difference > 0.0)) { continue; }  // a logarithmic axis has no zero
      series.add(found.time[n], difference);
    }
  };
  for (const double c : {0.0, 0.1, 1.0, 2.0, 3.0}) {
    judge("c = " + text(c) + " N s/m", paper_oscillator(c), 0.1);
  }
  // Neither mass nor stiffness nor initial velocity of one or zero hides a factor.
  judge("m = 0.7 kg, k = 3 N/m, c = 0.4 N s/m",
        {.mass = 0.7, .stiffness = 3.0, .viscosity = 0.4, .displacement = 0.3, .velocity = -1.1},
        0.08);
}

// Observed order of every scheme on the undamped, the damped and the driven oscillator.

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

/// Largest errors over the peak of the exact motion, by step [s].
struct Ladder {
  Series position{.style = Series::Style::points};
  Series velocity{};
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
    const Samples found = run(context, setting.oscillator, scheme, h, steps);
    const Samples exact = exact_samples(setting.oscillator, tick_times(h, steps));
    ladder.position.add(h, peak_distance(found.position, exact.position));
    ladder.velocity.add(h, peak_distance(found.velocity, exact.velocity));
  }
  return ladder;
}

void judge_slope(Outcome& outcome, const std::string& what, int order, const ObservedOrder& found) {
  const double p = order;
  outcome.judge_near("order of " + what, found.slope, p, tolerance,
                     "Taylor expansion of one step gives order " + std::to_string(order));
  outcome.judge_at_least("rungs used for " + what, found.rungs, 4.0,
                         "fewer than four errors show no slope");
  outcome.judge_true("errors of " + what + " fall with h", found.monotone, "convergence");
  outcome.report("r^2 of " + what, found.r_squared);
}

void draw(Figure& figure, const std::string& name, Series errors, const ObservedOrder& order) {
  double level = 0.0;  // the line through the middle of the errors
  for (std::size_t n = 0; n < errors.x.size(); ++n) {
    level += std::log(errors.y[n]) - order.slope * std::log(errors.x[n]);
  }
  level /= static_cast<double>(errors.x.size());
  errors.label = name + ", measured";
  figure.series.push_back(errors);
  Series& fit = figure.add(name + ", slope " + text(std::round(100.0 * order.slope) / 100.0),
                           Series::Style::dashed);
  for (const double h : errors.x) { fit.add(h, std::exp(level + order.slope * std::log(h))); }
}

void measure_order(const IntegratorInfo& info, const CaseContext& context, Outcome& outcome) {
  const auto* found = std::ranges::find(theory, info.name, &Theory::scheme);
  if (found == theory.end()) {
    throw std::invalid_argument("no order is known from theory for " + std::string(info.name));
  }
  const Theory& expected = *found;
  const char* from = "Taylor expansion of one step";
  outcome.judge_equal("announced order, undamped", info.order_undamped, expected.undamped, from);
  outcome.judge_equal("announced order, damped", info.order_damped, expected.damped, from);
  Figure& figure =
      outcome.plot("error-over-step", "Convergence of " + std::string(info.name),
                   "Largest position error over " + text(duration) +
                       " s against the exact motion, relative to its peak, falls with the step at "
                       "the slope that the dashed lines show.",
                   logarithmic("step h (s)"), logarithmic("largest error over peak (1)"));
  Table& table = outcome.table("errors", "Errors on the ladder of steps",
                               "Largest errors relative to the peak of the exact motion.",
                               {"oscillator", "h (s)", "position error (1)", "velocity error (1)"});
  for (const Setting& setting :
       {Setting{"undamped", thrown(paper_oscillator(0.0)), expected.undamped},
        Setting{"damped", thrown(paper_oscillator(0.5)), expected.damped},
        Setting{"driven", thrown(driven_oscillator()), expected.damped}}) {
    const Ladder ladder = climb(context, setting, info.name);
    const auto& [position, velocity] = ladder;
    const ObservedOrder order = observed_order(position.x, position.y, round_off);
    judge_slope(outcome, "position, " + setting.name, setting.order, order);
    judge_slope(outcome, "velocity, " + setting.name, setting.order,
                observed_order(velocity.x, velocity.y, round_off));
    draw(figure, setting.name, position, order);
    for (std::size_t n = 0; n < position.x.size(); ++n) {
      table.rows.push_back({setting.name, position.x[n], position.y[n], velocity.y[n]});
    }
  }
  outcome.notes.push_back(std::string(info.name) + ": order " + std::to_string(expected.undamped) +
                          " undamped and " + std::to_string(expected.damped) + " damped, because " +
                          std::string(expected.because) + ".");
}

// All schemes over all dampings.

/// Errors of one scheme for h = 0.1 and 0.01 s against the exact motion and the closed form.
void sweep_scheme(const CaseContext& context, Outcome& outcome, const IntegratorInfo& info,
                  Table& table) {
  const std::string scheme(info.name);
  Largest surprise;
  for (const double h : {0.1, 0.01}) {
    const long steps = std::lround((context.quick ? 5.0 : paper_duration) / h);
    std::vector<Cell> row{scheme, h};
    for (const double c : swept_viscosities) {
      const Oscillator oscillator = paper_oscillator(c);
      const std::vector<double> exact = exact_samples(oscillator, tick_times(h, steps)).position;
      const std::vector<double> closed = closed_positions(scheme, oscillator, h, steps);
      const std::vector<double> found = run(context, oscillator, scheme, h, steps).position;
      const double error = peak_distance(found, exact);
      surprise.add(std::abs(error - peak_distance(closed, exact)));
      row.emplace_back(error);
    }
    row.emplace_back(
        peak_distance(run(context, driven_oscillator(), scheme, h, steps).position,
                      exact_samples(driven_oscillator(), tick_times(h, steps)).position));
    table.rows.push_back(std::move(row));
  }
  const double steps = paper_duration / 0.01;
  outcome.judge_at_most("error less the closed form's error, " + scheme, surprise.value(),
                        100.0 * steps * epsilon,
                        "closed form; at most 100 operations a step at one eps each");
  const std::size_t last = table.rows.size() - 1;
  const double coarse = std::get<double>(table.rows[last - 1].back());
  const double fine = std::get<double>(table.rows[last].back());
  outcome.judge_near("decades of error per decade of step, driven, " + scheme,
                     std::log10(coarse / fine), info.order_damped, 0.15,
                     "order of the scheme with damping");
}

void measure_sweep(const CaseContext& context, Outcome& outcome) {
  Table& table = outcome.table("errors", "Errors of every scheme over the sweep of damping",
                               "Largest position error against the exact motion relative to its "
                               "peak, for free motions by c and for the driven one.",
                               {"scheme", "h (s)"});
  for (const double c : swept_viscosities) { table.columns.push_back("c = " + text(c) + " (1)"); }
  table.columns.emplace_back("driven (1)");
  for (const IntegratorInfo* info : integrators()) { sweep_scheme(context, outcome, *info, table); }
  Figure& figure = outcome.plot("errors", "Error over damping, h = 0.01 s",
                                "The order of a scheme sets its error at every damping; of the "
                                "half-step methods only the centred damping keeps it.",
                                {"c (N s/m)"}, logarithmic("largest error over peak (1)"));
  for (std::size_t n = 1; n < table.rows.size(); n += 2) {
    Series& series =
        figure.add(std::get<std::string>(table.rows[n][0]), Series::Style::line_and_points);
    for (std::size_t i = 0; i < swept_viscosities.size(); ++i) {
      series.add(swept_viscosities[i], std::get<double>(table.rows[n][i + 2]));
    }
  }
}

}  // namespace

std::vector<Case> order_cases() {
  std::vector<Case> cases{
      {"oscillator/regimes", "accuracy",
       "The exact motion is right to 1e-13 against its series and an integration of order 8, and "
       "to "
       "CVODE's own error against CVODE, in every regime, driven or not.",
       measure_regimes, 1.0},
      {"oscillator/sweep", "accuracy",
       "Every scheme errs by what its closed form predicts, from no damping to overdamped.",
       measure_sweep, 3.0}};
  add_scheme_cases(cases, "oscillator/discrete/", "accuracy",
                   [](const IntegratorInfo& info) {
                     return "The model steps " + std::string(info.name) +
                            " exactly as its definition says, to rounding.";
                   },
                   measure_discrete, {.explicit_scheme = 0.3, .implicit_scheme = 0.3});
  add_scheme_cases(
      cases, "oscillator/order/", "accuracy",
      [](const IntegratorInfo& info) {
        const auto* expected = std::ranges::find(theory, info.name, &Theory::scheme);
        return "The error of " + std::string(info.name) + " falls with " +
               (expected == theory.end()
                    ? "a known order"
                    : "order " + std::to_string(expected->undamped) + " without damping and " +
                          std::to_string(expected->damped) + " with it") +
               ", driven or not.";
      },
      measure_order);
  return cases;
}

}  // namespace palpate::oscillator
