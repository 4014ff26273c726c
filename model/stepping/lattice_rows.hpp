// SPDX-License-Identifier: MIT
#pragma once
/// A regular lattice as rows of nodes along one of its axes (model/EQUATIONS.md, "Lattice in lanes").

#include <vector>

#include "model/dynamics/lattice.hpp"
#include "model/dynamics/problem.hpp"

namespace palpate {

class LatticeRows {
 public:
  using Place = std::array<int, 3>;  ///< along the rows' axis, the second and the third

  /// Along the axis whose rows fill vectors of so many lanes with the least waste.
  LatticeRows(const LatticeShape& shape, int lanes);

  [[nodiscard]] const Place& nodes() const { return nodes_; }  ///< along the three
  [[nodiscard]] int vectors() const { return vectors_; }       ///< of a row
  [[nodiscard]] std::size_t count() const { return static_cast<std::size_t>(nodes_[1] * nodes_[2]); }
  [[nodiscard]] Place place_of(int node) const;
  [[nodiscard]] std::size_t row_of(const Place& place) const {
    return static_cast<std::size_t>(place[2] * nodes_[1] + place[1]);
  }
  /// Whether a row's nodes follow each other in the network.
  [[nodiscard]] bool follows_index() const { return axes_[0] == 0; }
  /// 1 for a row with a free node.
  [[nodiscard]] std::vector<unsigned char> moving(const NetworkProblem& problem) const;

 private:
  LatticeShape shape_;
  std::array<std::size_t, 3> axes_{};  ///< the lattice's axis along the rows, the second, the third
  Place nodes_{};
  int vectors_ = 0;
};

/// Springs whose two rows have no free node.
long springs_between_fixed_rows(const NetworkProblem& problem, const LatticeRows& rows);

}  // namespace palpate
