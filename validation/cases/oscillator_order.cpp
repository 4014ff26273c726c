// SPDX-License-Identifier: MIT
/// Observed order of every scheme on the undamped, the damped and the driven oscillator.

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/stepping/integrator.hpp"
#include "validation/cases/oscillator_parts.hpp"
#include "validation/cases/oscillator_setting.hpp"
#include "validation/metrics.hpp"

namespace palpate::oscillator {

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

}  // namespace palpate::oscillator
