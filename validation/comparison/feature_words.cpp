// SPDX-License-Identifier: MIT
#include "validation/comparison/feature_words.hpp"

#include <algorithm>
#include <cmath>

#include "validation/comparison/field_unit.hpp"
#include "validation/number_words.hpp"

namespace palpate::comparison {

namespace {

/// Drops are shares of the peak.
FieldUnit unit_for(Feature feature, std::string_view unit) {
  return feature == Feature::relative_drop ? FieldUnit{100.0, "%"} : field_unit(unit);
}

/// Nobody reads less than a ten-thousandth of these units; rounding would be shown as 10^-14 mmHg.
double in_unit(double value, const FieldUnit& unit) {
  return std::round(1e4 * unit.factor * value) / 1e4 + 0.0;  // no negative zero
}

std::string found_or_not(const Measured& measured) {
  return *measured.value > 0.5 ? "found" : "not found";
}

}  // namespace

std::string in_words(Feature feature) {
  std::string words(name_of(feature));
  std::ranges::replace(words, '_', ' ');
  return words;
}

std::string shown(Feature feature, double value, std::string_view unit) {
  if (std::isnan(value)) { return "-"; }
  if (feature == Feature::loss_of_resistance) { return value > 0.5 ? "found" : "not found"; }
  const FieldUnit field = unit_for(feature, unit);
  return quantity(in_unit(value, field), field.name);
}

std::string shown_interval(Feature feature, const Interval& interval, std::string_view unit) {
  const FieldUnit field = unit_for(feature, unit);
  return short_number(in_unit(interval.lower, field)) + " to " +
         quantity(in_unit(interval.upper, field), field.name);
}

std::string shown_uncertainty(const FeatureVerdict& verdict) {
  if (!(verdict.expanded > 0.0) || verdict.feature == Feature::loss_of_resistance) { return {}; }
  const FieldUnit field = unit_for(verdict.feature, verdict.unit);
  return "±" + short_number(field.factor * verdict.expanded, 2) + "\u00a0" + field.name;
}

std::string shown(const Tolerance& tolerance, std::string_view unit) {
  if (tolerance.factor > 1.0) { return "a factor of " + short_number(tolerance.factor); }
  std::string text;
  if (tolerance.relative > 0.0) { text = short_number(100.0 * tolerance.relative, 3) + "\u00a0%"; }
  if (tolerance.absolute > 0.0) {
    text += (text.empty() ? "" : " and ") + shown(tolerance.feature, tolerance.absolute, unit);
  }
  return text.empty() ? "the same" : text;
}

std::string sentence_of(const FeatureVerdict& one) {
  const std::string name = in_words(one.feature) + ": ";
  const std::string verdict = ": " + std::string(name_of(one.verdict));
  if (!one.reason.empty()) { return name + one.reason + verdict; }
  if (one.feature == Feature::loss_of_resistance) {
    return name + found_or_not(one.simulated) + " in the simulated trace, " + found_or_not(one.recorded) +
           " in the recorded one" + verdict;
  }
  const std::string known = shown_uncertainty(one);
  return name + shown(one.feature, *one.simulated.value, one.unit) + " simulated, " +
         shown(one.feature, *one.recorded.value, one.unit) + " recorded; " +
         shown_interval(one.feature, {one.lower, one.upper}, one.unit) + " allowed" +
         (known.empty() ? "" : ", known to " + known) + verdict;
}

}  // namespace palpate::comparison
