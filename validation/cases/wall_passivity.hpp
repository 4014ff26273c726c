// SPDX-License-Identifier: MIT
#pragma once
/// What a virtual wall feeds in, frequency by frequency.

#include "validation/case.hpp"

namespace palpate::haptics {

/// The damping that takes it, measured over whole cycles, against the first harmonic of the held force and the condition
/// of Colgate and Schenkel.
void measure_wall_passivity(const CaseContext& context, Outcome& outcome);

}  // namespace palpate::haptics
