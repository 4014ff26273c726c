// SPDX-License-Identifier: MIT
#pragma once
/// A pressed lattice with and without an erratum, at the same scheme and step, beside ARKODE.

#include "validation/cases/errata_setting.hpp"

namespace palpate::errata {

struct Compared {
  double corrected_error = 0.0;  ///< of the corrected model, over the peak [1]
  double printed_error = 0.0;    ///< of the printed form; infinite when it diverged
  double wrong_at = 0.0;         ///< [s] when the printed form is off by the whole peak; infinite: never
};

/// Judges the corrected model, measures the printed form, adds the table and the figure.
Compared compare_pressed(const CaseContext& context, Outcome& outcome, const PrintedForm& printed,
                         const std::string& name);

}  // namespace palpate::errata
