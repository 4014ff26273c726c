// SPDX-License-Identifier: MIT
#pragma once
/// A regular lattice as its kernels see it: nodes in lanes, springs in tables of a row that equal rows
/// share (model/EQUATIONS.md, "Lattice in lanes").

#include <cstdint>
#include <vector>

#include "model/stepping/aligned_vector.hpp"
#include "model/stepping/lattice_rows.hpp"
#include "model/stepping/lattice_view.hpp"
#include "model/stepping/node_layout.hpp"

namespace palpate {

/// All that this processor can run, the best first.
template <class Real>
std::vector<lattice::Kernels<Real>> lattice_kernels();

template <class Real>
class LatticeSprings {
 public:
  /// `shape` is lattice_of() the problem's network. skip = false goes through dampers and rows of fixed
  /// nodes that are not there or do nothing, to the same bits.
  LatticeSprings(const NetworkProblem& problem, const LatticeShape& shape, int lanes, bool skip, bool may_fold);

  [[nodiscard]] NodeLayout layout() const;  ///< made anew
  [[nodiscard]] const LatticeRows& rows() const { return rows_; }
  [[nodiscard]] lattice::View<Real> view() const;
  /// Places of all nodes, and far from each other of what the vectors hold beside them.
  [[nodiscard]] Eigen::Matrix<Real, Eigen::Dynamic, 1> initial_position() const;
  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  [[nodiscard]] Eigen::Index element_of(const LatticeRows::Place& place) const;
  /// Equal springs of nodes that follow each other in a row, as the row sees them that they lead from.
  struct Stretch {
    std::uint32_t row = 0;
    int place = 0;  ///< of the first in the row
    int nodes = 0;
    std::uint16_t slot = 0;
    std::uint16_t first_lane = 0;  ///< of its fold
    const SpringList::Bond* bond = nullptr;
    /// In all but the row.
    [[nodiscard]] bool equals(const Stretch& other) const {
      return place == other.place && nodes == other.nodes && slot == other.slot && first_lane == other.first_lane &&
             bond->stiffness == other.bond->stiffness && bond->viscosity == other.bond->viscosity;
    }
  };
  [[nodiscard]] Stretch stretch_of(int node, int nodes, const SpringList::Bond& bond) const;
  [[nodiscard]] Real length_along(int axes) const;  ///< of springs at rest [m]
  [[nodiscard]] lattice::Links<Real> links_of(int row1) const;
  void fill_tables(const NetworkProblem& problem, bool skip);
  [[nodiscard]] std::vector<Stretch> by_row(const SpringList& springs, std::vector<std::size_t>& begins) const;

  const NetworkProblem& problem_;
  double spacing_;  ///< [m]
  LatticeRows rows_;
  int lanes_;
  int vectors_;
  Eigen::Index size_;  ///< of a vector of all coordinates
  std::vector<unsigned char> row_moves_;
  bool damped_ = false;
  AlignedVector<Real> tables_{};
  std::vector<long> row_table_{};
  std::array<bool, lattice::slots> used_{};  ///< slots that some row has a spring in
};

}  // namespace palpate
