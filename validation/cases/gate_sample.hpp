// SPDX-License-Identifier: MIT
#pragma once
/// A small block whose results the cases of group "gate" accept once and then damage.

#include <cstdint>

#include "validation/cases/network_support.hpp"
#include "validation/gate/baseline.hpp"

namespace palpate::gating {

/// A damped block, held below, pushed at one node for half a sine.
struct Study {
  Scene scene{};
  SpringNetwork network{};
  int probe = 0;                 ///< node that is pushed and watched
  reference::Solution truth{};   ///< by CVODE
};
/// `loaded`: false leaves the push out of the truth.
Study block_study(bool loaded = true);

/// What a run of it gives: its error against the truth, energies, the path of the node, and all nodes at six
/// instants.
Outcome outcome_of(const CaseContext& context, const Study& study);

/// With the sums of every network in another order.
CaseContext in_order(CaseContext context, std::uint64_t seed);

/// The outcome accepted, with the spread of runs in other orders.
gate::Baseline accepted(const CaseContext& context, const Study& study);

}  // namespace palpate::gating
