// SPDX-License-Identifier: MIT
#include "validation/comparison/loss_of_resistance.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>
#include <optional>
#include <utility>

namespace palpate::comparison {

namespace {

std::string text_of(const char* format, double a, double b, double c = 0.0) {
  char buffer[160];
  std::snprintf(buffer, sizeof buffer, format, a, b, c);
  return buffer;
}

/// Largest finite value of value[n] ... value[n + width - 1] for every n; -inf where there is none.
std::vector<double> largest_ahead(std::span<const double> value, std::size_t width) {
  std::vector<double> largest(value.size(), -std::numeric_limits<double>::infinity());
  std::deque<std::size_t> falling;  // indices of candidates, the largest first
  for (std::size_t m = value.size(); m-- > 0;) {
    if (std::isfinite(value[m])) {
      while (!falling.empty() && value[falling.back()] <= value[m]) { falling.pop_back(); }
      falling.push_back(m);
    }
    if (!falling.empty() && falling.front() >= m + width) { falling.pop_front(); }
    if (!falling.empty()) { largest[m] = value[falling.front()]; }
  }
  return largest;
}

/// How often nothing was measured before each index: differences tell of any window.
std::vector<std::size_t> missing_before(std::span<const double> value) {
  std::vector<std::size_t> missing(value.size() + 1, 0);
  for (std::size_t n = 0; n < value.size(); ++n) {
    missing[n + 1] = missing[n] + (std::isfinite(value[n]) ? 0 : 1);
  }
  return missing;
}

struct Search {
  const Samples& pressure;
  const LossRule& rule;
  std::size_t reach = pressure.steps(rule.longest_fall);
  std::size_t hold = pressure.steps(rule.hold);
  std::vector<double> ahead_reach = largest_ahead(pressure.value, reach);
  std::vector<double> ahead_hold = largest_ahead(pressure.value, hold + 1);
  std::vector<std::size_t> missing = missing_before(pressure.value);
  double maximum = *std::ranges::max_element(ahead_hold);

