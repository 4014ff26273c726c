// SPDX-License-Identifier: MIT
#pragma once
/// comparison.json (docs/formats.md).

#include <string>

#include "reports/comparison_report.hpp"

namespace palpate {

std::string to_json(const ComparisonReport& report);

}  // namespace palpate
