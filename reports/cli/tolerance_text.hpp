// SPDX-License-Identifier: MIT
#pragma once
/// Tolerances given on the command line.

#include <string>

#include "validation/comparison/comparison.hpp"

namespace palpate {

/// Parses a tolerance: "peak=15%", "plateau=7mmHg", "slope_before=30%+5mmHg/s", "drop_time=x2",
/// "relative_drop=0.2". The value is a fraction of the recorded value, a width with unit (SI if
/// none), their sum, or a factor. Throws InputError.
comparison::Tolerance tolerance_from(const std::string& text, comparison::QuantityKind quantity);

/// Default tolerances of all features, one per line in the same syntax: "peak=10.2%".
std::string tolerance_help(comparison::QuantityKind quantity);

}  // namespace palpate
