// SPDX-License-Identifier: MIT
/// The paper's Figs. 6 to 9 with its own parameters, each judged by numbers that theory gives.

#include <numbers>

#include "validation/claims/groups.hpp"
#include "validation/claims/oscillator_fixture.hpp"

namespace palpate::oscillator {

namespace {

constexpr double amplitude = 3.0;  ///< A [m] of Fig. 6
using Curve = std::function<double(double)>;

/// Zeros of a curve on [0, 25] s, to rounding.
std::vector<double> zeros_of(const Curve& curve) {
  std::vector<double> zeros;
  const double spacing = 0.01;
  for (int n = 0; n < 2500; ++n) {
    double low = spacing * n;
    double high = spacing * (n + 1);
    if (!(curve(low) * curve(high) < 0.0)) { continue; }
    const bool falls = curve(low) > 0.0;
    for (int halving = 0; halving < 60; ++halving) {
      const double middle = 0.5 * (low + high);
      ((curve(middle) > 0.0) == falls ? low : high) = middle;
    }
    zeros.push_back(0.5 * (low + high));
  }
  return zeros;
}

/// [rad/s] from the first and last zero; NaN with fewer than two.
double frequency_of(const std::vector<double>& zeros) {
  if (zeros.size() < 2) { return std::nan(""); }
  return std::numbers::pi * static_cast<double>(zeros.size() - 1) / (zeros.back() - zeros.front());
}

/// Central differences with h and h/2, extrapolated: error of order h^4.
double slope_at_zero(const Curve& curve) {
  const auto slope = [&](double h) { return (curve(h) - curve(-h)) / (2.0 * h); };
  return (4.0 * slope(0.5e-3) - slope(1e-3)) / 3.0;
}

void judge_forms(Outcome& outcome, double c, Table& table) {
  Oscillator o = paper_oscillator(c);
  o.displacement = amplitude;
  const Curve printed = [o](double t) { return reference::equation_6_printed(o, amplitude, t); };
  const Curve plotted = [o](double t) {
    return reference::equation_6_plotted(o, amplitude, 0.0, t);
  };
  const Curve exact = [o](double t) { return reference::exact_motion(o, t).position; };
  const std::string label = ", c = " + text(c);
  const double omega1 = std::sqrt(1.0 - 0.25 * c * c);
  const double zero_rounding = 1e-12;  // zeros near 25 s are known to an eps of 25
  const double slope_rounding = 1e-9;  // h^4 of the extrapolation and eps A / h
  const auto zeros = zeros_of(printed).size();
  outcome.judge_near("zeros of the printed form" + label, zeros, 0.0, 0.0,
                     "theory: a bare exponential has none");
  outcome.judge_near("frequency as plotted" + label, frequency_of(zeros_of(plotted)), 1.0,
                     zero_rounding, "theory: omega0, whatever c is; rounding", "rad/s");
  outcome.judge_near("initial velocity as plotted" + label, slope_at_zero(plotted),
                     -0.5 * c * amplitude, slope_rounding, "theory: -gamma A, not rest", "m/s");
  outcome.judge_near("initial velocity, exact" + label, slope_at_zero(exact), 0.0, slope_rounding,
                     "the stated start from rest", "m/s");
  const std::vector<double> crossings = zeros_of(exact);
  if (crossings.size() >= 2) {
    outcome.judge_near("frequency, exact" + label, frequency_of(crossings), omega1,
                       zero_rounding * 1e2,
                       "theory: omega0 sqrt(1 - S^2); rounding of a faint crossing", "rad/s");
  }
  table.rows.push_back({c, zeros, frequency_of(zeros_of(plotted)), omega1, slope_at_zero(plotted),
                        slope_at_zero(exact)});
}

Figure& draw_forms(double c, Outcome& outcome) {
  Oscillator o = paper_oscillator(c);
  o.displacement = amplitude;
  Figure& figure = outcome.plot(
      "c-" + id_of(text(c)), "Eq. 6 in three readings, c = " + text(c) + " N s/m",
      "The printed form only decays; as plotted it swings at omega0 and does not start from rest; "
      "the exact motion, which the model follows, swings at omega1 and does.",
      {"time (s)"}, {"position (m)"});
  Series& printed = figure.add("as printed", Series::Style::dashed);
  Series& plotted = figure.add("as plotted", Series::Style::line_and_points);
  Series& exact = figure.add("exact");
  for (const double t : tick_times(0.25, 100)) {
    printed.add(t, reference::equation_6_printed(o, amplitude, t));
    plotted.add(t, reference::equation_6_plotted(o, amplitude, 0.0, t));
    exact.add(t, reference::exact_motion(o, t).position);
  }
  return figure;
}

/// Compares the Runge-Kutta scheme of the model with the exact curve.
void judge_model(const CaseContext& context, Outcome& outcome, double c, Figure& figure) {
  Oscillator o = paper_oscillator(c);
  o.displacement = amplitude;
  const double h = 0.05;
  const long steps = 500;
  const Samples found = run(context, o, "rk4", h, steps);
  const Samples exact = exact_samples(o, tick_times(h, steps));
  // The energy norm never grows: Taylor remainders of (h |G|)^5 / 120 only add up, |G|^2 = 2 + c^2.
  const double bound =
      static_cast<double>(steps) * std::pow(h * std::sqrt(2.0 + c * c), 5.0) / 120.0;
  outcome.judge_at_most("model from the exact form over its peak, c = " + text(c),
                        peak_distance(found.position, exact.position), bound,
                        "Taylor remainder of 500 steps");
  Series& points = figure.add("model, Runge-Kutta", Series::Style::points);
  for (std::size_t n = 0; n < found.time.size(); n += 20) {
    points.add(found.time[n], found.position[n]);
  }
}

void measure_figure_6(const CaseContext& context, Outcome& outcome) {
  Table& table = outcome.table(
      "forms", "What the three readings of Eq. 6 do",
      "Zeros, frequencies and initial velocities of the three forms.",
      {"c (N s/m)", "zeros as printed (1)", "frequency as plotted (rad/s)", "omega1 (rad/s)",
       "initial velocity as plotted (m/s)", "initial velocity, exact (m/s)"});
  for (const double c : paper_viscosities) {
    judge_forms(outcome, c, table);
    judge_model(context, outcome, c, draw_forms(c, outcome));
  }
  outcome.notes.emplace_back(
      "Eq. 6 as printed multiplies omega0 t by a phase of zero and cannot oscillate; the plotted "
      "curves have the frequency of an undamped spring and start inwards at gamma A.");
}

/// Figs. 7-9: one scheme each, with the trace and determinant of its step (m = k = 1). The
/// determinant is also the factor by which a step multiplies areas of the phase plane.
struct SchemeFigure {
  std::string name;
  std::string scheme;
  std::string title;
  double (*trace)(double c, double h);
  double (*determinant)(double c, double h);
};

double semi_implicit_trace(double c, double h) { return 2.0 - c * h - h * h; }
double semi_implicit_determinant(double c, double h) { return 1.0 - c * h; }

const std::array<SchemeFigure, 3> scheme_figures{
    SchemeFigure{"figure-7", "euler", "Euler", [](double c, double h) { return 2.0 - c * h; },
                 [](double c, double h) { return 1.0 - c * h + h * h; }},
    SchemeFigure{"figure-8", "euler-cromer", "Euler-Cromer", semi_implicit_trace,
                 semi_implicit_determinant},
    SchemeFigure{"figure-9", "feynman-newton-printed", "Feynman-Newton as printed",
                 semi_implicit_trace, semi_implicit_determinant}};

/// The recurrence that a curve obeys says which scheme drew it, and at which damping and step.
struct Misses {
  Largest trace{};        ///< largest |found - theory| over the rounding of the fit
  Largest determinant{};  ///< likewise
  Largest position{};     ///< largest distance from the closed form over its peak
};

Recurrence compare(Misses& misses, const SchemeFigure& one, double c, double h,
                   const Samples& curve) {
  const Recurrence found = identify_recurrence(curve.position);
  const long steps = std::lround(paper_duration / h);
  misses.position.add(
      peak_distance(curve.position, closed_positions(one.scheme, paper_oscillator(c), h, steps)));
  const double rounding = 10.0 * epsilon * found.condition;
  misses.trace.add(std::abs(found.trace - one.trace(c, h)) / rounding);
  misses.determinant.add(std::abs(found.determinant - one.determinant(c, h)) / rounding);
  return found;
}

void measure_scheme_figure(const SchemeFigure& one, const CaseContext& context, Outcome& outcome) {
  Table& table = outcome.table(
      "distances", one.title + " against Eq. 6",
      "RMS distances over 25 s; trace and determinant of the step, measured and in theory.",
      {"c (N s/m)", "h (s)", "from Eq. 6 as plotted (m)", "from the exact motion (m)", "trace (1)",
       "its theory (1)", "determinant (1)", "its theory (1)"});
  Misses misses;
  for (const double c : paper_viscosities) {
    const Oscillator oscillator = paper_oscillator(c);
    Figure& figure = outcome.plot(
        "c-" + id_of(text(c)), one.title + ", c = " + text(c) + " N s/m",
        one.title + " at both steps of the paper beside Eq. 6 as plotted and the exact motion.",
        {"time (s)"}, {"position (m)"});
    for (const double h : paper_steps) {
      const long steps = std::lround(paper_duration / h);
      const Samples found = run(context, oscillator, one.scheme, h, steps);
      const Samples exact = exact_samples(oscillator, tick_times(h, steps));
      const Recurrence recurrence = compare(misses, one, c, h, found);
      table.rows.push_back(
          {c, h, rms_distance(found.position, equation_6_samples(oscillator, exact.time)),
           rms_distance(found.position, exact.position), recurrence.trace, one.trace(c, h),
           recurrence.determinant, one.determinant(c, h)});
      figure.add(one.title + ", h = " + text(h) + " s", found.time, found.position,
                 Series::Style::line_and_points);
    }
    const std::vector<double> fine = tick_times(0.1, 250);
    figure.add("Eq. 6 as plotted", fine, equation_6_samples(oscillator, fine),
               Series::Style::dashed);
    figure.add("exact", fine, exact_samples(oscillator, fine).position);
  }
  for (const auto& [name, value] : {std::pair{"trace", misses.trace.value()},
                                    std::pair{"determinant", misses.determinant.value()}}) {
    outcome.judge_at_most(
        std::string("largest miss of the step's ") + name + " over its rounding", value, 1.0,
        "theory of the step; 10 operations a step at one eps each, times the condition of the fit");
  }
  outcome.judge_at_most("largest distance from the closed form over its peak",
                        misses.position.value(), 10.0 * 250.0 * epsilon,
                        "10 operations in each of 250 steps at one eps each");
}

// The paper's Fig. 10: orbits in the phase plane, and the area that each scheme gains or loses.

/// Two successive states span a parallelogram; each step multiplies its area by the determinant.
double area_factor(const Samples& orbit, long steps) {
  const std::size_t count = static_cast<std::size_t>(steps) + 1;
  if (orbit.position.size() != count || orbit.velocity.size() != count) { return std::nan(""); }
  const auto area = [&](std::size_t n) {
    return orbit.position[n] * orbit.velocity[n + 1] - orbit.position[n + 1] * orbit.velocity[n];
  };
  double factor = std::pow(area(count - 2) / area(0), 1.0 / static_cast<double>(count - 2));
  for (const double x : orbit.position) { factor += 0.0 * x; }  // a NaN on the way is one here
  return factor;
}

Figure draw(const CaseContext& context, const SchemeFigure& one, double c) {
  const Oscillator oscillator = paper_oscillator(c);
  Figure figure = plot(
      one.scheme + "-c-" + id_of(text(c)),
      "Phase portrait of " + one.title + ", c = " + text(c) + " N s/m",
      "The orbit of " + one.title + " at both steps of the paper beside that of the exact motion.",
      {"position (m)"}, {"velocity (m/s)"});
  figure.square = true;
  for (const double h : paper_steps) {
    const long steps = std::lround(paper_duration / h);
    const Samples orbit = run(context, oscillator, one.scheme, h, steps);
    figure.add("h = " + text(h) + " s", orbit.position, orbit.velocity,
               Series::Style::line_and_points);
  }
  const Samples exact = exact_samples(oscillator, tick_times(0.05, 500));
  figure.add("exact", exact.position, exact.velocity);
  return figure;
}

/// |measured - theory| over its rounding.
double miss_of_area(const CaseContext& context, const SchemeFigure& one, double c, double h,
                    Table& table) {
  // Long enough to be visible, short enough to limit rounding.
  const long steps = 60;
  const Samples orbit = run(context, paper_oscillator(c), one.scheme, h, steps);
  const double found = area_factor(orbit, steps);
  const double theory = one.determinant(c, h);
  table.rows.push_back({one.title, c, h, found, theory, std::exp(-c * h)});
  // The area, h, is a difference of products of order one; what 60 steps add the root divides.
  return std::abs(found - theory) / (10.0 * epsilon / h);
}

void measure_figure_10(const CaseContext& context, Outcome& outcome) {
  Table& table =
      outcome.table("areas", "What a step does to an area of the phase plane",
                    "Measured factor, determinant of the step, and the exact exp(-c h / m).",
                    {"scheme", "c (N s/m)", "h (s)", "measured (1)", "theory (1)", "exact (1)"});
  for (const SchemeFigure& one : scheme_figures) {
    Largest miss;
    for (const double h : paper_steps) {
      for (const double c : {0.0, 0.1, 0.7, 1.4}) {
        miss.add(miss_of_area(context, one, c, h, table));
      }
    }
    outcome.judge_at_most(
        "largest miss of the area factor of " + one.title + " over its rounding", miss.value(), 1.0,
        "theory: determinant of the step; 10 operations a step at one eps each, in an area of h");
    outcome.figures.push_back(draw(context, one, 0.0));
    outcome.figures.push_back(draw(context, one, 0.1));
    if (!context.quick) { outcome.figures.push_back(draw(context, one, 0.7)); }
  }
  outcome.notes.emplace_back(
      "Without damping Euler-Cromer and Feynman-Newton keep areas exactly and their orbits close; "
      "Euler gains 1 + h^2 per step, and with c = 0.1 N s/m at h = 0.1 s its spiral stands still.");
}

// Who follows what: the schemes of Table 1 against Eq. 6 and the exact motion.

struct Contender {
  std::string scheme;
  std::string title;
};
const std::array<Contender, 4> contenders{
    Contender{"euler", "Euler"}, Contender{"euler-cromer", "Euler-Cromer"},
    Contender{"feynman-newton-printed", "Feynman-Newton as printed"},
    Contender{"feynman-newton", "Feynman-Newton, half-step start"}};

/// One damping and step: distances of the four, measured and as their closed forms give them.
struct Round {
  double c = 0.0;
  double h = 0.0;
  std::array<double, 4> from_equation{};  ///< [m]
  std::array<double, 4> from_exact{};     ///< [m]
  Largest surprise{};                     ///< largest |measured - predicted| [m]
  double mean_identity = 0.0;             ///< half-step Feynman-Newton less the mean of the two [m]
};

Round play(const CaseContext& context, double c, double h) {
  const Oscillator oscillator = paper_oscillator(c);
  const long steps = std::lround(paper_duration / h);
  const std::vector<double> exact = exact_samples(oscillator, tick_times(h, steps)).position;
  const std::vector<double> equation = equation_6_samples(oscillator, tick_times(h, steps));
  Round round{.c = c, .h = h};
  std::array<std::vector<double>, 4> x;
  for (std::size_t i = 0; i < contenders.size(); ++i) {
    const std::string& scheme = contenders[i].scheme;
    x[i] = run(context, oscillator, scheme, h, steps).position;
    const std::vector<double> closed = closed_positions(scheme, oscillator, h, steps);
    round.from_equation[i] = rms_distance(x[i], equation);
    round.from_exact[i] = rms_distance(x[i], exact);
    round.surprise.add(std::abs(round.from_equation[i] - rms_distance(closed, equation)));
    round.surprise.add(std::abs(round.from_exact[i] - rms_distance(closed, exact)));
  }
  std::vector<double> mean = x[1];
  for (std::size_t n = 0; n < mean.size() && n < x[2].size(); ++n) {
    mean[n] = 0.5 * (mean[n] + x[2][n]);
  }
  round.mean_identity = peak_distance(x[3], mean);
  return round;
}

/// Counts how often each contender is nearest, over the rounds.
std::array<int, 4> wins(const std::vector<Round>& rounds, std::array<double, 4> Round::*distance) {
  std::array<int, 4> won{};
  for (const Round& round : rounds) {
    const auto& d = round.*distance;
    ++won[static_cast<std::size_t>(std::min_element(d.begin(), d.end()) - d.begin())];
  }
  return won;
}

std::string ranking(const std::array<int, 4>& won) {
  std::string words;
  for (std::size_t i = 0; i < won.size(); ++i) {
    if (won[i] == 0) { continue; }
    words += (words.empty() ? "" : ", ") + contenders[i].title + " in " + std::to_string(won[i]);
  }
  return words;
}

/// Rounds in which `a` is nearer than `b`.
int nearer(const std::vector<Round>& rounds, std::array<double, 4> Round::*distance, std::size_t a,
           std::size_t b) {
  int count = 0;
  for (const Round& round : rounds) {
    count += (round.*distance)[a] < (round.*distance)[b] ? 1 : 0;
  }
  return count;
}

void say_who(const std::vector<Round>& rounds, Outcome& outcome) {
  const std::string all = " of " + std::to_string(rounds.size());
  outcome.notes.push_back("Nearest to Eq. 6 as plotted: " +
                          ranking(wins(rounds, &Round::from_equation)) + all + " settings.");
  outcome.notes.push_back("Nearest to the exact motion: " +
                          ranking(wins(rounds, &Round::from_exact)) + all + " settings.");
  const int equation = nearer(rounds, &Round::from_equation, 2, 1);
  const int exact = nearer(rounds, &Round::from_exact, 2, 1);
  const auto winner = [&](int count) {
    const int half = static_cast<int>(rounds.size()) / 2;
    return std::string(count > half   ? "Feynman-Newton as printed"
                       : count < half ? "Euler-Cromer"
                                      : "neither");
  };
  outcome.notes.push_back(
      "Of Euler-Cromer and Feynman-Newton as printed, Feynman-Newton is the nearer one to Eq. 6 as "
      "plotted in " +
      std::to_string(equation) + all + " settings and to the exact motion in " +
      std::to_string(exact) + all + ": " + winner(equation) + " follows Eq. 6 best and " +
      winner(exact) + " follows the true motion best" +
      (winner(equation) == winner(exact) ? ", the same scheme." : "; they differ."));
  outcome.notes.emplace_back(
      "Nearness to Eq. 6 as plotted is no merit: that curve is not a solution of Eq. 5.");
}

void judge_reversal(const CaseContext& context, Outcome& outcome) {
  // Without damping printed Feynman-Newton is the adjoint of Euler-Cromer (with damping it is only
  // conjugate to it, as the explicit damping is not symmetric in time): with the velocity turned
  // round at the end, Euler-Cromer runs the same steps backwards.
  const long steps = 100;
  const Samples there = run(context, paper_oscillator(0.0), "feynman-newton-printed", 0.25, steps);
  Oscillator back = paper_oscillator(0.0);
  back.displacement = there.position.back();
  back.velocity = -there.velocity.back();
  const Samples home = run(context, back, "euler-cromer", 0.25, steps);
  const double miss = home.position.empty()
                          ? std::nan("")
                          : std::hypot(home.position.back() - 1.0, home.velocity.back());
  outcome.judge_at_most("Euler-Cromer undoes printed Feynman-Newton, c = 0: miss", miss,
                        20.0 * static_cast<double>(steps) * epsilon,
                        "adjoint schemes; one eps for each of 10 operations a step, both ways",
                        "m");
}

Table table_of(const std::vector<Round>& rounds) {
  Table table =
      make_table("distances", "Who is closest to what",
                 "RMS distance over 25 s from Eq. 6 as plotted and from the exact motion.",
                 {"c (N s/m)", "h (s)"});
  for (const std::string target : {"Eq. 6", "exact"}) {
    for (const Contender& one : contenders) {
      table.columns.push_back(one.title + " - " + target + " (m)");
    }
  }
  for (const Round& round : rounds) {
    std::vector<Cell> row{round.c, round.h};
    row.insert(row.end(), round.from_equation.begin(), round.from_equation.end());
    row.insert(row.end(), round.from_exact.begin(), round.from_exact.end());
    table.rows.push_back(std::move(row));
  }
  return table;
}

void judge_rounds(const std::vector<Round>& rounds, Outcome& outcome) {
  Largest surprise;
  Largest identity;
  Largest excess;
  for (const Round& round : rounds) {
    surprise.add(round.surprise.value());
    identity.add(round.mean_identity);
    const auto& d = round.from_exact;
    excess.add(d[3] / (0.5 * (d[1] + d[2])));
  }
  // Euler at c = 0.1, h = 0.25 grows sixfold; one eps per operation and step all the way.
  outcome.judge_at_most(
      "largest distance less the closed forms' distance", surprise.value(),
      10.0 * 10.0 * 250.0 * epsilon,
      "closed forms; 10 operations in 250 steps at one eps each, grown at most tenfold", "m");
  outcome.judge_at_most("half-step start less the mean of Euler-Cromer and printed",
                        identity.value(), 10.0 * 250.0 * epsilon,
                        "linearity: the three start from v0 + (h/2) a, v0 + h a and v0");
  outcome.judge_at_most("half-step start over the mean distance of the two from the exact motion",
                        excess.value(), 1.0, "triangle inequality");
  const std::string unit = "of " + std::to_string(rounds.size()) + " settings";
  outcome.report("Feynman-Newton as printed nearer to Eq. 6 than Euler-Cromer",
                 nearer(rounds, &Round::from_equation, 2, 1), unit);
  outcome.report("Feynman-Newton as printed nearer to the exact motion than Euler-Cromer",
                 nearer(rounds, &Round::from_exact, 2, 1), unit);
}

Figure draw(const std::vector<Round>& rounds) {
  Figure figure = plot("distance", "Distance from Eq. 6 and from the exact motion, h = 0.1 s",
                       "Which of the two printed schemes is nearer depends on whether Eq. 6 as "
                       "plotted or the exact motion is the target.",
                       {"c (N s/m)"}, logarithmic("RMS distance (m)"));
  for (std::size_t i = 1; i < 4; ++i) {
    Series& equation = figure.add(contenders[i].title + " - Eq. 6", Series::Style::dashed);
    Series& exact = figure.add(contenders[i].title + " - exact", Series::Style::line_and_points);
    for (const Round& round : rounds) {
      if (round.h != 0.1) { continue; }
      equation.add(round.c, round.from_equation[i]);
      exact.add(round.c, round.from_exact[i]);
    }
  }
  return figure;
}

void measure_closest(const CaseContext& context, Outcome& outcome) {
  std::vector<Round> rounds;
  for (const double h : paper_steps) {
    for (const double c : paper_viscosities) { rounds.push_back(play(context, c, h)); }
  }
  judge_rounds(rounds, outcome);
  judge_reversal(context, outcome);
  say_who(rounds, outcome);
  outcome.tables.push_back(table_of(rounds));
  outcome.figures.push_back(draw(rounds));
}

}  // namespace

std::vector<Case> figure_cases() {
  std::vector<Case> cases = {{"oscillator/figure-6", "accuracy",
                              "Eq. 6 as printed, as plotted and exact are three different motions.",
                              measure_figure_6, 0.1}};
  for (const SchemeFigure& one : scheme_figures) {
    cases.push_back({"oscillator/" + one.name, "accuracy",
                     one.title + " moves by the recurrence that its definition gives at every "
                                 "damping and step of the paper.",
                     std::bind_front(measure_scheme_figure, one), 0.3});
  }
  cases.push_back(
      {"oscillator/figure-10", "accuracy",
       "Each scheme gains or loses area of the phase plane as its step's determinant says.",
       measure_figure_10, 0.5});
  cases.push_back(
      {"oscillator/who-is-closest", "accuracy",
       "Which scheme follows best depends on the target, Eq. 6 as plotted or the exact motion.",
       measure_closest, 1.0});
  return cases;
}

}  // namespace palpate::oscillator
