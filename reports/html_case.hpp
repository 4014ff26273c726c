// SPDX-License-Identifier: MIT
#pragma once
/// One case in full: claim, quantities, figures, tables, notes, cost.

#include <string>
#include <vector>

#include "validation/outcome.hpp"

namespace palpate {

/// Where the section of a case is: "case-oscillator-order-rk4".
std::string case_anchor(const std::string& case_name);

/// Every quantity with its bound and verdict.
std::string html_quantities(const Outcome& outcome);

/// `drawings` are the SVGs of the case's figures, in order.
std::string html_case(const Outcome& outcome, const std::vector<std::string>& drawings);

}  // namespace palpate
