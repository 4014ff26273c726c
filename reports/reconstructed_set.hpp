// SPDX-License-Identifier: MIT
#pragma once
/// The recordings that are rebuilt from published summary values: no measurement of them is public.

#include <vector>

#include "fixtures/io/published_values.hpp"
#include "model/problem/recording.hpp"

namespace palpate {

/// Five subjects a group, each with either technique:
/// - four groups of women in labour by BMI (P01-P04), a thumb on the plunger, mean and SD of whose
///   peaks are exactly those of the table; depth by BMI through the fat alone;
/// - porcine specimens (P05, P06), a thumb, peaks evenly over the published range, no depth;
/// and five continuous ones under the pump of P07-P09, which is another regime and has no depth.
/// The same table gives the same recordings on every machine, but for the last digit of rounding.
std::vector<Recording> reconstructed_recordings(const io::PublishedValues& table);

}  // namespace palpate
