// SPDX-License-Identifier: MIT
/// Measured stability limit of every scheme, compared with theory.

#include "model/stepping/stability.hpp"
#include "validation/claims/groups.hpp"
#include "validation/claims/oscillator_fixture.hpp"

namespace palpate::oscillator {

namespace {

constexpr double precision = 1e-3;       ///< of the limit found
constexpr double last_bracket = 2.5e-4;  ///< relative width at which bisection ends
Oscillator with_damping_ratio(double s) { return paper_oscillator(2.0 * s); }

double largest(const std::vector<double>& x, std::size_t begin, std::size_t end) {
  Largest value;
  for (std::size_t n = begin; n < end; ++n) { value.add(std::abs(x[n])); }
  return value.value();
}

/// A motion that decays by this factor is stable; far below it squares underflow.
constexpr double vanished = 1e-100;

/// Returns true if a run ends larger than in its second quarter, past the decaying parts.
bool grows(const CaseContext& context, const Oscillator& oscillator, std::string_view scheme,
           double h, long steps) {
  const Samples samples = run(context, oscillator, scheme, h, steps);
  const std::size_t count = samples.position.size();
  const bool whole = count == static_cast<std::size_t>(steps) + 1;
  if (samples.diverged || !whole || std::isnan(largest(samples.position, 0, count))) {
    return true;
  }
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
    if (bad > 1e3) { return {unbounded, 0.0}; }
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
  outcome.judge_between("limit of h omega0 found, " + label, found.limit,
                        theory * (1.0 - precision), theory * (1.0 + precision),
                        "theory: " + text(theory) + ", within the 0.1 % of the search");
  const double planned = stable_step(info, 1.0, 2.0 * s);
  outcome.judge_near("limit that the model plans with, " + label, planned / theory, 1.0, 1e-6,
                     "theory; rounding of 1e-13 in |A| moves a double root by its root");
  table.rows.push_back({s, found.limit, found.uncertain, theory, planned});
  measured.add(s, found.limit);
}

/// W(n) = x(n)^2 - x(n+1) x(n-1) is multiplied by the determinant of the step at every step; for a
/// pair of complex eigenvalues that is the square of their size.
double growth_per_step(const Samples& samples) {
  const auto& x = samples.position;
  if (x.size() < 4) { return std::nan(""); }
  const auto w = [&x](std::size_t n) { return x[n] * x[n] - x[n + 1] * x[n - 1]; };
  const std::size_t last = x.size() - 2;
  return std::pow(w(last) / w(1), 0.5 / static_cast<double>(last - 1));
}

/// Growth of explicit Euler with the settings of the paper: |A|^2 = 1 - c h / m + k h^2 / m.
void judge_paper_setting(const CaseContext& context, Outcome& outcome) {
  const auto judge = [&](double c, double h, long steps, const std::string& what) {
    const Samples motion = run(context, paper_oscillator(c), "euler", h, steps);
    const double theory = std::sqrt(1.0 - c * h + h * h);
    // Each of about 10 operations a step errs by eps, magnified by 1/h^2 where W cancels.
    const double rounding = 10.0 * epsilon / (h * h) + 10.0 * epsilon;
    outcome.judge_near("growth per step, c = " + text(c) + ", h = " + text(h) + " (" + what + ")",
                       growth_per_step(motion), theory, rounding, "theory: sqrt(1 - c h + h^2)");
  };
  judge(0.1, 0.25, 400, "diverges");
  judge(0.1, 0.1, 20000, "on the border");
  for (const double h : {0.25, 0.1, 0.01, 0.001}) { judge(0.0, h, 400, "no step is stable"); }
  const Samples gone = run(context, paper_oscillator(0.1), "euler", 0.25, 2000);
  outcome.judge_true("c = 0.1, h = 0.25 leaves every bound", gone.diverged,
                     "theory: 1.0375^(n/2) passes 1e6 at n = 751");
  outcome.notes.emplace_back(
      "Explicit Euler without damping grows at every step length; with c = 0.1 N s/m it diverges "
      "at h = 0.25 s and h = 0.1 s lies exactly on the border, where it neither grows nor decays.");
}

/// Implicit schemes at steps a thousand times the time scale.
void judge_unlimited(const CaseContext& context, Outcome& outcome, const IntegratorInfo& info) {
  const double h = 1e3;
  const long steps = context.quick ? 200 : 1000;
  for (const double s : {0.0, 0.05, 0.5, 0.9}) {
    const Samples samples = run(context, with_damping_ratio(s), info.name, h, steps);
    const double reach = samples.position.size() == static_cast<std::size_t>(steps) + 1
                             ? largest(samples.position, 0, samples.position.size())
                             : std::nan("");
    // The solver stops within 64 eps of v, which h turns into a position.
    const double rounding = 64.0 * epsilon * h * static_cast<double>(steps);
    outcome.judge_at_most("largest |x| at h omega0 = 1000, S = " + text(s), reach, 1.0 + rounding,
                          "theory: no step amplifies; 64 eps h per step of rounding", "m");
  }
  outcome.notes.push_back(std::string(info.name) + " has no limit: it is stable at every step.");
}

void measure_stability(const IntegratorInfo& info, const CaseContext& context, Outcome& outcome) {
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
  Table& table = outcome.table("limits", "Longest stable step of " + std::string(info.name),
                               "Found by bisection on runs of the model, and by theory.",
                               {"S (1)", "h omega0 found (1)", "half of the last bracket (1)",
                                "theory (1)", "planned with (1)"});
  Series measured{.label = "found by bisection", .style = Series::Style::points};
  for (const double s : ratios) { judge_limit(context, outcome, info, s, table, measured); }
  Series line{.label = "theory"};
  for (int n = 0; n <= 90; ++n) {
    line.add(0.01 * n, reference::stability_limit(info.name, 1.0, 0.01 * n));
  }
  outcome.figures.push_back(plot("limit", "Longest stable step of " + std::string(info.name),
                                 "The step at which runs begin to grow, found by bisection, lies "
                                 "on the limit that theory gives for every damping.",
                                 {"damping ratio S (1)"}, {.label = "h omega0 (1)", .minimum = 0.0},
                                 {std::move(line), std::move(measured)}));
}

}  // namespace

std::vector<Case> stability_limit_cases() {
  std::vector<Case> cases;
  add_scheme_cases(cases, "oscillator/stability-limit/", "stability",
                   [](const IntegratorInfo& info) {
                     const std::string scheme(info.name);
                     return info.implicit ? scheme + " is stable at every step."
                                          : "The longest stable step of " + scheme +
                                                " is the one that theory gives, at every damping.";
                   },
                   measure_stability, {.explicit_scheme = 2.0, .implicit_scheme = 0.2});
  return cases;
}

}  // namespace palpate::oscillator
