// SPDX-License-Identifier: MIT

#include "validation/gate/baseline.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "model/problem/input_error.hpp"
#include "validation/gate/gate.hpp"
#include "validation/number_text.hpp"

namespace palpate::gate {

namespace {

Series points_over_index(const std::string& label, const std::vector<double>& values) {
  Series series{.label = label, .style = Series::Style::points, .y = values};
  series.x.resize(series.y.size());
  std::iota(series.x.begin(), series.x.end(), 0.0);
  return series;
}

/// Replaces maps by curves of their values over the index, so that one rule applies to both. The
/// values of each axis are a figure of their own, because a difference is compared with the range
/// of all curves of its figure.
void replace_maps(std::deque<Figure>& figures) {
  const std::size_t given = figures.size();
  for (std::size_t n = 0; n < given; ++n) {
    if (!figures[n].heat_map) { continue; }
    const HeatMap map = *std::exchange(figures[n].heat_map, std::nullopt);
    figures[n].series.push_back(points_over_index(map.label, map.z));
    const Figure of = figures[n];
    figures.push_back({.id = of.id + "-x",
                       .title = of.title,
                       .y = of.x,
                       .series = {points_over_index("", map.x)}});
    figures.push_back({.id = of.id + "-y",
                       .title = of.title,
                       .y = of.y,
                       .series = {points_over_index("", map.y)}});
  }
}

[[noreturn]] void refuse(const Outcome& accepted, const std::string& what) {
  throw InputError(accepted.name + ": " + what +
                   "; results of the same cases that differ by rounding alone, or none (for a run "
                   "--no-variants)");
}

const Outcome& same_case(const std::vector<Outcome>& outcomes, const Outcome& accepted) {
  const auto found = std::ranges::find(outcomes, accepted.name, &Outcome::name);
  if (found == outcomes.end()) { refuse(accepted, "is not in a variant"); }
  return *found;
}

/// Widens the spread by one difference; differences that are not finite are ignored.
void widen(double& spread, double accepted, double variant) {
  const double difference = std::abs(variant - accepted);
  if (std::isfinite(difference)) { spread = std::max(spread, difference); }
}

void widen_by_quantities(AcceptedCase& accepted, const Outcome& variant) {
  for (const Quantity& quantity : accepted.outcome.quantities) {
    const auto found = std::ranges::find(variant.quantities, quantity.name, &Quantity::name);
    if (found == variant.quantities.end()) {
      refuse(accepted.outcome, quantity.name + " is not in a variant");
    }
    widen(accepted.spread.quantities[quantity.name], quantity.value, found->value);
  }
  for (const Quantity& quantity : variant.quantities) {
    if (!accepted.spread.quantities.contains(quantity.name)) {
      refuse(accepted.outcome, quantity.name + " is in a variant only");
    }
  }
}

void widen_by_figures(AcceptedCase& accepted, const Outcome& variant) {
  for (const Figure& figure : accepted.outcome.figures) {
    const auto found = std::ranges::find(variant.figures, figure.id, &Figure::id);
    if (found == variant.figures.end() || found->series.size() != figure.series.size()) {
      refuse(accepted.outcome, "figure " + figure.id + " differs in a variant");
    }
    for (std::size_t n = 0; n < figure.series.size(); ++n) {
      if (found->series[n].y.size() != figure.series[n].y.size()) {
        refuse(accepted.outcome,
               curve_name(figure, n) + " has " + std::to_string(found->series[n].y.size()) +
                   " samples in a variant instead of " + std::to_string(figure.series[n].y.size()));
      }
      double& spread = accepted.spread.curves[curve_name(figure, n)];
      widen(spread, 0.0, curve_difference(figure, *found, n));
    }
  }
}

/// Returns the text of a cell; empty if it is none.
std::string text_of(const std::vector<Cell>& row, std::size_t column) {
  const auto* text = column < row.size() ? std::get_if<std::string>(&row[column]) : nullptr;
  return text != nullptr ? *text : std::string();
}

/// Marks the warnings that only one of both has. Other texts must be the same.
void widen_by_texts(AcceptedCase& accepted, const Outcome& variant) {
  std::map<std::string, std::string> others = compared_texts(variant);
  for (Table& table : accepted.outcome.tables) {
    for (std::vector<Cell>& row : table.rows) {
      const std::string name = text_of(row, 0);
      const auto other = others.find(name);
      const bool same = other != others.end() && other->second == text_of(row, 1);
      if (!same && !name.starts_with(warning_prefix)) {
        refuse(accepted.outcome, name + " differs in a variant");
      }
      if (!same) { row[1] = depends_on_rounding; }
      others.erase(name);
    }
    for (const auto& [name, text] : others) {
      if (!name.starts_with(warning_prefix)) {
        refuse(accepted.outcome, name + " is in a variant only");
      }
      table.rows.push_back({name, depends_on_rounding});
    }
  }
}

}  // namespace

const AcceptedCase* Baseline::find(const std::string& name) const {
  const auto found =
      std::ranges::find(cases, name, [](const AcceptedCase& one) { return one.outcome.name; });
  return found == cases.end() ? nullptr : &*found;
}

bool is_counted(const std::string& unit) {
  constexpr std::array<std::string_view, 4> counted{"instructions", "instructions/spring-step",
                                                    "evaluations", "digits"};
  return std::ranges::find(counted, unit) != counted.end();
}

Outcome comparable(Outcome outcome) {
  outcome.seconds = 0.0;
  outcome.timings.clear();
  std::erase_if(outcome.tables, [](const Table& table) { return table.id != text_table; });
  outcome.notes.clear();
  std::erase_if(outcome.figures, [](const Figure& figure) { return figure.timing; });
  if (outcome.suite == "timing") {
    std::erase_if(outcome.quantities, [](const Quantity& q) { return !is_counted(q.unit); });
    outcome.figures.clear();
  }
  replace_maps(outcome.figures);
  return outcome;
}

std::map<std::string, std::string> compared_texts(const Outcome& outcome) {
  std::map<std::string, std::string> texts;
  for (const Table& table : outcome.tables) {
    if (table.id != text_table) { continue; }
    for (const std::vector<Cell>& row : table.rows) { texts[text_of(row, 0)] = text_of(row, 1); }
  }
  return texts;
}

std::string curve_name(const Figure& figure, std::size_t series) {
  const std::string& label = figure.series[series].label;
  const auto same = [&](const Series& other) { return other.label == label; };
  std::string name = figure.id + (label.empty() ? "" : ": " + label);
  if (std::ranges::count_if(figure.series, same) > 1) { name += " #" + std::to_string(series + 1); }
  return name;
}

void measure_spread(Baseline& baseline, const std::vector<std::vector<Outcome>>& variants) {
  for (AcceptedCase& accepted : baseline.cases) {
    accepted.spread = {.runs = static_cast<int>(variants.size())};
    for (const std::vector<Outcome>& variant : variants) {
      const Outcome found = comparable(same_case(variant, accepted.outcome));
      widen_by_quantities(accepted, found);
      widen_by_figures(accepted, found);
      widen_by_texts(accepted, found);
    }
  }
}

namespace {

void require_sound(const Outcome& outcome) {
  constexpr const char* wanted = "; a case that ran to its end, with finite numbers";
  if (outcome.status == Status::error) {
    throw InputError(outcome.name + ": " + outcome.reason() + wanted);
  }
  for (const Quantity& quantity : outcome.quantities) {
    if (std::isfinite(quantity.value)) { continue; }
    throw InputError(outcome.name + ": " + quantity.name + " is " + plain_number(quantity.value) +
                     wanted);
  }
}

bool fails(const Outcome& outcome) {
  return outcome.status != Status::pass && outcome.status != Status::skip;
}

/// Throws InputError with every failing case that the acceptance does not name.
void require_named_failures(const Acceptance& acceptance, const std::vector<std::string>& taken) {
  std::string unnamed;
  for (const Outcome& outcome : acceptance.outcomes) {
    const bool named =
        std::ranges::find(acceptance.failing, outcome.name) != acceptance.failing.end();
    if (named || !fails(outcome) || std::ranges::find(taken, outcome.name) == taken.end()) {
      continue;
    }
    unnamed += (unnamed.empty() ? "" : "\n") + outcome.name + ": is " +
               std::string(name_of(outcome.status)) +
               (outcome.reasons.empty() ? "" : " (" + outcome.reasons.front() + ")") +
               "; a case that passes, or --accept-failing " + outcome.name;
  }
  if (!unnamed.empty()) { throw InputError(unnamed); }
}

AcceptedCase* find(Baseline& baseline, const std::string& name) {
  return const_cast<AcceptedCase*>(std::as_const(baseline).find(name));
}

bool is_wanted(const Acceptance& acceptance, const std::string& name) {
  return acceptance.only.empty() ||
         std::ranges::find(acceptance.only, name) != acceptance.only.end();
}

/// Measures the spreads of the cases that are accepted now; the others keep theirs.
void measure_spreads(Baseline& baseline, const Acceptance& acceptance) {
  if (acceptance.variants.empty()) { return; }
  Baseline taken;
  for (const AcceptedCase& one : baseline.cases) {
    if (is_wanted(acceptance, one.outcome.name)) { taken.cases.push_back(one); }
  }
  measure_spread(taken, acceptance.variants);
  for (const AcceptedCase& one : taken.cases) { *find(baseline, one.outcome.name) = one; }
}

std::string bound_text(const Quantity& quantity) {
  if (!quantity.judged()) { return "no bound"; }
  return "bound " + plain_number(quantity.lower) + " to " + plain_number(quantity.upper) + " (" +
         quantity.bound_from + ")";
}

void describe_case(const AcceptedCase& before, const AcceptedCase& now,
                   std::vector<std::string>& lines) {
  for (const Change& change : compare_case(before, now.outcome).changes) {
    const auto quantity = std::ranges::find(now.outcome.quantities, change.item, &Quantity::name);
    std::string line = now.outcome.name + ": " + change.item;
    if (quantity != now.outcome.quantities.end() && change.kind != ChangeKind::broken) {
      const int digits = digits_apart(change.before, change.now);
      line += " " + plain_number(change.before, digits) + " -> " +
              plain_number(change.now, digits) + " " + change.unit + ", " + bound_text(*quantity);
    }
    lines.push_back(line + (change.moved.empty() ? "" : ", " + change.moved));
  }
}

/// Adds the quantities and curves that rounding moves by more than the gate allows elsewhere.
void describe_wide_spreads(const AcceptedCase& accepted, std::vector<std::string>& lines) {
  for (const Quantity& quantity : accepted.outcome.quantities) {
    const auto spread = accepted.spread.quantities.find(quantity.name);
    if (spread == accepted.spread.quantities.end()) { continue; }
    const double allowed = spread_margin * spread->second;
    const double elsewhere =
        std::max(allowed_share * std::abs(quantity.value), floor_of(quantity.unit));
    if (!(allowed > elsewhere)) { continue; }
    lines.push_back(accepted.outcome.name + ": " + quantity.name + ": rounding moves it by " +
                    plain_number(spread->second, 2) + ", so the gate allows " +
                    plain_number(allowed, 2) + " " + quantity.unit + " around " +
                    plain_number(quantity.value));
  }
  for (const Figure& figure : accepted.outcome.figures) {
    for (std::size_t n = 0; n < figure.series.size(); ++n) {
      const std::string name = curve_name(figure, n);
      const auto spread = accepted.spread.curves.find(name);
      if (figure.y.logarithmic || spread == accepted.spread.curves.end()) { continue; }
      const double allowed = spread_margin * spread->second;
      const double tube = tube_around(figure, n).y;
      if (!(allowed > tube)) { continue; }
      lines.push_back(accepted.outcome.name + ": " + name + ": rounding moves it by " +
                      plain_number(spread->second, 2) + ", so the gate allows " +
                      plain_number(allowed, 2) + " in place of " + plain_number(tube, 2) + " of " +
                      figure.y.label);
    }
  }
}

}  // namespace

Baseline accept(const Baseline& old, const Acceptance& acceptance) {
  if (!acceptance.only.empty() && !old.cases.empty()) {
    const std::string problem = command_problem(old.command, acceptance.command, true);
    if (!problem.empty()) {
      throw InputError(problem + "; results with the same options, or all cases (without --case)");
    }
  }
  Baseline updated = old;
  if (acceptance.only.empty() || old.cases.empty()) {
    updated.command = acceptance.command;
    updated.provenance = acceptance.provenance;
  }
  if (acceptance.only.empty()) {
    std::erase_if(updated.cases, [&](const AcceptedCase& one) {
      return std::ranges::find(acceptance.outcomes, one.outcome.name, &Outcome::name) ==
             acceptance.outcomes.end();
    });
  }
  Approval entry{.date = acceptance.date, .reason = acceptance.reason};
  if (const auto commit = acceptance.provenance.find("commit");
      commit != acceptance.provenance.end()) {
    entry.commit = commit->second;
  }
  for (const Outcome& outcome : acceptance.outcomes) {
    if (!is_wanted(acceptance, outcome.name)) { continue; }
    const Outcome taken = comparable(outcome);
    require_sound(taken);
    AcceptedCase* accepted = find(updated, taken.name);
    // Replaced in place, so that a partial approval keeps the order of the other cases.
    (accepted != nullptr ? *accepted : updated.cases.emplace_back()).outcome = taken;
    entry.cases.push_back(outcome.name);
  }
  if (entry.cases.empty()) {
    throw InputError("nothing to approve; results with at least one case");
  }
  require_named_failures(acceptance, entry.cases);
  measure_spreads(updated, acceptance);
  updated.ledger.push_back(std::move(entry));
  return updated;
}

std::vector<std::string> described_changes(const Baseline& old, const Baseline& updated) {
  std::vector<std::string> lines;
  for (const AcceptedCase& now : updated.cases) {
    const AcceptedCase* before = old.find(now.outcome.name);
    if (before == nullptr) {
      lines.push_back(now.outcome.name + ": new");
    } else {
      describe_case(*before, now, lines);
    }
    const bool taken = std::ranges::count(updated.ledger.back().cases, now.outcome.name) > 0;
    if (taken) { describe_wide_spreads(now, lines); }
    if (taken && fails(now.outcome)) {
      lines.push_back(now.outcome.name + ": accepted although it is " +
                      std::string(name_of(now.outcome.status)) +
                      (now.outcome.reasons.empty() ? "" : ": " + now.outcome.reason()));
    }
  }
  for (const AcceptedCase& before : old.cases) {
    if (updated.find(before.outcome.name) == nullptr) {
      lines.push_back(before.outcome.name + ": dropped");
    }
  }
  return lines;
}

}  // namespace palpate::gate
