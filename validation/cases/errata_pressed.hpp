// SPDX-License-Identifier: MIT
#pragma once
/// A pressed lattice with and without an erratum, at the same scheme and step, beside ARKODE.

#include "validation/cases/errata_setting.hpp"

namespace palpate::errata {

/// Judges the corrected model, measures the printed form, adds the table and the figure.
void compare_pressed(const CaseContext& context, Outcome& outcome, const PrintedForm& printed,
                     const std::string& name);

}  // namespace palpate::errata
