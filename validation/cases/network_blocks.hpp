// SPDX-License-Identifier: MIT
#pragma once
/// A block of tissue whose motion is compared with a reference: what it is, and what is measured.

#include <string>

#include "validation/cases/network_support.hpp"

namespace palpate::networks {

struct BlockStudy {
  Scene scene{};  ///< loads, tick and duration; scheme and substeps are set per run
  SpringNetwork network{};
  LatticeShape shape{};
  int probe = 0;  ///< node that is drawn
  TruthSettings settings{};
  int implicit_rungs = 2;     ///< of one tick and halves of it; 0: none
  int implicit_substeps = 1;  ///< of the first
  std::string what{};         ///< "the cube", in captions
};

/// The problem of tables 2.3 of other programs: 10 x 10 x 10 nodes, 26 neighbours (paper, Fig. 13).
BlockStudy cube_study(bool quick);
/// Skin to dura, soft enough for explicit steps (paper, Fig. 14).
BlockStudy seven_layer_study(bool quick);
/// Every spring and every node of its own (paper, Fig. 15).
BlockStudy heterogeneous_study(bool quick);

/// References, every scheme at its steps, table and figures. The truth is handed back.
Truth judge_block(const CaseContext& context, const BlockStudy& study, Outcome& outcome);

}  // namespace palpate::networks
