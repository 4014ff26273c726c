// SPDX-License-Identifier: MIT
#pragma once
/// A regular lattice as rows of nodes along one of its axes, cut and folded into the lanes of registers
/// (model/EQUATIONS.md, "Lattice in lanes").

#include <vector>

#include "model/dynamics/lattice.hpp"
#include "model/dynamics/problem.hpp"

namespace palpate {

class LatticeRows {
 public:
  using Place = std::array<int, 3>;  ///< along the rows' axis, the second and the third

  /// Along the axis, and folded so often, that vectors of so many lanes are filled with the least waste. Rows that may
  /// sleep are not folded: what lies in one vector wakes together.
  LatticeRows(const LatticeShape& shape, int lanes, bool may_fold);

  [[nodiscard]] const Place& nodes() const { return nodes_; }  ///< along the three
  [[nodiscard]] int folds() const { return folds_; }           ///< rows of the lattice that make one
  [[nodiscard]] int pieces() const { return pieces_; }         ///< that each of them is cut into, a lane each
  [[nodiscard]] int vectors() const { return vectors_; }       ///< of a row
  [[nodiscard]] int rows1() const { return rows1_; }           ///< of a layer
  [[nodiscard]] std::size_t count() const { return static_cast<std::size_t>(rows1_ * nodes_[2]); }
  [[nodiscard]] Place place_of(int node) const;
  [[nodiscard]] std::size_t row_of(const Place& place) const {
    return static_cast<std::size_t>(place[2] * rows1_ + place[1] % rows1_);
  }
  [[nodiscard]] int first_lane(const Place& place) const { return place[1] / rows1_ * pieces_; }  ///< of its fold
  /// Whether a row's nodes follow each other in the network.
  [[nodiscard]] bool follows_index() const { return axes_[0] == 0; }
  /// 1 for a row with a free node.
  [[nodiscard]] std::vector<unsigned char> moving(const NetworkProblem& problem) const;

 private:
  LatticeShape shape_;
  std::array<std::size_t, 3> axes_{};  ///< the lattice's axis along the rows, the second, the third
  Place nodes_{};
  int folds_ = 1;
  int pieces_ = 1;
  int vectors_ = 0;
  int rows1_ = 0;
};

/// Springs whose two rows have no free node.
long springs_between_fixed_rows(const NetworkProblem& problem, const LatticeRows& rows);

}  // namespace palpate
