// SPDX-License-Identifier: MIT
#pragma once
/// What springs of a network add to its matrices of stiffness and damping at the initial positions, spring by spring.

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "model/dynamics/problem.hpp"

namespace palpate::spring_blocks {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double roundings = 1e-12;  ///< of sums and eigenvalues, as a share

enum class Which { stiffness, stretched_stiffness, damping };

/// k u u^T with the geometric stiffness, of all springs or of stretched ones only (which leaves nothing negative and
/// can only raise the frequencies); or c u u^T. Nothing for a spring without length.
std::optional<Matrix3d> block_of(const SpringList::Bond& bond, const Vector3d& d, Which which);

/// Blocks of the bonds that a run of nodes shares: computed anew only where a spring differs from that of the node
/// before by more than rounding.
class RunBlocks {
 public:
  RunBlocks(std::span<const SpringList::Bond> bonds, Which which)
      : bonds_(bonds), which_(which), known_(bonds.size()) {}
  /// Null for a spring without length.
  const Matrix3d* at(std::size_t bond, const Vector3d& d) {
    Known& known = known_[bond];
    const double near = 0.1 * roundings * known.d.cwiseAbs().maxCoeff();
    if (!known.asked || !((d - known.d).cwiseAbs().maxCoeff() <= near)) {
      known = {d, block_of(bonds_[bond], d, which_), true};
    }
    return known.block ? &*known.block : nullptr;
  }

 private:
  struct Known {
    Vector3d d = Vector3d::Zero();
    std::optional<Matrix3d> block{};
    bool asked = false;
  };
  std::span<const SpringList::Bond> bonds_;
  Which which_;
  std::vector<Known> known_;
};

/// Nodes by their index.
struct NodeRange {
  int first = 0;
  int last = std::numeric_limits<int>::max();
  /// Whether a run may have a spring with an end in it.
  [[nodiscard]] bool meets(const SpringList::Run& run, std::span<const SpringList::Bond> bonds) const {
    const auto [least, most] = std::ranges::minmax(bonds, {}, &SpringList::Bond::to);
    const int run_last = run.first_node + run.nodes - 1;
    return run.first_node + std::min(0, least.to) <= last && run_last + std::max(0, most.to) >= first;
  }
};

/// visit(a, b, matrix) for springs with an end at a coordinate that `wanted` allows, in `range`.
template <class Wanted, class Visit>
void visit_blocks(const NetworkProblem& problem, Which which, const NodeRange& range, Wanted wanted, Visit visit) {
  const SpringNetwork& network = problem.network();
  const NodeVectors& place = problem.held_position();
  for (const SpringList::Run& run : network.springs.runs()) {
    const auto bonds = network.springs.bonds(run);
    if (!range.meets(run, bonds)) { continue; }
    RunBlocks blocks(bonds, which);
    for (int node = run.first_node; node < run.first_node + run.nodes; ++node) {
      const Eigen::Index a = problem.coordinate(node);
      for (std::size_t n = 0; n < bonds.size(); ++n) {
        const int other = node + bonds[n].to;
        const Eigen::Index b = problem.coordinate(other);
        if (!(a >= 0 && wanted(a)) && !(b >= 0 && wanted(b))) { continue; }
        if (which == Which::damping && !(bonds[n].viscosity > 0.0)) { continue; }
        const Matrix3d* matrix = blocks.at(n, place.col(other) - place.col(node));
        if (matrix != nullptr) { visit(a, b, *matrix); }
      }
    }
  }
}

}  // namespace palpate::spring_blocks
