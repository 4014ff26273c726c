// SPDX-License-Identifier: MIT
#include "validation/comparison/features.hpp"

#include <algorithm>
#include <cmath>

#include "validation/comparison/zero_phase.hpp"

namespace palpate::comparison {

namespace {

/// Standard uncertainty of an instant or value that may lie anywhere in a width.
double spread_over(double width) { return width / std::sqrt(12.0); }

struct Extraction {
  const Samples& trace;
  const FeatureRule& rule;
  double noise = 0.0;        ///< of one filtered sample
  double independent = 1.0;  ///< share of filtered samples that are independent of their neighbours
  std::size_t reach = 0;     ///< samples over which the filter ties neighbours together
};

/// Between samples n - reach and n + 1 + reach: between neighbours alone, noise would make a slope of its
/// own.
double slope_about(const Extraction& of, std::size_t n) {
  const std::size_t first = n > of.reach ? n - of.reach : 0;
  const std::size_t last = std::min(n + 1 + of.reach, of.trace.size() - 1);
  const double wide =
      (of.trace.value[last] - of.trace.value[first]) / (of.trace.step * static_cast<double>(last - first));
  const double narrow = (of.trace.value[n + 1] - of.trace.value[n]) / of.trace.step;
  return std::isfinite(wide) ? wide : narrow;
}

void absent(Features& features, std::initializer_list<Feature> which, const std::string& reason) {
  for (const Feature feature : which) { features[feature] = {.reason = reason}; }
}

/// Where the trace passes a level between samples n and n + 1 [s].
Measured crossing(const Extraction& of, std::size_t n, double level) {
  const double low = of.trace.value[n];
  const double high = of.trace.value[n + 1];
  if (!std::isfinite(low) || !std::isfinite(high)) { return {.reason = "a gap hides the fall"}; }
  return {.value = of.trace.time(n) + of.trace.step * (level - low) / (high - low),
          .uncertainty = std::hypot(of.noise / slope_about(of, n), spread_over(of.trace.step))};
}

/// The last fall through a level at or before sample n.
Measured last_fall(const Extraction& of, std::size_t n, double level) {
  for (std::size_t m = n; m > 0; --m) {
    if (of.trace.value[m - 1] >= level) { return crossing(of, m - 1, level); }
    if (std::isnan(of.trace.value[m - 1])) { break; }
  }
  return {.reason = "a gap hides the fall"};
}

/// The first fall through a level after sample n.
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

/// The time of a maximum is as uncertain as the stretch over which the trace stays within its noise of it.
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
  const double of_plateau = std::sqrt(1.5708) * of.noise / std::sqrt(samples);  // a median's: sqrt(pi/2)
  features[Feature::plateau] = {.value = loss.plateau, .uncertainty = of_plateau};
  features[Feature::drop_height] = {.value = height, .uncertainty = std::hypot(of.noise, of_plateau)};
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

}  // namespace

std::string_view name_of(Feature feature) {
  constexpr std::array<std::string_view, feature_count> names{
      "loss_of_resistance", "peak",         "drop_height",  "relative_drop", "drop_time",    "plateau",
      "slope_before",       "time_of_peak", "time_of_loss", "depth_of_peak", "depth_of_loss"};
  return names[static_cast<std::size_t>(feature)];
}

std::string unit_of(Feature feature, std::string_view quantity) {
  switch (feature) {
    case Feature::loss_of_resistance:
    case Feature::relative_drop: return "1";
    case Feature::drop_time:
    case Feature::time_of_peak:
    case Feature::time_of_loss: return "s";
    case Feature::depth_of_peak:
    case Feature::depth_of_loss: return "m";
    case Feature::slope_before: return std::string(quantity) + "/s";
    case Feature::peak:
    case Feature::drop_height:
    case Feature::plateau: break;
  }
  return std::string(quantity);
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
  measure_peak(of, fell ? features.loss.peak_index : index_of_largest(input.filtered.value), features);
  if (fell) {
    measure_drop(of, features);
  } else {
    absent(features,
           {Feature::drop_height, Feature::relative_drop, Feature::drop_time, Feature::plateau,
            Feature::time_of_loss},
           "no loss of resistance: " + features.loss.reason);
  }
  if (features.loss.status == LossOfResistance::Status::undecided) {
    features[Feature::loss_of_resistance].reason = features.loss.reason;
  } else {
    features[Feature::loss_of_resistance].value = features.loss.found() ? 1.0 : 0.0;
  }
  features[Feature::depth_of_peak] = depth_at(input.depth, features[Feature::time_of_peak]);
  features[Feature::depth_of_loss] = depth_at(input.depth, features[Feature::time_of_loss]);
  return features;
}

}  // namespace palpate::comparison
