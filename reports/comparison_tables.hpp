// SPDX-License-Identifier: MIT
#pragma once
/// The tables of a comparison, and those that carry verdicts as markup.

#include <string>

#include "reports/comparison_report.hpp"

namespace palpate {

std::string html_badge(comparison::Verdict verdict);

/// Every feature with both values, what is allowed, the verdict and who says so.
std::string html_features(const std::vector<comparison::FeatureVerdict>& features);

/// One line per recording: what it is and how it came out.
std::string html_recordings(const ComparisonReport& report);
/// One line per group with its counts and its corridor.
std::string html_groups(const ComparisonReport& report);

/// Features over the subjects of a group: mean, SD, interval, simulated value.
Table subjects_table(const comparison::GroupSummary& group);
/// ISO 18571 with its parts, Sprague-Geers, RMSE of every recording that could be compared.
Table ratings_table(const ComparisonReport& report);
Table defects_table(const ComparisonReport& report);
Table tolerances_table(const ComparisonReport& report);
Table credibility_table(const ComparisonReport& report);

}  // namespace palpate
