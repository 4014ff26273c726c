// SPDX-License-Identifier: MIT
#pragma once
/// The errata one by one; each adds what it judges, tables and figures, and gives its line of the
/// summary.

#include "validation/cases/errata_setting.hpp"

namespace palpate::errata {

Finding measure_sign(const CaseContext& context, Outcome& outcome);
Finding measure_reversed(const CaseContext& context, Outcome& outcome);
Finding measure_no_time_step(const CaseContext& context, Outcome& outcome);
Finding measure_all_printed(const CaseContext& context, Outcome& outcome);
Finding measure_direction(const CaseContext& context, Outcome& outcome);
Finding measure_half_force(const CaseContext& context, Outcome& outcome);
Finding measure_lagged_velocity(const CaseContext& context, Outcome& outcome);

}  // namespace palpate::errata
