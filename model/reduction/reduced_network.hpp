// SPDX-License-Identifier: MIT
#pragma once
/// Reduced-order model of the tissue far from a tool, linear about the rest state
/// (model/EQUATIONS.md, "Far field").

#include <memory>

#include "model/kernels/network_system.hpp"
#include "model/reduction/mode_basis.hpp"

namespace palpate {

/// Builds a network with the near nodes of a lattice as a list of springs and a reduced-order model
/// of the far nodes. The coordinates of the near nodes come first, then the modal coordinates. The
/// lattice must be at rest at its natural lengths, without weight, and loaded at near nodes only.
template <class Real>
std::unique_ptr<NetworkSystem<Real>> make_reduced_network(const NetworkProblem& problem,
                                                          const ReductionSetting& setting);

}  // namespace palpate
