// SPDX-License-Identifier: MIT
#pragma once
/// Features in words and in the units of clinicians: mmHg, mm and percent.

#include <string>
#include <string_view>

#include "validation/comparison/comparison.hpp"
#include "validation/comparison/statistics.hpp"

namespace palpate::comparison {

/// "loss of resistance" of "loss_of_resistance".
std::string in_words(Feature feature);

/// A feature's value [SI] with its unit as clinicians read it, to a ten-thousandth of that unit at best;
/// "found" or "not found" of the event, "-" of NaN.
std::string shown(Feature feature, double value, std::string_view unit);
/// "300 to 367 mmHg".
std::string shown_interval(Feature feature, const Interval& interval, std::string_view unit);
/// U with its sign and unit; empty of 0.
std::string shown_uncertainty(const FeatureVerdict& verdict);
/// What a tolerance allows, as "10.2 %", "7 mmHg", "a factor of 2".
std::string shown(const Tolerance& tolerance, std::string_view unit);

/// "peak: 398 mmHg simulated, 461 mmHg recorded; 414 to 508 mmHg allowed, known to ±9.3 mmHg: differs"
std::string sentence_of(const FeatureVerdict& verdict);

}  // namespace palpate::comparison
