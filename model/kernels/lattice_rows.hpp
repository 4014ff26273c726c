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

struct LatticeRows {
  using Place = std::array<int, 3>;  ///< index along the rows' axis, the second and the third axis

  /// Chooses the axis and the number of interleaved rows that leave the fewest lanes unused. Rows
  /// that may sleep are not interleaved, because all nodes of a vector wake together.
  LatticeRows(const LatticeShape& shape, int lanes, bool may_fold);

  [[nodiscard]] std::size_t count() const { return static_cast<std::size_t>(rows1 * nodes[2]); }
  [[nodiscard]] Place place_of(int node) const;
  [[nodiscard]] std::size_t row_of(const Place& place) const {
    return static_cast<std::size_t>(place[2] * rows1 + place[1] % rows1);
  }
  /// Returns the first lane of the fold of a place.
  [[nodiscard]] int first_lane(const Place& place) const { return place[1] / rows1 * pieces; }
  /// Returns true if the nodes of a row are consecutive in the network.
  [[nodiscard]] bool follows_index() const { return axes[0] == 0; }
  /// Returns 1 for each row with a free node.
  [[nodiscard]] std::vector<unsigned char> moving(const NetworkProblem& problem) const;

  LatticeShape shape;
  std::array<std::size_t, 3> axes{};  ///< lattice axes: of the rows, second and third
  Place nodes{};                      ///< along these axes
  int folds = 1;                      ///< lattice rows per stored row
  int pieces = 1;                     ///< segments of a lattice row, one per lane
  int vectors = 0;                    ///< per row
  int rows1 = 0;                      ///< per layer
};

/// Returns the number of springs between two rows without free nodes.
long springs_between_fixed_rows(const NetworkProblem& problem, const LatticeRows& rows);

/// Returns all kernels that this processor supports, widest first.
template <class Real> std::vector<lattice::Kernels<Real>> lattice_kernels();
template <> std::vector<lattice::Kernels<double>> lattice_kernels();
template <> std::vector<lattice::Kernels<float>> lattice_kernels();

}  // namespace palpate
