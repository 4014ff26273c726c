// SPDX-License-Identifier: MIT
#pragma once
/// report.html of a set of cases: verdict, table of claims with the worst margin first, then every
/// case with its numbers and figures, then provenance.

#include <string>

#include "reports/results.hpp"

namespace palpate {

/// Same results, same bytes. Throws DrawingError.
std::string to_html(const Results& results);

}  // namespace palpate
