// SPDX-License-Identifier: MIT
#pragma once
/// Tolerances on a command line.

#include <string>

#include "validation/comparison/comparison.hpp"

namespace palpate {

/// "peak=15%", "plateau=7mmHg", "slope_before=30%+5mmHg/s", "drop_time=x2", "relative_drop=0.2": a
/// share of the recorded value, a width with its unit (SI without one), their sum, or a factor.
/// Throws InputError.
comparison::Tolerance tolerance_from(const std::string& text, comparison::QuantityKind quantity);

/// Default tolerances of every feature, one per line in the same syntax: "peak=10.2%".
std::string tolerance_help(comparison::QuantityKind quantity);

}  // namespace palpate
