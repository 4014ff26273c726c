// SPDX-License-Identifier: MIT
#pragma once
/// E = S - D of every feature against its tolerance and its validation uncertainty.

#include <string>
#include <vector>

#include "validation/comparison/comparison.hpp"

namespace palpate::comparison {

/// From the features and the alignment of a comparison.
std::vector<FeatureVerdict> judge_features(const Comparison& comparison, const ComparisonOptions& options);

/// "drop_time: 0.31 s simulated, 0.1 s recorded, 0.05 to 0.2 s allowed, +-0.01 s: differs"
std::string sentence_of(const FeatureVerdict& verdict);

/// u_D of one recorded feature: its noise and sampling, and the transducer's zero and gain.
double data_uncertainty(Feature feature, const Features& recorded, const ComparisonOptions& options);

}  // namespace palpate::comparison
