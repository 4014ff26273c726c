// SPDX-License-Identifier: MIT
/// Who follows what: the schemes of Table 1 against Eq. 6 and the exact motion.

#include <algorithm>
#include <cmath>
#include <limits>

#include "validation/cases/oscillator_parts.hpp"
#include "validation/cases/oscillator_setting.hpp"

namespace palpate::oscillator {

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

struct Contender {
  std::string scheme;
  std::string title;
};
const std::array<Contender, 4>& contenders() {
  static const std::array<Contender, 4> all{
      Contender{"euler", "Euler"}, Contender{"euler-cromer", "Euler-Cromer"},
      Contender{"feynman-newton-printed", "Feynman-Newton as printed"},
      Contender{"feynman-newton", "Feynman-Newton, half-step start"}};
  return all;
}

/// One damping and step: distances of the four, measured and as their closed forms give them.
struct Round {
  double c = 0.0;
  double h = 0.0;
  std::array<double, 4> from_equation{};  ///< [m]
  std::array<double, 4> from_exact{};     ///< [m]
  double surprise = 0.0;                  ///< largest |measured - predicted| [m]
  double mean_identity = 0.0;             ///< half-step Feynman-Newton less the mean of the two [m]
};

Round play(const CaseContext& context, double c, double h) {
  const Oscillator oscillator = paper_oscillator(c);
  const long steps = std::lround(paper_duration / h);
  const std::vector<double> exact = exact_samples(oscillator, instants(h, steps)).position;
  const std::vector<double> equation = equation_6_samples(oscillator, instants(h, steps));
  Round round{.c = c, .h = h};
  std::array<std::vector<double>, 4> x;
  for (std::size_t i = 0; i < contenders().size(); ++i) {
    const std::string& scheme = contenders()[i].scheme;
    x[i] = samples_of(run(context, oscillator, scheme, h, steps)).position;
    const std::vector<double> closed = closed_positions(scheme, oscillator, h, steps);
    round.from_equation[i] = rms_distance(x[i], equation);
    round.from_exact[i] = rms_distance(x[i], exact);
    round.surprise =
        worse(round.surprise, std::abs(round.from_equation[i] - rms_distance(closed, equation)));
    round.surprise =
        worse(round.surprise, std::abs(round.from_exact[i] - rms_distance(closed, exact)));
  }
  std::vector<double> mean = x[1];
  for (std::size_t n = 0; n < mean.size() && n < x[2].size(); ++n) {
    mean[n] = 0.5 * (mean[n] + x[2][n]);
  }
  round.mean_identity = peak_distance(x[3], mean);
  return round;
}

/// How often each contender is nearest, over the rounds.
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
    words += (words.empty() ? "" : ", ") + contenders()[i].title + " in " + std::to_string(won[i]);
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
  const Samples there =
      samples_of(run(context, paper_oscillator(0.0), "feynman-newton-printed", 0.25, steps));
  Oscillator back = paper_oscillator(0.0);
  back.displacement = there.position.back();
  back.velocity = -there.velocity.back();
  const Samples home = samples_of(run(context, back, "euler-cromer", 0.25, steps));
  const double miss = home.position.empty()
                          ? std::numeric_limits<double>::quiet_NaN()
                          : std::hypot(home.position.back() - 1.0, home.velocity.back());
  outcome.judge(
      {.name = "Euler-Cromer undoes printed Feynman-Newton, c = 0: miss",
       .value = miss,
       .unit = "m",
       .upper = 20.0 * static_cast<double>(steps) * epsilon,
       .bound_from = "adjoint schemes; one eps for each of 10 operations a step, both ways"});
}

Table table_of(const std::vector<Round>& rounds) {
  Table table{.id = "distances",
              .title = "Who is closest to what",
              .caption =
                  "Root mean square distance over 25 s of each scheme from Eq. 6 as plotted "
                  "and from the exact motion.",
              .columns = {"c (N s/m)", "h (s)"}};
  for (const std::string target : {"Eq. 6", "exact"}) {
    for (const Contender& one : contenders()) {
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
  double surprise = 0.0;
  double identity = 0.0;
  double excess = 0.0;
  for (const Round& round : rounds) {
    surprise = worse(surprise, round.surprise);
    identity = worse(identity, round.mean_identity);
    const auto& d = round.from_exact;
    excess = worse(excess, d[3] / (0.5 * (d[1] + d[2])));
  }
  // Euler at c = 0.1, h = 0.25 grows sixfold; one eps per operation and step all the way.
  outcome.judge({.name = "largest distance less the closed forms' distance",
                 .value = surprise,
                 .unit = "m",
                 .upper = 10.0 * 10.0 * 250.0 * epsilon,
                 .bound_from = "closed form of each scheme; one eps for each of 10 operations in "
                               "250 steps, grown at most tenfold"});
  outcome.judge({.name = "half-step start less the mean of Euler-Cromer and printed",
                 .value = identity,
                 .upper = 10.0 * 250.0 * epsilon,
                 .bound_from = "linearity: the three start from v0 + (h/2) a, v0 + h a and v0"});
  outcome.judge({.name = "half-step start over the mean distance of the two from the exact motion",
                 .value = excess,
                 .upper = 1.0,
                 .bound_from = "triangle inequality"});
  const std::string unit = "of " + std::to_string(rounds.size()) + " settings";
  outcome.judge({.name = "Feynman-Newton as printed nearer to Eq. 6 than Euler-Cromer",
                 .value = static_cast<double>(nearer(rounds, &Round::from_equation, 2, 1)),
                 .unit = unit});
  outcome.judge({.name = "Feynman-Newton as printed nearer to the exact motion than Euler-Cromer",
                 .value = static_cast<double>(nearer(rounds, &Round::from_exact, 2, 1)),
                 .unit = unit});
}

Figure draw(const std::vector<Round>& rounds) {
  Figure figure{.id = "distance",
                .title = "Distance from Eq. 6 and from the exact motion, h = 0.1 s",
                .caption =
                    "Which of the two printed schemes is nearer depends on whether Eq. 6 as "
                    "plotted or the exact motion is the target.",
                .x = {.label = "c (N s/m)"},
                .y = {.label = "RMS distance (m)", .logarithmic = true}};
  for (std::size_t i = 1; i < 4; ++i) {
    Series equation{.label = contenders()[i].title + " - Eq. 6", .style = Series::Style::dashed};
    Series exact{.label = contenders()[i].title + " - exact",
                 .style = Series::Style::line_and_points};
    for (const Round& round : rounds) {
      if (round.h != 0.1) { continue; }
      equation.x.push_back(round.c);
      equation.y.push_back(round.from_equation[i]);
      exact.x.push_back(round.c);
      exact.y.push_back(round.from_exact[i]);
    }
    figure.series.push_back(std::move(equation));
    figure.series.push_back(std::move(exact));
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

std::vector<Case> comparison_cases() {
  return {{.name = "oscillator/who-is-closest",
           .suite = "accuracy",
           .claim =
               "Which scheme follows best depends on the target, Eq. 6 as plotted or the exact "
               "motion.",
           .measure = measure_closest,
           .weight = 1.0}};
}

}  // namespace palpate::oscillator
