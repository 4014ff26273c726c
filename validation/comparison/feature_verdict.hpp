// SPDX-License-Identifier: MIT
#pragma once
/// E = S - D of every feature against its tolerance and its validation uncertainty.

#include <vector>

#include "validation/comparison/comparison.hpp"

namespace palpate::comparison {

/// From the features and the alignment of a comparison.
std::vector<FeatureVerdict> judge_features(const Comparison& comparison, const ComparisonOptions& options);

/// The one given for the feature, else its default.
Tolerance tolerance_of(Feature feature, const ComparisonOptions& options);

/// u_D of one recorded feature: its noise and sampling, and the transducer's zero and gain.
double data_uncertainty(Feature feature, const Features& recorded, const ComparisonOptions& options);

}  // namespace palpate::comparison
