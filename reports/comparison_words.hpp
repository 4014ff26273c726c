// SPDX-License-Identifier: MIT
#pragma once
/// A comparison in words and in the units of clinicians.

#include <string>

#include "reports/comparison_report.hpp"

namespace palpate {

/// "loss of resistance" of "loss_of_resistance".
std::string in_words(comparison::Feature feature);

/// A feature's value [SI] with its unit as clinicians read it; "found" or "not found" of the event, "-" of
/// NaN.
std::string shown(comparison::Feature feature, double value, std::string_view unit);
/// "300 to 367 mmHg".
std::string shown_interval(comparison::Feature feature, const comparison::Interval& interval,
                           std::string_view unit);
/// U with its sign and unit; empty of 0.
std::string shown_uncertainty(const comparison::FeatureVerdict& verdict);
/// What a tolerance allows, as "10.2 %", "7 mmHg", "a factor of 2".
std::string shown(const comparison::Tolerance& tolerance, std::string_view unit);

/// "3 measured recordings", "5 recordings reconstructed from published summary values", or both.
std::string kinds_of(const ComparisonReport& report);
bool any_reconstructed(const ComparisonReport& report);

/// "1 differs", "4 agree, 1 cannot be compared": counts of recordings.
std::string tally_of(const ComparisonReport& report);

/// The verdict with a capital, and one sentence that says what it rests on.
std::string verdict_text(const ComparisonReport& report);
std::string verdict_sentence(const ComparisonReport& report);

/// "12 missing in 3 gaps, 2 bad frames"; "nothing" where nothing was found.
std::string shown(const RecordingDefects& defects);

}  // namespace palpate
