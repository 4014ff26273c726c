// SPDX-License-Identifier: MIT

#include "validation/comparison/features.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

#include "validation/number_text.hpp"
#include "validation/statistics.hpp"

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

/// Returns the largest finite value before n for every n up to `count`; -inf if there is none.
std::vector<double> largest_before(std::span<const double> value, std::size_t count) {
  std::vector<double> largest{-std::numeric_limits<double>::infinity()};
  for (const double one : value.first(std::min(count, value.size()))) {
    largest.push_back(std::fmax(largest.back(), one));
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
  std::vector<double> from_start = largest_before(pressure.value, reach);
  std::vector<std::size_t> missing = missing_before(pressure.value);
  double maximum = *std::ranges::max_element(ahead_hold);

  /// Returns the largest pressure within reach before n.
  [[nodiscard]] double before(std::size_t n) const {
    return n >= reach ? ahead_reach[n - reach] : from_start[n];
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
  return {.reason = "never fell to that share of the drop"};
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
constexpr std::array<Naming, feature_count> naming{
    {{"loss_of_resistance", "1"}, {"peak", "*"},
     {"drop_height", "*"},        {"relative_drop", "1"},
     {"drop_time", "s"},          {"plateau", "*"},
     {"slope_before", "*/s"},     {"time_of_peak", "s"},
     {"time_of_loss", "s"},       {"depth_of_peak", "m"},
     {"depth_of_loss", "m"},      {"puncture", "1"},
     {"puncture_force", "*"},     {"puncture_depth", "m"},
     {"denting_exponent", "1"},   {"force_left", "*"},
     {"largest_force", "*"},      {"second_rise", "*"},
     {"relaxation", "1"},         {"relaxation_time", "s"},
     {"withdrawal_force", "*"},   {"withdrawal_depth", "m"}}};

constexpr std::array<Feature, feature_count> in_order = [] {
  std::array<Feature, feature_count> all{};
  for (std::size_t n = 0; n < feature_count; ++n) { all[n] = static_cast<Feature>(n); }
  return all;
}();
constexpr auto first_of_insertion = static_cast<std::size_t>(Feature::puncture);

/// Samples of an insertion, its phases and its features.
class InsertionMeasurement {
 public:
  InsertionMeasurement(const Extraction& of, const Samples& depth, const InsertionRule& rule,
                       Features& features)
      : of_(of), force_(of.trace.value), depth_(depth.value), rule_(rule), features_(features) {}

  void measure() {
    if (depth_.empty()) { return no_depth(); }
    threshold_ = rule_.contact.threshold(features_.noise);
    phases_.contact = find_contact(force_, depth_, threshold_, rule_.contact.distance);
    if (!phases_.contact) {
      return refuse(features_of(FeatureSet::insertion),
                    formatted("no contact: the force never stays above %.3g N over %.3g mm",
                              threshold_, 1e3 * rule_.contact.distance));
    }
    find_rest();
    locate_contact();
    const auto [force, largest] = largest_in(*phases_.contact, phases_.advance_end);
    features_[Feature::largest_force] = {.value = force, .uncertainty = of_.noise};
    measure_puncture();
    measure_relaxation();
    measure_withdrawal();
  }

 private:
  void refuse(std::span<const Feature> some, const std::string& reason) {
    for (const Feature feature : some) { features_[feature] = {.reason = reason}; }
  }

  void no_depth() {
    refuse(features_of(FeatureSet::insertion), "depth was not recorded");
    features_[Feature::largest_force] = {.value = force_[index_of_largest(force_)],
                                         .uncertainty = of_.noise};
  }

  [[nodiscard]] double time(std::size_t n) const { return of_.trace.time(n); }
  [[nodiscard]] bool measured(std::size_t n) const {
    return std::isfinite(force_[n]) && std::isfinite(depth_[n]);
  }

  struct Extreme {
    double force = not_measured;
    std::size_t at = 0;
  };
  /// Returns the first largest value among samples begin ... last.
  [[nodiscard]] Extreme largest_in(std::size_t begin, std::size_t last) const {
    Extreme found{.at = begin};
    for (std::size_t n = begin; n <= last; ++n) {
      if (measured(n) && !(force_[n] <= found.force)) { found = {force_[n], n}; }
    }
    return found;
  }
  /// Returns the first smallest value among samples begin ... last.
  [[nodiscard]] Extreme least_in(std::size_t begin, std::size_t last) const {
    Extreme found{.at = begin};
    for (std::size_t n = begin; n <= last; ++n) {
      if (measured(n) && !(force_[n] >= found.force)) { found = {force_[n], n}; }
    }
    return found;
  }

  /// Finds the rest at full depth, and whether a withdrawal follows.
  void find_rest() {
    const double deepest =
        extremes_of(std::span<const double>(depth_).subspan(*phases_.contact)).largest;
    std::size_t begin = *phases_.contact;
    while (!(depth_[begin] >= deepest - rule_.still)) { ++begin; }
    std::size_t last = begin;
    for (std::size_t n = begin; n < depth_.size() && !(depth_[n] < deepest - rule_.still); ++n) {
      if (measured(n)) { last = n; }
    }
    const auto at_rest = std::span<const double>(depth_).subspan(begin, last - begin + 1);
    phases_.held = of_.trace.step * static_cast<double>(last - begin) >= rule_.rest;
    // The needle is at full depth from where it has reached the depth at rest.
    const double full = phases_.held ? quantile(at_rest, 0.5) - 0.1 * rule_.still : deepest;
    while (!(depth_[begin] >= full)) { ++begin; }
    while (last > begin && !(depth_[last] >= full)) { --last; }
    phases_.advance_end = begin;
    phases_.hold_end = last;
    const double least_after = extremes_of(std::span<const double>(depth_).subspan(last)).least;
    phases_.withdrawn = deepest - least_after > rule_.contact.distance;
  }

  /// Sets time and depth of the contact, and the speed of the advance.
  void locate_contact() {
    const std::size_t at = *phases_.contact;
    const double duration = time(phases_.advance_end) - time(at);
    if (duration > 0.0) { phases_.speed = (depth_[phases_.advance_end] - depth_[at]) / duration; }
    const double slope = std::abs(slope_about(of_, std::min(at, force_.size() - 2)));
    const double by_noise = slope > 0.0 ? of_.noise / slope : 0.0;
    const double uncertainty = std::hypot(by_noise, spread_over(of_.trace.step));
    phases_.contact_time = {.value = time(at), .uncertainty = uncertainty};
    phases_.contact_depth = {.value = depth_[at],
                             .uncertainty = duration > 0.0 ? uncertainty * phases_.speed : 0.0};
  }

  /// First local maximum of the advance with a sufficient drop, and the least force after it.
  struct Puncture {
    std::size_t at = 0;
    std::size_t least = 0;
  };
  [[nodiscard]] std::optional<Puncture> find_puncture(double& deepest_drop) const {
    double before = -std::numeric_limits<double>::infinity();
    for (std::size_t n = *phases_.contact; n < phases_.advance_end; ++n) {
      if (!measured(n)) { continue; }
      const bool rises = force_[n] >= std::exchange(before, force_[n]);
      if (!rises) { continue; }
      const Extreme least = least_in(n, reach_of(n));
      const double drop = force_[n] - least.force;
      if (!(drop >= threshold_)) { continue; }
      if (largest_in(n, least.at).force > force_[n]) { continue; }
      deepest_drop = std::max(deepest_drop, drop / force_[n]);
      if (drop >= rule_.least_drop * force_[n]) { return Puncture{n, least.at}; }
    }
    return std::nullopt;
  }

  /// Returns the last sample of the advance within the distance of a drop from sample n.
  [[nodiscard]] std::size_t reach_of(std::size_t n) const {
    std::size_t last = n;
    for (std::size_t m = n; m <= phases_.advance_end; ++m) {
      if (depth_[m] > depth_[n] + rule_.drop_distance) { break; }
      last = m;
    }
    return last;
  }

  void measure_puncture() {
    double deepest_drop = 0.0;
    const std::optional<Puncture> found = find_puncture(deepest_drop);
    features_[Feature::puncture].value = found ? 1.0 : 0.0;
    if (!found) {
      return refuse(
          std::array{Feature::puncture_force, Feature::puncture_depth, Feature::denting_exponent,
                     Feature::force_left, Feature::second_rise},
          formatted("no drop of %.0f %% within %.3g mm; %.0f %% at most", 100.0 * rule_.least_drop,
                    1e3 * rule_.drop_distance, 100.0 * deepest_drop));
    }
    const std::size_t at = found->at;
    const double left = force_[found->least];
    features_[Feature::puncture_force] = {.value = force_[at], .uncertainty = of_.noise};
    features_[Feature::force_left] = {.value = left, .uncertainty = of_.noise};
    features_[Feature::puncture_depth] = depth_below_contact(at, time_of(of_, at).uncertainty);
    features_[Feature::denting_exponent] = exponent(at);
    const Extreme second = largest_in(found->least, phases_.advance_end);
    features_[Feature::second_rise] = {.value = second.force - left,
                                       .uncertainty = std::hypot(of_.noise, of_.noise)};
  }

  /// Returns the depth of a sample below the contact; its time has the given uncertainty.
  [[nodiscard]] Measured depth_below_contact(std::size_t n, double uncertainty) const {
    const std::size_t next = n + 1 < depth_.size() ? n + 1 : n;
    const double speed = std::abs(depth_[next] - depth_[n]) / of_.trace.step;
    return {.value = depth_[n] - *phases_.contact_depth.value,
            .uncertainty = std::hypot(std::isfinite(speed) ? speed * uncertainty : 0.0,
                                      phases_.contact_depth.uncertainty)};
  }

  /// Slope of log F over log d from a share of the dent to the puncture.
  struct Slope {
    double value = not_measured;
    double uncertainty = 0.0;
  };
  [[nodiscard]] Slope slope_of_logarithms(std::size_t puncture, double from) const {
    const double least = rule_.dent_from * (depth_[puncture] - from);
    std::vector<double> x;
    std::vector<double> y;
    for (std::size_t n = *phases_.contact; n <= puncture; ++n) {
      if (!measured(n) || !(force_[n] > 0.0) || !(depth_[n] - from >= least)) { continue; }
      x.push_back(std::log(depth_[n] - from));
      y.push_back(std::log(force_[n]));
    }
    constexpr std::size_t least_samples = 5;
    if (x.size() < least_samples) { return {}; }
    const double of_x = mean_of(x);
    const double of_y = mean_of(y);
    double moment = 0.0;
    double square = 0.0;
    for (std::size_t n = 0; n < x.size(); ++n) {
      moment += (x[n] - of_x) * (y[n] - of_y);
      square += (x[n] - of_x) * (x[n] - of_x);
    }
    Slope slope{.value = moment / square};
    double rest = 0.0;
    for (std::size_t n = 0; n < x.size(); ++n) {
      rest += std::pow(y[n] - of_y - slope.value * (x[n] - of_x), 2);
    }
    const double freedom = static_cast<double>(x.size() - 2) * of_.independent;
    slope.uncertainty = std::sqrt(rest / freedom / square);
    return slope;
  }

  [[nodiscard]] Measured exponent(std::size_t puncture) const {
    const double contact = *phases_.contact_depth.value;
    const double shift = phases_.contact_depth.uncertainty;
    const Slope slope = slope_of_logarithms(puncture, contact);
    if (!std::isfinite(slope.value)) {
      return {.reason = "fewer than 5 samples before the puncture"};
    }
    const double moved = slope_of_logarithms(puncture, contact - shift).value - slope.value;
    return {.value = slope.value,
            .uncertainty = std::hypot(slope.uncertainty, std::isfinite(moved) ? moved : 0.0)};
  }

  void measure_relaxation() {
    constexpr std::array both{Feature::relaxation, Feature::relaxation_time};
    const std::size_t begin = phases_.advance_end;
    const double length = time(phases_.hold_end) - time(begin);
    constexpr double enough = 0.9;  // of the time after which the drop is measured
    if (!phases_.held) {
      return refuse(both, formatted("no hold of %.3g s at full depth", rule_.rest));
    }
    if (length < enough * rule_.relaxation) {
      return refuse(
          both, formatted("a hold of %.3g s; %.3g s needed", length, enough * rule_.relaxation));
    }
    const std::size_t last = std::min(phases_.hold_end, begin + of_.trace.steps(rule_.relaxation));
    const std::size_t first = last - std::min(last - begin, of_.trace.steps(rule_.end_mean));
    const auto end = finite_only(std::span<const double>(force_).subspan(first, last - first + 1));
    const double force = force_[begin];
    if (end.empty() || !std::isfinite(force) || !(force > threshold_)) {
      return refuse(
          both, end.empty() || !std::isfinite(force)
                    ? "a gap at the begin or the end of the hold"
                    : formatted("the force at the begin of the hold is below %.3g N", threshold_));
    }
    const double left = mean_of(end);
    const double independent = std::max(1.0, static_cast<double>(end.size()) * of_.independent);
    const double of_left = of_.noise / std::sqrt(independent);
    const double drop = force - left;
    features_[Feature::relaxation] = {
        .value = drop / force,
        .uncertainty = std::hypot(of_left, of_.noise * left / force) / force};
    constexpr double clear = 5.0;  // standard uncertainties
    if (!(drop > clear * std::hypot(of_.noise, of_left))) {
      features_[Feature::relaxation_time].reason = "the force does not fall in the hold";
      return;
    }
    constexpr double share = 0.63;  // of the drop: 1 - 1/e of one exponential
    const Measured reached = first_fall(of_, begin + 1, force - share * drop);
    features_[Feature::relaxation_time] =
        difference(reached, {.value = time(begin), .uncertainty = spread_over(of_.trace.step)});
  }

  void measure_withdrawal() {
    constexpr std::array both{Feature::withdrawal_force, Feature::withdrawal_depth};
    if (!phases_.withdrawn) { return refuse(both, "the needle is not withdrawn"); }
    const Extreme least = least_in(phases_.hold_end, force_.size() - 1);
    if (!std::isfinite(least.force)) { return refuse(both, "a gap hides the withdrawal"); }
    features_[Feature::withdrawal_force] = {.value = least.force, .uncertainty = of_.noise};
    std::size_t first = least.at;
    std::size_t last = least.at;
    const double level = least.force + of_.noise;
    while (first > phases_.hold_end && force_[first - 1] < level) { --first; }
    while (last + 1 < force_.size() && force_[last + 1] < level) { ++last; }
    features_[Feature::withdrawal_depth] = depth_below_contact(
        least.at, spread_over(of_.trace.step * static_cast<double>(last - first + 1)));
  }

  const Extraction& of_;
  const std::vector<double>& force_;
  const std::vector<double>& depth_;
  const InsertionRule& rule_;
  Features& features_;
  InsertionPhases& phases_ = features_.phases;
  double threshold_ = 0.0;  ///< of the contact, and of the drop after a puncture [N]
};

}  // namespace

std::span<const Feature> features_of(FeatureSet set) {
  const std::span<const Feature> all(in_order);
  return set == FeatureSet::insertion ? all.subspan(first_of_insertion)
                                      : all.first(first_of_insertion);
}

bool is_event(Feature feature) {
  return feature == Feature::loss_of_resistance || feature == Feature::puncture;
}

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
  const double passed = noise_shares(input.cutoff, 1.0 / input.raw.step).passed;
  const Extraction of{input.filtered, rule, features.noise * std::sqrt(passed), passed,
                      input.cutoff > 0.0 ? input.raw.steps(0.5 / input.cutoff) : 0};
  if (longest_stretch(input.filtered.value).size() == 0) {
    for (Measured& one : features.all) { one.reason = "no sample is a number"; }
    features.loss = find_loss(input.filtered, rule.loss);
    return features;
  }
  if (rule.set == FeatureSet::insertion) {
    InsertionMeasurement(of, input.depth, rule.insertion, features).measure();
    return features;
  }
  features.loss = find_loss(input.filtered, rule.loss);
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
