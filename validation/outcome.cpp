// SPDX-License-Identifier: MIT

#include "validation/outcome.hpp"

#include <algorithm>
#include <array>

#include "validation/number_text.hpp"

namespace palpate {

namespace {

int severity(Status status) {
  constexpr std::array severities{1, 3, 2, 0, 4};  // in the order of Status
  return severities[static_cast<std::size_t>(status)];
}

}  // namespace

std::string_view name_of(Status status) {
  constexpr std::array<std::string_view, 5> names{"pass", "fail", "inconclusive", "skip", "error"};
  return names[static_cast<std::size_t>(status)];
}

Status worse(Status a, Status b) { return severity(a) >= severity(b) ? a : b; }

Status Quantity::status() const {
  if (value - uncertainty >= lower && value + uncertainty <= upper) { return Status::pass; }
  const bool in_part = value + uncertainty >= lower && value - uncertainty <= upper;
  return in_part ? Status::inconclusive : Status::fail;
}

Series curve(std::string label, std::vector<double> x, std::vector<double> y, Series::Style style) {
  return {.label = std::move(label), .style = style, .x = std::move(x), .y = std::move(y)};
}

Series& Figure::add(std::string label, std::vector<double> at, std::vector<double> value,
                    Series::Style style) {
  return series.emplace_back(curve(std::move(label), std::move(at), std::move(value), style));
}

Axis logarithmic(std::string label) { return {.label = std::move(label), .logarithmic = true}; }

Figure plot(std::string id, std::string title, std::string caption, Axis x, Axis y,
            std::deque<Series> series) {
  return {std::move(id), std::move(title), std::move(caption),
          std::move(x),  std::move(y),     std::move(series)};
}

Table make_table(std::string id, std::string title, std::string caption,
                 std::vector<std::string> columns, std::vector<std::vector<Cell>> rows) {
  return {std::move(id), std::move(title), std::move(caption), std::move(columns), std::move(rows)};
}

Table& Outcome::table(std::string id, std::string title, std::string caption,
                      std::vector<std::string> columns) {
  return tables.emplace_back(
      make_table(std::move(id), std::move(title), std::move(caption), std::move(columns)));
}

Figure& Outcome::plot(std::string id, std::string title, std::string caption, Axis x, Axis y) {
  return figures.emplace_back(palpate::plot(std::move(id), std::move(title), std::move(caption),
                                            std::move(x), std::move(y)));
}

void Outcome::judge_between(std::string what, Number value, double lower, double upper,
                            std::string from, std::string unit) {
  judge({.name = std::move(what),
         .value = value.value,
         .unit = std::move(unit),
         .lower = lower,
         .upper = upper,
         .bound_from = std::move(from)});
}

void Outcome::judge_at_least(std::string what, Number value, double lower, std::string from,
                             std::string unit) {
  judge_between(std::move(what), value, lower, unbounded, std::move(from), std::move(unit));
}

void Outcome::judge_at_most(std::string what, Number value, double upper, std::string from,
                            std::string unit) {
  judge_between(std::move(what), value, -unbounded, upper, std::move(from), std::move(unit));
}

void Outcome::judge_near(std::string what, Number value, double expected, double tolerance,
                         std::string from, std::string unit) {
  judge_between(std::move(what), value, expected - tolerance, expected + tolerance, std::move(from),
                std::move(unit));
}

void Outcome::judge_equal(std::string what, Number value, Number expected, std::string from,
                          std::string unit) {
  judge_between(std::move(what), value, expected.value, expected.value, std::move(from),
                std::move(unit));
}

void Outcome::judge_true(std::string what, bool holds, std::string from) {
  judge_at_least(std::move(what), holds ? 1.0 : 0.0, 1.0, std::move(from));
}

void Outcome::report(std::string what, Number value, std::string unit) {
  judge({.name = std::move(what), .value = value.value, .unit = std::move(unit)});
}

std::string Outcome::reason() const { return join(reasons, "\n"); }

void conclude(Outcome& outcome) {
  if (outcome.status == Status::skip || outcome.status == Status::error) { return; }
  Status worst = Status::skip;
  for (const Quantity& quantity : outcome.quantities) {
    if (quantity.judged()) { worst = worse(worst, quantity.status()); }
  }
  outcome.status = worst == Status::skip ? Status::fail : worst;
  if (worst == Status::skip) { outcome.reasons = {"nothing was judged"}; }
}

void conclude(Outcome& outcome, std::vector<Reason> parts) {
  std::ranges::stable_sort(parts, std::ranges::greater{},
                           [](const Reason& one) { return severity(one.status); });
  outcome.status = parts.empty() ? Status::skip : parts.front().status;
  outcome.reasons.clear();
  for (Reason& one : parts) {
    if (!one.text.empty()) { outcome.reasons.push_back(std::move(one.text)); }
  }
}

void Tally::add(Status status) {
  constexpr std::array counts{&Tally::passed, &Tally::failed, &Tally::inconclusive, &Tally::skipped,
                              &Tally::errors};  // in the order of Status
  ++(this->*counts.at(static_cast<std::size_t>(status)));
}

Tally tally(const std::vector<Outcome>& outcomes) {
  Tally sum;
  for (const Outcome& outcome : outcomes) { sum.add(outcome.status); }
  return sum;
}

}  // namespace palpate
