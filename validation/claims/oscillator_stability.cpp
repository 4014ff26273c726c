// SPDX-License-Identifier: MIT
/// Measured stability limit of every scheme, compared with theory.

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/stepping/stability.hpp"
#include "reference/oscillator.hpp"
#include "validation/claims/oscillator_fixture.hpp"

namespace palpate::oscillator {

namespace {

constexpr double precision = 1e-3;       ///< of the limit found
constexpr double last_bracket = 2.5e-4;  ///< relative width at which bisection ends
constexpr double epsilon = std::numeric_limits<double>::epsilon();

Oscillator with_damping_ratio(double s) { return paper_oscillator(2.0 * s); }

double largest(const std::vector<double>& x, std::size_t begin, std::size_t end) {
  double value = 0.0;
  for (std::size_t n = begin; n < end; ++n) { value = worse(value, std::abs(x[n])); }
  return value;
}

/// A motion that decays by this factor is stable; far below it squares underflow and the result
/// does not describe the scheme.
constexpr double vanished = 1e-100;

/// Returns true if a run of `steps` steps ends larger than in its second quarter, when decaying
/// parts are negligible.
bool grows(const CaseContext& context, const Oscillator& oscillator, std::string_view scheme,
           double h, long steps) {
  const Trace motion = run(context, oscillator, scheme, h, steps);
  const Samples samples = samples_of(motion);
  const std::size_t count = samples.position.size();
  const bool whole = count == static_cast<std::size_t>(steps) + 1;
  if (motion.diverged || !whole || std::isnan(largest(samples.position, 0, count))) { return true; }
  const double early = largest(samples.position, count / 4, count / 2);
  const double late = largest(samples.position, 3 * (count / 4), count);
  if (late < vanished) { return false; }
  return !(late <= early * (1.0 + 1e-4));  // 1e-4: the peaks fall between samples
}

struct Found {
  double limit = 0.0;      ///< [s] 0: no step was stable
  double uncertain = 0.0;  ///< half of the last bracket
};

/// Upwards by factors of 2 until the first growth, then bisection.
Found search(const CaseContext& context, const Oscillator& oscillator, std::string_view scheme) {
  const long steps = 10000;
  const auto unstable = [&](double h) { return grows(context, oscillator, scheme, h, steps); };
  double good = 0.07;
  if (unstable(good)) { return {}; }
  double bad = 2.0 * good;
  while (!unstable(bad)) {
    good = bad;
    bad *= 2.0;
    if (bad > 1e3) { return {std::numeric_limits<double>::infinity(), 0.0}; }
  }
  while (bad - good > last_bracket * bad) {
    const double middle = 0.5 * (good + bad);
    (unstable(middle) ? bad : good) = middle;
  }
  return {0.5 * (good + bad), 0.5 * (bad - good)};
}

void judge_limit(const CaseContext& context, Outcome& outcome, const IntegratorInfo& info, double s,
                 Table& table, Series& measured) {
  const Oscillator oscillator = with_damping_ratio(s);
  const double theory = reference::stability_limit(info.name, 1.0, s);
  const Found found = search(context, oscillator, info.name);
  const std::string label = "S = " + text(s);
  outcome.judge({.name = "limit of h omega0 found, " + label,
                 .value = found.limit,
                 .lower = theory * (1.0 - precision),
                 .upper = theory * (1.0 + precision),
                 .bound_from = "theory: " + text(theory) + ", within the 0.1 % of the search"});
  const double planned = stable_step(info, 1.0, 2.0 * s);
  outcome.judge({.name = "limit that the model plans with, " + label,
                 .value = planned / theory,
                 .lower = 1.0 - 1e-6,
                 .upper = 1.0 + 1e-6,
                 .bound_from = "theory; rounding of 1e-13 in |A| moves a double root by its root"});
  table.rows.push_back({s, found.limit, found.uncertain, theory, planned});
  measured.x.push_back(s);
  measured.y.push_back(found.limit);
}

void draw_limits(const IntegratorInfo& info, Series measured, Outcome& outcome) {
  Series line{.label = "theory"};
  for (int n = 0; n <= 90; ++n) {
    line.x.push_back(0.01 * n);
    line.y.push_back(reference::stability_limit(info.name, 1.0, 0.01 * n));
  }
  outcome.figures.push_back({.id = "limit",
                             .title = "Longest stable step of " + std::string(info.name),
                             .caption = "The step at which runs begin to grow, found by bisection, "
                                        "lies on the limit that theory gives for every damping.",
                             .x = {.label = "damping ratio S (1)"},
                             .y = {.label = "h omega0 (1)", .minimum = 0.0},
                             .series = {std::move(line), std::move(measured)}});
}

/// W(n) = x(n)^2 - x(n+1) x(n-1) is multiplied by the determinant of the step at every step; for a
/// pair of complex eigenvalues that is the square of their size.
double growth_per_step(const Samples& samples) {
  const auto& x = samples.position;
  if (x.size() < 4) { return std::numeric_limits<double>::quiet_NaN(); }
  const auto w = [&x](std::size_t n) { return x[n] * x[n] - x[n + 1] * x[n - 1]; };
  const std::size_t last = x.size() - 2;
  return std::pow(w(last) / w(1), 0.5 / static_cast<double>(last - 1));
}

/// Growth of explicit Euler with the settings of the paper: |A|^2 = 1 - c h / m + k h^2 / m.
void judge_paper_setting(const CaseContext& context, Outcome& outcome) {
  const auto judge = [&](double c, double h, long steps, const std::string& what) {
    const Trace motion = run(context, paper_oscillator(c), "euler", h, steps);
    const double theory = std::sqrt(1.0 - c * h + h * h);
    // Each of about 10 operations a step errs by eps, magnified by 1/h^2 where W cancels.
    const double rounding = 10.0 * epsilon / (h * h) + 10.0 * epsilon;
    outcome.judge(
        {.name = "growth per step, c = " + text(c) + ", h = " + text(h) + " (" + what + ")",
         .value = growth_per_step(samples_of(motion)),
         .lower = theory - rounding,
         .upper = theory + rounding,
         .bound_from = "theory: sqrt(1 - c h + h^2)"});
  };
  judge(0.1, 0.25, 400, "diverges");
  judge(0.1, 0.1, 20000, "on the border");
  for (const double h : {0.25, 0.1, 0.01, 0.001}) { judge(0.0, h, 400, "no step is stable"); }
  const Trace gone = run(context, paper_oscillator(0.1), "euler", 0.25, 2000);
  outcome.judge({.name = "c = 0.1, h = 0.25 leaves every bound",
                 .value = gone.diverged ? 1.0 : 0.0,
                 .lower = 1.0,
                 .bound_from = "theory: 1.0375^(n/2) passes 1e6 at n = 751"});
  outcome.notes.emplace_back(
      "Explicit Euler without damping grows at every step length; with c = 0.1 N s/m it diverges "
      "at "
      "h = 0.25 s and h = 0.1 s lies exactly on the border, where it neither grows nor decays.");
}

/// Implicit schemes at steps a thousand times the time scale.
void judge_unlimited(const CaseContext& context, Outcome& outcome, const IntegratorInfo& info) {
  const double h = 1e3;
  const long steps = context.quick ? 200 : 1000;
  for (const double s : {0.0, 0.05, 0.5, 0.9}) {
    const Trace motion = run(context, with_damping_ratio(s), info.name, h, steps);
    const Samples samples = samples_of(motion);
    const double reach = samples.position.size() == static_cast<std::size_t>(steps) + 1
                             ? largest(samples.position, 0, samples.position.size())
                             : std::numeric_limits<double>::quiet_NaN();
    // The solver stops within 64 eps of v, which h turns into a position.
    const double rounding = 64.0 * epsilon * h * static_cast<double>(steps);
    outcome.judge({.name = "largest |x| at h omega0 = 1000, S = " + text(s),
                   .value = reach,
                   .unit = "m",
                   .upper = 1.0 + rounding,
                   .bound_from = "theory: no step amplifies; 64 eps h per step of rounding"});
  }
  outcome.notes.push_back(std::string(info.name) + " has no limit: it is stable at every step.");
}

void measure_stability(const CaseContext& context, Outcome& outcome, const IntegratorInfo& info) {
  if (info.implicit) {
    judge_unlimited(context, outcome, info);
    return;
  }
  std::vector<double> ratios{0.0, 0.05, 0.5, 0.9};
  if (context.quick) { ratios = {0.05, 0.5}; }
  if (info.name == "euler") {
    std::erase(ratios, 0.0);  // no step is stable: judged by its growth instead
    judge_paper_setting(context, outcome);
  }
  Table table{.id = "limits",
              .title = "Longest stable step of " + std::string(info.name),
              .caption = "Found by bisection on runs of the model, and by theory.",
              .columns = {"S (1)", "h omega0 found (1)", "half of the last bracket (1)",
                          "theory (1)", "planned with (1)"}};
  Series measured{.label = "found by bisection", .style = Series::Style::points};
  for (const double s : ratios) { judge_limit(context, outcome, info, s, table, measured); }
  outcome.tables.push_back(std::move(table));
  draw_limits(info, std::move(measured), outcome);
}

}  // namespace

std::vector<Case> stability_limit_cases() {
  std::vector<Case> cases;
  for (const IntegratorInfo* info : integrators()) {
    const std::string scheme(info->name);
    cases.push_back(
        {.name = "oscillator/stability-limit/" + scheme,
         .suite = "stability",
         .claim = info->implicit ? scheme + " is stable at every step."
                                 : "The longest stable step of " + scheme +
                                       " is the one that theory gives, at every damping.",
         .measure = [info](const CaseContext& context,
                           Outcome& outcome) { measure_stability(context, outcome, *info); },
         .weight = info->implicit ? 0.2 : 2.0});
  }
  return cases;
}

}  // namespace palpate::oscillator
