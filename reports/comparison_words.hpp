// SPDX-License-Identifier: MIT
#pragma once
/// A whole comparison in words; features are told in those of feature_words.hpp.

#include <string>

#include "reports/comparison_report.hpp"
#include "validation/comparison/feature_words.hpp"

namespace palpate {

/// "3 measured recordings", "5 recordings reconstructed from published summary values", or both.
std::string kinds_of(const ComparisonReport& report);
bool any_reconstructed(const ComparisonReport& report);

/// "1 differs", "4 agree, 1 cannot be compared": counts of recordings.
std::string tally_of(const ComparisonReport& report);

/// "5 subjects", "5 subjects (10 recordings)".
std::string subjects_of(const comparison::SubjectCorridor& corridor);

/// Over all groups.
std::size_t subjects_compared(const ComparisonReport& report);

/// "without a group" of an empty one.
std::string name_of_group(const std::string& group);

/// The verdict with a capital, and one sentence that says what it rests on.
std::string verdict_text(const ComparisonReport& report);
std::string verdict_sentence(const ComparisonReport& report);

/// "12 missing in 3 gaps, 2 bad frames"; "nothing" where nothing was found.
std::string shown(const RecordingDefects& defects);

}  // namespace palpate
