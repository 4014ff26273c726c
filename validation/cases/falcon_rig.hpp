// SPDX-License-Identifier: MIT
#pragma once
/// Scenes that a hand feels through the emulated Falcon, and their runs.

#include "validation/case.hpp"
#include "validation/falcon_loop.hpp"
#include "validation/rollout.hpp"

namespace palpate::haptics {

struct Held {
  Run run{};
  FalconFacts facts{};
};

Held hold(const CaseContext& context, Scene scene);

/// A chain that nothing cuts, so that the tip stays on its first node.
Scene chain_in_hand(bool quick, double stiffness);

}  // namespace palpate::haptics
