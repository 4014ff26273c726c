// SPDX-License-Identifier: MIT
#include "validation/gate/baseline.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "model/dynamics/scene_check.hpp"

namespace palpate::gate {

namespace {

/// The colours of a map as a curve over their places, so that one rule serves both.
void add_map_as_curve(Figure& figure) {
  if (!figure.heat_map) { return; }
  Series series{.label = figure.heat_map->label, .style = Series::Style::points, .y = figure.heat_map->z};
  series.x.resize(series.y.size());
  std::iota(series.x.begin(), series.x.end(), 0.0);
  figure.series.push_back(std::move(series));
  figure.heat_map.reset();
}

[[noreturn]] void refuse(const Outcome& accepted, const std::string& what) {
  throw InputError(accepted.name + ": " + what + "; results of the same cases, another build or order");
}

const Outcome& same_case(const std::vector<Outcome>& outcomes, const Outcome& accepted) {
  const auto found = std::ranges::find(outcomes, accepted.name, &Outcome::name);
  if (found == outcomes.end()) { refuse(accepted, "is not in a variant"); }
  return *found;
}

/// Between the accepted value and every variant's; what is not finite anywhere tells nothing.
void widen(double& spread, double accepted, double variant) {
  const double difference = std::abs(variant - accepted);
  if (std::isfinite(difference)) { spread = std::max(spread, difference); }
}

void widen_by_quantities(AcceptedCase& accepted, const Outcome& variant) {
  for (const Quantity& quantity : accepted.outcome.quantities) {
    const auto found = std::ranges::find(variant.quantities, quantity.name, &Quantity::name);
    if (found == variant.quantities.end()) { refuse(accepted.outcome, quantity.name + " is not in a variant"); }
    widen(accepted.spread.quantities[quantity.name], quantity.value, found->value);
  }
}

void widen_by_curve(double& spread, const std::vector<double>& accepted, const std::vector<double>& variant) {
  for (std::size_t n = 0; n < accepted.size() && n < variant.size(); ++n) {
    widen(spread, accepted[n], variant[n]);
  }
}

void widen_by_figures(AcceptedCase& accepted, const Outcome& variant) {
  for (const Figure& figure : accepted.outcome.figures) {
    const auto found = std::ranges::find(variant.figures, figure.id, &Figure::id);
    if (found == variant.figures.end() || found->series.size() != figure.series.size()) {
      refuse(accepted.outcome, "figure " + figure.id + " differs in a variant");
    }
    for (std::size_t n = 0; n < figure.series.size(); ++n) {
      double& spread = accepted.spread.curves[curve_name(figure, n)];
      widen_by_curve(spread, figure.series[n].y, found->series[n].y);
      widen_by_curve(spread, figure.series[n].y2, found->series[n].y2);
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
  constexpr std::array<std::string_view, 4> counted{"instructions", "instructions/spring-step", "evaluations",
                                                    "digits"};
  return std::ranges::find(counted, unit) != counted.end();
}

Outcome comparable(Outcome outcome) {
  outcome.seconds = 0.0;
  outcome.timings.clear();
  outcome.tables.clear();
  outcome.notes.clear();
  std::erase_if(outcome.figures, [](const Figure& figure) { return figure.timing; });
  if (outcome.suite == "timing") {
    std::erase_if(outcome.quantities, [](const Quantity& q) { return !is_counted(q.unit); });
    outcome.figures.clear();
  }
  for (Figure& figure : outcome.figures) { add_map_as_curve(figure); }
  return outcome;
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
    }
  }
}

}  // namespace palpate::gate
