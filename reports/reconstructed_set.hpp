// SPDX-License-Identifier: MIT
#pragma once
/// Recordings that are reconstructed from published summary values. No public measurements exist.

#include <vector>

#include "fixtures/io/published_values.hpp"
#include "model/problem/recording.hpp"

namespace palpate {

/// Returns the reconstructed recordings. Each group has five subjects per technique:
/// - P01-P04: women in labour, grouped by BMI, thumb on the plunger. Mean and SD of the peaks equal
///   the table exactly; BMI affects depth only through the fat layer.
/// - P05, P06: porcine specimens, thumb. Peaks are spaced evenly over the published range; there is
///   no depth.
/// - P07-P09: five continuous recordings with a pump, a different regime without depth.
/// Output is deterministic up to rounding in the last digit.
std::vector<Recording> reconstructed_recordings(const io::PublishedValues& table);

}  // namespace palpate
