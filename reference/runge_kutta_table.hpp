// SPDX-License-Identifier: MIT
#pragma once
/// Runge-Kutta tables that ERKStep and ARKStep of SUNDIALS 6.4 integrate correctly.
///
/// Those steppers reuse the last stage's derivative as the first one of the next step whenever the
/// last stage's time is the end of the step, without asking whether its value is the new solution
/// (fixed upstream in 2023). Heun-Euler then has one evaluation per step instead of two, Verner
/// 8-5-6 drops from order 6 to 3 and Fehlberg 13-7-8 from order 8 to 7. A table is safe when its
/// last stage is not at the end of the step, or when its last row is the solution row; any other
/// is made safe by one more, unused, stage at the beginning of the step.

// The library's header uses FILE and leaves it to others to declare it first.
// clang-format off
#include <cstdio>
#include <arkode/arkode_butcher.h>
// clang-format on

#include <memory>
#include <string>

#include "reference/sundials.hpp"

namespace palpate::reference::sundials {

using Table = std::unique_ptr<ARKodeButcherTableMem, Deleter<ARKodeButcherTable_Free>>;

/// Whether reusing the last stage's derivative is either not tried or right.
bool reuses_no_stale_stage(const ARKodeButcherTableMem& table);

/// For the table that a stepper says it used: SolverError naming `solver` when it reuses a stale stage.
void refuse_stale_stage(ARKodeButcherTable used, const std::string& solver);

/// The same method, with a stage added when it is needed.
Table without_stale_stage(const ARKodeButcherTableMem& table);

Table explicit_table(int id);  ///< ARKODE_ERKTableID, made safe
Table implicit_table(int id);  ///< ARKODE_DIRKTableID; SolverError when it is not safe

}  // namespace palpate::reference::sundials
