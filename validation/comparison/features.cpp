// SPDX-License-Identifier: MIT

#include "validation/comparison/features.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

#include "validation/number_text.hpp"

namespace palpate::comparison {

namespace {

/// Returns the largest finite value of value[n] ... value[n + width - 1] for every n; -inf if there
/// is none.
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

/// Returns the cumulative number of missing samples; differences give the number in any window.
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

  /// Returns the largest pressure within reach before n.
  [[nodiscard]] double before(std::size_t n) const {
    if (n >= reach) { return ahead_reach[n - reach]; }
    double largest = -std::numeric_limits<double>::infinity();
    for (std::size_t m = 0; m < n; ++m) { largest = std::fmax(largest, pressure.value[m]); }
    return largest;
  }
  [[nodiscard]] bool counts(double peak) const {
    return peak > 0.0 && peak >= rule.least_peak * maximum;
  }
  [[nodiscard]] double level(double peak) const { return (1.0 - rule.least_drop) * peak; }
  [[nodiscard]] bool under(std::size_t n, double peak) const {
    return counts(peak) && pressure.value[n] <= level(peak);
  }
  /// Returns true for a fall to n from a sufficiently large peak.
  [[nodiscard]] bool fallen(std::size_t n) const { return under(n, before(n)); }
  /// Returns true if no measured sample of the next 5 s is above the level.
  [[nodiscard]] bool held(std::size_t n, double peak) const { return ahead_hold[n] <= level(peak); }
  [[nodiscard]] bool ends_within(std::size_t n) const { return n + hold >= pressure.size(); }
  /// Returns true if more than a tenth of the plateau is missing.
  [[nodiscard]] bool hidden(std::size_t n) const {
    const std::size_t end = std::min(n + hold + 1, pressure.size());
    return 10 * (missing[end] - missing[n]) > hold;
  }
  /// Returns the largest relative drop of the pressure within the 5 s from n.
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

/// Finds the first fall that lasts long enough.
std::optional<LossOfResistance> first_held(const Search& search) {
  for (std::size_t n = 1; !search.ends_within(n); ++n) {
    if (!search.fallen(n) || !search.held(n, search.before(n)) || search.hidden(n)) { continue; }
    LossOfResistance loss{.status = LossOfResistance::Decision::found};
    describe(search, n, loss);
    if (std::isfinite(loss.relative_drop) && steady(search, loss)) { return loss; }
  }
  return std::nullopt;
}

/// Finds the first fall for which a gap or the end of the trace hides whether it lasted.
std::optional<LossOfResistance> first_open(const Search& search) {
  for (std::size_t n = 1; n < search.pressure.size(); ++n) {
    const double peak = search.before(n);
    if (!search.under(n, peak) || !search.held(n, peak)) { continue; }
    if (!search.ends_within(n) && !search.hidden(n)) { continue; }
    LossOfResistance loss{.status = LossOfResistance::Decision::undecided};
    describe(search, n, loss);
    const double fall = 100.0 * search.deepest(n, peak);
    const double seen = search.pressure.step * static_cast<double>(search.pressure.size() - n);
    const double hold = search.rule.hold;
    loss.reason =
        search.hidden(n)
            ? formatted("a gap hides whether a fall of %.0f %% was held for %.3g s", fall, hold)
            : formatted("the trace ends %.2f s after a fall of %.0f %%; %.3g s needed", seen, fall,
                        hold);
    return loss;
  }
  return std::nullopt;
}

/// Finds a fall within a gap longer than the reach, whose speed is unknown.
std::optional<LossOfResistance> first_in_a_gap(const Search& search) {
  const std::vector<double>& value = search.pressure.value;
  std::size_t last = value.size();  // that was measured
  for (std::size_t n = 0; n < value.size(); ++n) {
    if (!std::isfinite(value[n])) { continue; }
    const std::size_t before = std::exchange(last, n);
    if (before >= n || n - before <= search.reach) { continue; }
    const double peak = search.before(before + 1);
    if (!search.under(n, peak) || !search.held(n, peak)) { continue; }
    LossOfResistance loss{.status = LossOfResistance::Decision::undecided};
    loss.reason = formatted("a gap of %.3g s hides how the pressure fell by %.0f %%",
                            search.pressure.step * static_cast<double>(n - before),
                            100.0 * search.deepest(n, peak));
    return loss;
  }
  return std::nullopt;
}

/// Returns the reason why no loss was found, for the deepest fall.
LossOfResistance not_found(const Search& search) {
  LossOfResistance loss;
  const std::span<const double> value = search.pressure.value;
  double deepest = 0.0;
  std::size_t at = 0;
  for (std::size_t n = 1; n < value.size(); ++n) {
    const double peak = search.before(n);
    if (search.counts(peak) && 1.0 - value[n] / peak > deepest) {
      deepest = 1.0 - value[n] / peak, at = n;
    }
  }
  if (deepest < search.rule.least_drop) {
    loss.reason =
        formatted("fell by %.0f %% at most within %.3g s; %.0f %% needed", 100.0 * deepest,
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
                    ? formatted("a fall of %.0f %% came back after %.2f s; %.3g s needed",
                                100.0 * deepest, held, search.rule.hold)
                    : formatted("a fall of %.0f %% at %.2f s was not steady", 100.0 * deepest,
                                search.pressure.time(begin));
  return loss;
}

}  // namespace

std::string_view name_of(LossOfResistance::Decision status) {
  constexpr std::array<std::string_view, 3> names{"found", "not found", "undecided"};
  return names[static_cast<std::size_t>(status)];
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

namespace {

/// Returns the standard uncertainty of a value that is uniformly distributed over a width.
double spread_over(double width) { return width / std::sqrt(12.0); }

struct Extraction {
  const Samples& trace;
  const FeatureRule& rule;
  double noise = 0.0;        ///< of one filtered sample
  double independent = 1.0;  ///< share of filtered samples that are independent of their neighbours
  std::size_t reach = 0;     ///< correlation length of the filter in samples
};

/// Returns the slope between samples n - reach and n + 1 + reach; noise would dominate the slope
/// between neighbours.
double slope_about(const Extraction& of, std::size_t n) {
  const std::size_t first = n > of.reach ? n - of.reach : 0;
  const std::size_t last = std::min(n + 1 + of.reach, of.trace.size() - 1);
  const double wide = (of.trace.value[last] - of.trace.value[first]) /
                      (of.trace.step * static_cast<double>(last - first));
  const double narrow = (of.trace.value[n + 1] - of.trace.value[n]) / of.trace.step;
  return std::isfinite(wide) ? wide : narrow;
}

/// Returns the time at which the trace crosses a level between samples n and n + 1 [s].
Measured crossing(const Extraction& of, std::size_t n, double level) {
  const double low = of.trace.value[n];
  const double high = of.trace.value[n + 1];
  if (!std::isfinite(low) || !std::isfinite(high)) { return {.reason = "a gap hides the fall"}; }
  return {.value = of.trace.time(n) + of.trace.step * (level - low) / (high - low),
          .uncertainty = std::hypot(of.noise / slope_about(of, n), spread_over(of.trace.step))};
}

/// Returns the last fall through a level at or before sample n.
Measured last_fall(const Extraction& of, std::size_t n, double level) {
  for (std::size_t m = n; m > 0; --m) {
    if (of.trace.value[m - 1] >= level) { return crossing(of, m - 1, level); }
    if (std::isnan(of.trace.value[m - 1])) { break; }
  }
  return {.reason = "a gap hides the fall"};
}

/// Returns the first fall through a level after sample n.
Measured first_fall(const Extraction& of, std::size_t n, double level) {
  for (std::size_t m = n; m < of.trace.size(); ++m) {
    if (of.trace.value[m] <= level) { return m == 0 ? Measured{} : crossing(of, m - 1, level); }
  }
  return {.reason = "never fell to 10 % of the drop"};
}

Measured difference(const Measured& later, const Measured& earlier) {
  if (!later.value) { return later; }
  if (!earlier.value) { return earlier; }
  return {.value = *later.value - *earlier.value,
          .uncertainty = std::hypot(later.uncertainty, earlier.uncertainty)};
}

/// Returns the time of a maximum. Its uncertainty is the stretch over which the trace is within its
/// noise of the maximum.
Measured time_of(const Extraction& of, std::size_t peak) {
  const double level = of.trace.value[peak] - of.noise;
  std::size_t first = peak;
  std::size_t last = peak;
  while (first > 0 && of.trace.value[first - 1] > level) { --first; }
  while (last + 1 < of.trace.size() && of.trace.value[last + 1] > level) { ++last; }
  return {.value = of.trace.time(peak),
          .uncertainty = spread_over(of.trace.step * static_cast<double>(last - first + 1))};
}

Measured slope_before(const Extraction& of, std::size_t peak) {
  const std::size_t gap = of.trace.steps(of.rule.slope_end);
  const std::size_t width = of.trace.steps(of.rule.slope_window);
  if (peak < gap + width) { return {.reason = "less than 2.1 s before the peak"}; }
  const auto y = std::span<const double>(of.trace.value).subspan(peak - gap - width, width + 1);
  if (longest_stretch(y).size() < y.size()) { return {.reason = "a gap before the peak"}; }
  double moment = 0.0;
  double square = 0.0;
  for (std::size_t n = 0; n < y.size(); ++n) {
    const double t = of.trace.step * (static_cast<double>(n) - 0.5 * static_cast<double>(width));
    moment += t * y[n];
    square += t * t;
  }
  return {.value = moment / square, .uncertainty = of.noise / std::sqrt(square * of.independent)};
}

Measured depth_at(const Samples& depth, const Measured& time) {
  if (depth.value.empty()) { return {.reason = "depth was not recorded"}; }
  if (!time.value) { return {.reason = time.reason}; }
  const std::size_t n = depth.index_at(*time.value);
  const double here = depth.value[n];
  const double next = n + 1 < depth.size() ? depth.value[n + 1] : here;
  const double share = (*time.value - depth.time(n)) / depth.step;
  if (!std::isfinite(here) || !std::isfinite(next)) { return {.reason = "a gap in the depth"}; }
  return {.value = here + share * (next - here),
          .uncertainty = std::abs(next - here) / depth.step * time.uncertainty};
}

void measure_peak(const Extraction& of, std::size_t peak, Features& features) {
  features[Feature::peak] = {.value = of.trace.value[peak], .uncertainty = of.noise};
  features[Feature::time_of_peak] = time_of(of, peak);
  features[Feature::slope_before] = slope_before(of, peak);
}

void measure_drop(const Extraction& of, Features& features) {
  const LossOfResistance& loss = features.loss;
  const double height = loss.peak - loss.plateau;
  const double samples = std::max(1.0, static_cast<double>(loss.plateau_samples) * of.independent);
  const double of_plateau =
      std::sqrt(1.5708) * of.noise / std::sqrt(samples);  // a median's: sqrt(pi/2)
  features[Feature::plateau] = {.value = loss.plateau, .uncertainty = of_plateau};
  features[Feature::drop_height] = {.value = height,
                                    .uncertainty = std::hypot(of.noise, of_plateau)};
  features[Feature::relative_drop] = {
      .value = loss.relative_drop,
      .uncertainty = std::hypot(of_plateau, of.noise * loss.plateau / loss.peak) / loss.peak};
  const auto level = [&](double share) { return loss.plateau + share * height; };
  std::size_t middle = loss.fallen_index;
  while (middle + 1 < of.trace.size() && of.trace.value[middle] > level(0.5)) { ++middle; }
  features[Feature::time_of_loss] = last_fall(of, middle, level(0.5));
  features[Feature::drop_time] =
      difference(first_fall(of, middle, level(0.1)), last_fall(of, middle, level(0.9)));
}

std::size_t index_of_largest(std::span<const double> value) {
  std::size_t largest = longest_stretch(value).begin;
  for (std::size_t n = 0; n < value.size(); ++n) {
    if (value[n] >= value[largest]) { largest = n; }
  }
  return largest;
}

/// Name and unit of every feature; "*" is the unit of the trace.
struct Naming {
  std::string_view name;
  std::string_view unit;
};
constexpr std::array<Naming, feature_count> naming{{{"loss_of_resistance", "1"},
                                                    {"peak", "*"},
                                                    {"drop_height", "*"},
                                                    {"relative_drop", "1"},
                                                    {"drop_time", "s"},
                                                    {"plateau", "*"},
                                                    {"slope_before", "*/s"},
                                                    {"time_of_peak", "s"},
                                                    {"time_of_loss", "s"},
                                                    {"depth_of_peak", "m"},
                                                    {"depth_of_loss", "m"}}};

}  // namespace

std::string_view name_of(Feature feature) { return naming[static_cast<std::size_t>(feature)].name; }

std::string unit_of(Feature feature, std::string_view quantity) {
  std::string unit(naming[static_cast<std::size_t>(feature)].unit);
  return unit.starts_with('*') ? unit.replace(0, 1, quantity) : unit;
}

bool is_time(Feature feature) {
  return feature == Feature::time_of_peak || feature == Feature::time_of_loss;
}

double noise_of(const FeatureInput& input) {
  const double rate = 1.0 / input.raw.step;
  if (!can_filter(input.cutoff, rate) || input.raw.size() != input.filtered.size()) { return 0.0; }
  std::vector<double> removed(input.raw.size());
  for (std::size_t n = 0; n < removed.size(); ++n) {
    removed[n] = std::abs(input.raw.value[n] - input.filtered.value[n]);
  }
  const double median = quantile(removed, 0.5);
  if (!std::isfinite(median)) { return 0.0; }
  return median / 0.6745 / std::sqrt(noise_shares(input.cutoff, rate).removed);
}

Features find_features(const FeatureInput& input, const FeatureRule& rule) {
  Features features;
  features.noise = noise_of(input);
  features.loss = find_loss(input.filtered, rule.loss);
  const double passed = noise_shares(input.cutoff, 1.0 / input.raw.step).passed;
  const Extraction of{input.filtered, rule, features.noise * std::sqrt(passed), passed,
                      input.cutoff > 0.0 ? input.raw.steps(0.5 / input.cutoff) : 0};
  if (longest_stretch(input.filtered.value).size() == 0) {
    for (Measured& one : features.all) { one.reason = "no sample is a number"; }
    return features;
  }
  const bool fell = features.loss.fell();
  measure_peak(of, fell ? features.loss.peak_index : index_of_largest(input.filtered.value),
               features);
  if (fell) {
    measure_drop(of, features);
  } else {
    for (const Feature absent : {Feature::drop_height, Feature::relative_drop, Feature::drop_time,
                                 Feature::plateau, Feature::time_of_loss}) {
      features[absent].reason = "no loss of resistance: " + features.loss.reason;
    }
  }
  if (features.loss.status == LossOfResistance::Decision::undecided) {
    features[Feature::loss_of_resistance].reason = features.loss.reason;
  } else {
    features[Feature::loss_of_resistance].value = features.loss.found() ? 1.0 : 0.0;
  }
  features[Feature::depth_of_peak] = depth_at(input.depth, features[Feature::time_of_peak]);
  features[Feature::depth_of_loss] = depth_at(input.depth, features[Feature::time_of_loss]);
  return features;
}

std::string refusal_of(const RawTrace& trace) {
  if (trace.value.empty() || trace.time.empty()) { return "is empty"; }
  if (trace.value.size() != trace.time.size()) { return "has more times than values, or fewer"; }
  if (trace.value.size() == 1) { return "has one sample"; }
  for (std::size_t n = 0; n < trace.time.size(); ++n) {
    if (!std::isfinite(trace.time[n]) || (n > 0 && !(trace.time[n] > trace.time[n - 1]))) {
      return "has times that do not increase";
    }
  }
  if (trace.time.back() - trace.time.front() > 1e7 * usual_interval(trace.time)) {
    return "spans more than ten million of its usual intervals";
  }
  const std::vector<double> finite = finite_only(trace.value);
  if (finite.empty()) { return "holds no number"; }
  if (finite.size() < 10) { return "holds fewer than 10 numbers"; }
  const auto [smallest, largest] = std::ranges::minmax(finite);
  if (std::max(largest, -smallest) > largest_value) { return "holds a value beyond 1e100"; }
  if (largest - smallest <= 1e-12 * std::max(std::abs(largest), std::abs(smallest))) {
    return "is constant";
  }
  return {};
}

PreparedTrace prepare(const RawTrace& trace, double cutoff, const FeatureRule& rule) {
  PreparedTrace prepared{.refusal = refusal_of(trace)};
  if (!prepared.refusal.empty()) { return prepared; }
  prepared.input.raw = regular(trace.time, trace.value);
  prepared.input.filtered = zero_phase(prepared.input.raw, cutoff);
  prepared.input.cutoff = cutoff;
  if (trace.depth.size() == trace.time.size() && !finite_only(trace.depth).empty()) {
    prepared.input.depth = regular(trace.time, trace.depth);
  }
  if (longest_stretch(prepared.input.raw.value).size() < 3) {
    prepared.refusal = "has no three samples without a gap";
    return prepared;
  }
  prepared.features = find_features(prepared.input, rule);
  return prepared;
}

}  // namespace palpate::comparison
