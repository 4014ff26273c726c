// SPDX-License-Identifier: MIT
#pragma once
/// The page of validation results.

#include <string>
#include <vector>

#include "reports/html/html_page.hpp"
#include "reports/results/results.hpp"
#include "validation/outcome.hpp"

namespace palpate {

/// Share of the bound that a quantity uses, its uncertainty included: at most 1 exactly when it
/// holds. For an interval, the distance from its middle over half its width. Infinite for NaN.
double share_of_bound(const Quantity& quantity);

/// True for counts and yes-or-no values that equal their bound. Their share of 1 is not a narrow
/// margin.
bool met_exactly(const Quantity& quantity);

/// The judged quantity furthest beyond its bound, else nearest to it; what is met exactly comes
/// last. nullptr when none is judged.
const Quantity* tightest_quantity(const Outcome& outcome);

/// For people: "≤ 0.002 m", "0.85 to 1.15", "= 0", "finite".
std::string allowed_text(const Quantity& quantity);
std::string measured_text(const Quantity& quantity);
/// "62 %", "3.2 times", "exact".
std::string share_text(const Quantity& quantity);

// One case in full: claim, quantities, figures, tables, notes, cost.

/// Id of the section of a case: "case-oscillator-order-rk4".
std::string case_anchor(const std::string& case_name);

/// Table of all quantities with bounds and verdicts.
std::string html_quantities(const Outcome& outcome);

Section case_section(const Outcome& outcome);

// report.html of a set of cases: verdict, table of claims with the worst margin first, then every
// case with its numbers and figures, then provenance.

/// Same results, same bytes.
std::string to_html(const Results& results);

}  // namespace palpate
