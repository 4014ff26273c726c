// SPDX-License-Identifier: MIT
#pragma once
/// report.html of a set of cases: verdict, table of claims with the worst margin first, then every
/// case with its numbers and figures, then provenance.

#include <string>

#include "reports/results.hpp"

namespace palpate {

/// Same results, same bytes. Throws DrawingError.
std::string to_html(const Results& results);

/// The quantity of an outcome that is nearest to, or furthest beyond, its bound; nullptr when none
/// is judged.
const Quantity* tightest_quantity(const Outcome& outcome);

/// How much of the room between target and bound a quantity uses: below 1 it holds. NaN counts as
/// infinitely far out.
double share_of_bound(const Quantity& quantity);

}  // namespace palpate
