// SPDX-License-Identifier: MIT
/// Comparison of several simulators: their results on the same cases.

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "reports/results/results.hpp"
#include "validation/number_text.hpp"

namespace palpate {

namespace {

constexpr std::string_view group = "subject/";

std::string name_in(const Results& results) {
  const std::string name = entry(results.provenance, "subject");
  return name.empty() ? "palpate" : name;
}

const Outcome* find_case(const Results& results, const std::string& name) {
  const auto found = std::ranges::find(results.outcomes, name, &Outcome::name);
  return found == results.outcomes.end() ? nullptr : &*found;
}

/// "pass, 40 %": the share of the bound that the tightest quantity of the subject uses.
std::string cell_text(const Outcome* outcome) {
  if (outcome == nullptr) { return "-"; }
  const std::string status(name_of(outcome->status));
  Outcome own{.quantities = outcome->quantities};
  // A value that is equal to its bound, as a yes is, would be shown as 100 %.
  std::erase_if(own.quantities, [](const Quantity& q) {
    return q.name.starts_with("reference_") || q.value == q.lower || q.value == q.upper;
  });
  const Quantity* tightest = tightest_quantity(own);
  if (outcome->status == Status::skip || tightest == nullptr) { return status; }
  const double share = share_of_bound(*tightest);
  if (!std::isfinite(share)) { return status; }
  return status + ", " + (share < 1e-3 ? "< 0.1 %" : plain_number(100.0 * share, 2) + " %");
}

/// One step length of S26: its error and its cost.
struct Point {
  double step = 0.0;   ///< [ms]
  double error = 0.0;  ///< largest, over the peak [1]
  double cost = 0.0;   ///< [us a simulated ms]
};

/// Points of a subject, from the quantities and timings of its case s26.
std::vector<Point> points_of(const Results& results) {
  const Outcome* s26 = find_case(results, std::string(group) + "s26");
  std::vector<Point> points;
  if (s26 == nullptr) { return points; }
  constexpr std::string_view prefix = "largest_error_at_";
  for (const Quantity& q : s26->quantities) {
    if (!q.name.starts_with(prefix)) { continue; }
    const std::string tag = q.name.substr(prefix.size());
    const auto timing = std::ranges::find(s26->timings, "step_at_" + tag, &Timing::name);
    const double step = std::atof(tag.c_str());
    if (timing == s26->timings.end() || !(step > 0.0) || !(timing->value > 0.0)) { continue; }
    points.push_back({step, q.value, timing->value / step});
  }
  return points;
}

/// Cost at an error, on the line through the points in logarithms; beyond them it is an
/// extrapolation by at most a factor of ten in the error. Empty if there is none.
std::optional<double> cost_at(const std::vector<Point>& points, double error) {
  if (points.empty()) { return {}; }
  const Point& coarse = points.front();
  const Point& fine = points.back();
  if (coarse.error <= error) { return coarse.cost; }
  if (points.size() < 2 || !(fine.error < coarse.error) || error < 0.1 * fine.error) { return {}; }
  const double slope = std::log(fine.cost / coarse.cost) / std::log(fine.error / coarse.error);
  return coarse.cost * std::pow(error / coarse.error, slope);
}

}  // namespace

Results subject_matrix(const std::vector<Results>& subjects) {
  Outcome outcome{.name = "subjects",
                  .suite = "accuracy",
                  .claim =
                      "Every subject is judged by the same cases; what it does not declare is "
                      "skipped and lowers its coverage.",
                  .status = Status::pass};
  std::vector<std::string> columns{"case"};
  std::set<std::string> seen;
  std::vector<std::string> cases;
  for (const Results& one : subjects) {
    columns.push_back(name_in(one));
    const bool foreign = !entry(one.provenance, "subject").empty();
    for (const Outcome& each : one.outcomes) {
      const bool shown = each.status != Status::skip && (foreign || each.name.starts_with(group));
      if (shown && seen.insert(each.name).second) { cases.push_back(each.name); }
    }
  }
  Table& verdicts = outcome.table(
      "verdicts", "Verdicts",
      "Status of each case, and the share of its bound that the tightest "
      "quantity uses: below 100 % it holds. Cases that no subject is judged by are left out.",
      columns);
  for (const std::string& name : cases) {
    std::vector<Cell> row{name.starts_with(group) ? name.substr(group.size()) : name};
    for (const Results& one : subjects) { row.emplace_back(cell_text(find_case(one, name))); }
    verdicts.rows.push_back(std::move(row));
  }
  Table& coverage = outcome.table("coverage", "Coverage",
                                  "Cases judged of all, and how the subject is connected.",
                                  {"subject", "passed", "failed", "skipped", "carrier"});
  for (const Results& one : subjects) {
    const Tally sum = tally(one.outcomes);
    const std::string carrier = entry(one.provenance, "subject carrier");
    coverage.rows.push_back({name_in(one), sum.passed, sum.not_passed(), sum.skipped,
                             carrier.empty() ? "in process" : carrier});
    outcome.judge_at_most("not_passed_" + name_in(one), sum.not_passed(), 0.0,
                          "every case that a subject declares to support holds");
  }
  Table& cost = outcome.table(
      "cost", "Cost at equal error, S26 with 1000 masses",
      "Microseconds of computing for a simulated millisecond at 5, 1 and 0.2 % of the peak along "
      "the whole trajectory, on the line through the measured steps. Tip: error at 0.1 s, with "
      "steps of 1 ms, of its displacement. Over a pipe the empty call is part of every step; it is "
      "a control and is not subtracted.",
      {"subject", "error at 1 ms (1)", "tip at 1 ms (%)", "order observed", "us at 5 %",
       "us at 1 %", "us at 0.2 %", "empty call (us)", "slowest step (us)"});
  cost.timing = true;
  Figure& figure =
      outcome.plot("work-precision", "Cost against error, S26 with 1000 masses",
                   "Computing time for a simulated millisecond against the largest "
                   "error along the trajectory, at steps of 1, 0.5 and 0.25 ms.",
                   logarithmic("largest error over the peak"), logarithmic("us a simulated ms"));
  figure.timing = true;
  for (const Results& one : subjects) {
    const std::vector<Point> points = points_of(one);
    const Outcome* s26 = find_case(one, std::string(group) + "s26");
    const auto timing = [&](const char* name) -> Cell {
      if (s26 == nullptr) { return "-"; }
      const auto found = std::ranges::find(s26->timings, name, &Timing::name);
      return found == s26->timings.end() ? Cell("-") : Cell(found->value);
    };
    const auto measured = [&](const char* name, double factor) -> Cell {
      if (s26 == nullptr) { return "-"; }
      const auto found = std::ranges::find(s26->quantities, name, &Quantity::name);
      return found == s26->quantities.end() ? Cell("-") : Cell(factor * found->value);
    };
    std::vector<Cell> row{name_in(one), points.empty() ? Cell("-") : Cell(points.front().error),
                          measured("error_at_100_ms_at_1_ms", 100.0),
                          measured("observed_order", 1.0)};
    for (const double error : {0.05, 0.01, 0.002}) {
      const std::optional<double> found = cost_at(points, error);
      row.push_back(found ? Cell(*found) : Cell("-"));
    }
    row.push_back(timing("empty call"));
    row.push_back(timing("slowest step"));
    cost.rows.push_back(std::move(row));
    if (points.empty()) { continue; }
    Series& series = figure.add(name_in(one), Series::Style::line_and_points);
    for (const Point& point : points) { series.add(point.error, point.cost); }
  }
  Results results{.title = "Simulators compared"};
  if (!subjects.empty()) { results.provenance = subjects.front().provenance; }
  for (const char* key :
       {"subject", "subject carrier", "subject licence", "subject capabilities", "coverage"}) {
    results.provenance.erase(key);
  }
  conclude(outcome);
  results.outcomes.push_back(std::move(outcome));
  return results;
}

}  // namespace palpate
