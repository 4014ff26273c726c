// SPDX-License-Identifier: MIT
#pragma once
/// Regular lattice as rows of nodes along one of its axes, divided and interleaved into SIMD lanes
/// (model/EQUATIONS.md, "Lattice in lanes").

#include <cstdint>
#include <vector>

#include "model/kernels/kernel_views.hpp"
#include "model/kernels/system.hpp"
#include "model/problem/problem.hpp"

namespace palpate {

class LatticeRows {
 public:
  using Place = std::array<int, 3>;  ///< index along the rows' axis, the second and the third axis

  /// Chooses the axis and the number of interleaved rows that leave the fewest lanes unused. Rows
  /// that may sleep are not interleaved, because all nodes of a vector wake together.
  LatticeRows(const LatticeShape& shape, int lanes, bool may_fold);

  [[nodiscard]] const Place& nodes() const { return nodes_; }  ///< along the three axes
  [[nodiscard]] int folds() const { return folds_; }           ///< lattice rows per stored row
  [[nodiscard]] int pieces() const { return pieces_; }  ///< segments of a lattice row, one per lane
  [[nodiscard]] int vectors() const { return vectors_; }  ///< per row
  [[nodiscard]] int rows1() const { return rows1_; }      ///< per layer
  [[nodiscard]] std::size_t count() const { return static_cast<std::size_t>(rows1_ * nodes_[2]); }
  [[nodiscard]] Place place_of(int node) const;
  [[nodiscard]] std::size_t row_of(const Place& place) const {
    return static_cast<std::size_t>(place[2] * rows1_ + place[1] % rows1_);
  }
  /// Returns the first lane of the fold of a place.
  [[nodiscard]] int first_lane(const Place& place) const { return place[1] / rows1_ * pieces_; }
  /// Returns true if the nodes of a row are consecutive in the network.
  [[nodiscard]] bool follows_index() const { return axes_[0] == 0; }
  /// Returns 1 for each row with a free node.
  [[nodiscard]] std::vector<unsigned char> moving(const NetworkProblem& problem) const;

 private:
  LatticeShape shape_;
  std::array<std::size_t, 3> axes_{};  ///< lattice axes: of the rows, second and third
  Place nodes_{};
  int folds_ = 1;
  int pieces_ = 1;
  int vectors_ = 0;
  int rows1_ = 0;
};

/// Returns the number of springs between two rows without free nodes.
long springs_between_fixed_rows(const NetworkProblem& problem, const LatticeRows& rows);

/// Returns all kernels that this processor supports, widest first.
template <class Real> std::vector<lattice::Kernels<Real>> lattice_kernels();

}  // namespace palpate
