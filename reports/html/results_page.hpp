// SPDX-License-Identifier: MIT
#pragma once
/// HTML page of validation results.

#include <string>

#include "reports/html/html_page.hpp"
#include "reports/results/results.hpp"
#include "validation/outcome.hpp"

namespace palpate {

/// Fraction of the bound that a quantity uses, including its uncertainty: at most 1 exactly if the
/// quantity passes. For an interval, the distance from its midpoint over half its width. Infinite
/// for NaN.
double share_of_bound(const Quantity& quantity);

/// Returns the judged quantity with the largest violation of its bound, else the one closest to its
/// bound; quantities that are met exactly come last. Returns nullptr if none is judged.
const Quantity* tightest_quantity(const Outcome& outcome);

/// Bound and measured value as displayed text: "≤ 0.002 m", "0.85 to 1.15", "= 0", "finite".
std::string allowed_text(const Quantity& quantity);
std::string measured_text(const Quantity& quantity);
// Page of a set of cases: verdict, table of claims with the worst margin first, every case with its
// numbers and figures, provenance.

/// Returns report.html. Output is deterministic: the same results give the same bytes.
std::string to_html(const Results& results);

}  // namespace palpate