  /// The largest pressure within reach before n.
  [[nodiscard]] double before(std::size_t n) const {
    const std::size_t first = n > reach ? n - reach : 0;
    double largest = ahead_reach[first];  // of `reach` samples from there: may pass n at the start
    if (n < reach) {
      largest = -std::numeric_limits<double>::infinity();
      for (std::size_t m = 0; m < n; ++m) { largest = std::fmax(largest, pressure.value[m]); }
    }
    return largest;
  }
  [[nodiscard]] bool counts(double peak) const { return peak > 0.0 && peak >= rule.least_peak * maximum; }
  [[nodiscard]] double level(double peak) const { return (1.0 - rule.least_drop) * peak; }
  [[nodiscard]] bool under(std::size_t n, double peak) const {
    return counts(peak) && pressure.value[n] <= level(peak);
  }
  /// A fall to n from a peak that counts.
  [[nodiscard]] bool fallen(std::size_t n) const { return under(n, before(n)); }
  /// No sample of the next 5 s that was measured lies above the level.
  [[nodiscard]] bool held(std::size_t n, double peak) const { return ahead_hold[n] <= level(peak); }
  [[nodiscard]] bool ends_within(std::size_t n) const { return n + hold >= pressure.size(); }
  /// A tenth of the plateau may be missing.
  [[nodiscard]] bool hidden(std::size_t n) const {
    const std::size_t end = std::min(n + hold + 1, pressure.size());
    return 10 * (missing[end] - missing[n]) > hold;
  }
  /// By how much of a peak the pressure falls at most within the 5 s from n.
  [[nodiscard]] double deepest(std::size_t n, double peak) const {
    double least = pressure.value[n];
    for (std::size_t m = n; m < std::min(n + hold + 1, pressure.size()); ++m) {
      least = std::fmin(least, pressure.value[m]);
    }
    return 1.0 - least / peak;
  }
};

void describe(const Search& search, std::size_t n, LossOfResistance& loss) {
  const std::span<const double> value = search.pressure.value;
  loss.fallen_index = n;
  loss.peak = search.before(n);
  const std::size_t first = n > search.reach ? n - search.reach : 0;
  loss.peak_index = first;
  for (std::size_t m = first; m < n; ++m) {
    if (value[m] >= loss.peak) { loss.peak_index = m; }
  }
  const std::size_t settled = n + search.pressure.steps(search.rule.settle);
  const std::size_t end = std::min(n + search.hold + 1, value.size());
  if (settled >= end) { return; }
  loss.plateau = quantile(value.subspan(settled, end - settled), 0.5);
  loss.plateau_samples = finite_only(value.subspan(settled, end - settled)).size();
  loss.relative_drop = 1.0 - loss.plateau / loss.peak;
  loss.weak = loss.relative_drop < 0.5;
}

bool steady(const Search& search, const LossOfResistance& loss) {
  const std::size_t begin = loss.fallen_index + search.pressure.steps(search.rule.settle);
  const auto plateau = std::span<const double>(search.pressure.value)
                           .subspan(begin, loss.fallen_index + search.hold + 1 - begin);
  return quantile(plateau, 0.95) - quantile(plateau, 0.05) <= search.rule.unsteady * loss.peak;
}

/// The first fall that holds.
std::optional<LossOfResistance> first_held(const Search& search) {
  for (std::size_t n = 1; !search.ends_within(n); ++n) {
    if (!search.fallen(n) || !search.held(n, search.before(n)) || search.hidden(n)) { continue; }
    LossOfResistance loss{.status = LossOfResistance::Status::found};
    describe(search, n, loss);
    if (std::isfinite(loss.relative_drop) && steady(search, loss)) { return loss; }
  }
  return std::nullopt;
}

/// The first fall of which a gap or the end of the trace leaves open whether it was held.
std::optional<LossOfResistance> first_open(const Search& search) {
  for (std::size_t n = 1; n < search.pressure.size(); ++n) {
    const double peak = search.before(n);
    if (!search.under(n, peak) || !search.held(n, peak)) { continue; }
    if (!search.ends_within(n) && !search.hidden(n)) { continue; }
    LossOfResistance loss{.status = LossOfResistance::Status::undecided};
    describe(search, n, loss);
    const double fall = 100.0 * search.deepest(n, peak);
    const double seen = search.pressure.step * static_cast<double>(search.pressure.size() - n);
    const double hold = search.rule.hold;
    loss.reason = search.hidden(n)
                      ? text_of("a gap hides whether a fall of %.0f %% was held for %.3g s", fall, hold)
                      : text_of("the trace ends %.2f s after a fall of %.0f %%; %.3g s needed", seen, fall, hold);
    return loss;
  }
  return std::nullopt;
}

/// A fall that took place within a gap longer than the reach, so that nobody knows how fast it was.
std::optional<LossOfResistance> first_in_a_gap(const Search& search) {
  const std::vector<double>& value = search.pressure.value;
  std::size_t last = value.size();  // that was measured
  for (std::size_t n = 0; n < value.size(); ++n) {
    if (!std::isfinite(value[n])) { continue; }
    const std::size_t before = std::exchange(last, n);
    if (before >= n || n - before <= search.reach) { continue; }
    const double peak = search.before(before + 1);
    if (!search.under(n, peak) || !search.held(n, peak)) { continue; }
    LossOfResistance loss{.status = LossOfResistance::Status::undecided};
    loss.reason = text_of("a gap of %.3g s hides how the pressure fell by %.0f %%",
                          search.pressure.step * static_cast<double>(n - before),
                          100.0 * search.deepest(n, peak));
    return loss;
  }
  return std::nullopt;
}

/// Why nothing was found, told of the deepest fall.
LossOfResistance not_found(const Search& search) {
  LossOfResistance loss;
  const std::span<const double> value = search.pressure.value;
  double deepest = 0.0;
  std::size_t at = 0;
  for (std::size_t n = 1; n < value.size(); ++n) {
    const double peak = search.before(n);
    if (search.counts(peak) && 1.0 - value[n] / peak > deepest) { deepest = 1.0 - value[n] / peak, at = n; }
  }
  if (deepest < search.rule.least_drop) {
    loss.reason = text_of("fell by %.0f %% at most within %.3g s; %.0f %% needed", 100.0 * deepest,
                          search.rule.longest_fall, 100.0 * search.rule.least_drop);
    return loss;
  }
  std::size_t begin = at;
  while (begin > 0 && search.fallen(begin - 1)) { --begin; }
  const double level = search.level(search.before(begin));
  std::size_t end = begin;
  while (end < value.size() && !(value[end] > level)) { ++end; }
  const double held = search.pressure.step * static_cast<double>(end - begin);
  loss.reason = end - begin <= search.hold
                    ? text_of("a fall of %.0f %% came back after %.2f s; %.3g s needed", 100.0 * deepest,
                              held, search.rule.hold)
                    : text_of("a fall of %.0f %% at %.2f s was not steady", 100.0 * deepest,
                              search.pressure.time(begin));
  return loss;
}

}  // namespace

std::string_view name_of(LossOfResistance::Status status) {
  switch (status) {
    case LossOfResistance::Status::found: return "found";
    case LossOfResistance::Status::undecided: return "undecided";
    case LossOfResistance::Status::not_found: break;
  }
  return "not found";
}

LossOfResistance find_loss(const Samples& pressure, const LossRule& rule) {
  LossOfResistance none{.reason = "no pressure above zero"};
  if (longest_stretch(pressure.value).size() < 3) { return none; }
  const Search search{pressure, rule};
  if (!(search.maximum > 0.0)) { return none; }
  for (const auto& step : {first_held, first_open, first_in_a_gap}) {
    if (auto loss = step(search)) { return *std::move(loss); }
  }
  return not_found(search);
}

}  // namespace palpate::comparison
