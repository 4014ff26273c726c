// SPDX-License-Identifier: MIT
#pragma once
/// Regular lattice as rows of nodes along one of its axes, divided and interleaved into the lanes
/// of registers (model/EQUATIONS.md, "Lattice in lanes").

#include <cstdint>
#include <vector>

#include "model/kernels/kernel_views.hpp"
#include "model/kernels/system.hpp"
#include "model/problem/problem.hpp"

namespace palpate {

class LatticeRows {
 public:
  using Place = std::array<int, 3>;  ///< along the rows' axis, the second and the third

  /// Along the axis, and folded so often, that vectors of so many lanes are filled with the least
  /// waste. Rows that may sleep are not folded: what lies in one vector wakes together.
  LatticeRows(const LatticeShape& shape, int lanes, bool may_fold);

  [[nodiscard]] const Place& nodes() const { return nodes_; }  ///< along the three
  [[nodiscard]] int folds() const { return folds_; }  ///< rows of the lattice that make one
  [[nodiscard]] int pieces() const {
    return pieces_;
  }  ///< that each of them is cut into, a lane each
  [[nodiscard]] int vectors() const { return vectors_; }  ///< of a row
  [[nodiscard]] int rows1() const { return rows1_; }      ///< of a layer
  [[nodiscard]] std::size_t count() const { return static_cast<std::size_t>(rows1_ * nodes_[2]); }
  [[nodiscard]] Place place_of(int node) const;
  [[nodiscard]] std::size_t row_of(const Place& place) const {
    return static_cast<std::size_t>(place[2] * rows1_ + place[1] % rows1_);
  }
  [[nodiscard]] int first_lane(const Place& place) const {
    return place[1] / rows1_ * pieces_;
  }  ///< of its fold
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

// A regular lattice as its kernels see it: nodes in lanes, springs in tables of a row that equal
// rows share (model/EQUATIONS.md, "Lattice in lanes").

/// All that this processor can run, the best first.
template <class Real> std::vector<lattice::Kernels<Real>> lattice_kernels();

template <class Real> class LatticeSprings {
 public:
  /// `shape` is the lattice of the problem's network. skip = false goes through dampers and rows of
  /// fixed nodes that are not there or do nothing, to the same bits.
  LatticeSprings(const NetworkProblem& problem, const LatticeShape& shape, int lanes, bool skip,
                 bool may_fold);

  [[nodiscard]] NodeLayout layout() const;  ///< made anew
  [[nodiscard]] const LatticeRows& rows() const { return rows_; }
  [[nodiscard]] lattice::View<Real> view() const;
  /// Places of all nodes, and far from each other of what the vectors hold beside them.
  [[nodiscard]] Eigen::Matrix<Real, Eigen::Dynamic, 1> initial_position() const;
  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  [[nodiscard]] Eigen::Index element_of(const LatticeRows::Place& place) const;
  /// Equal springs of nodes that follow each other in a row, as the row sees them that they lead
  /// from.
  struct Stretch {
    std::uint32_t row = 0;
    int place = 0;  ///< of the first in the row
    int nodes = 0;
    std::uint16_t slot = 0;
    std::uint16_t first_lane = 0;  ///< of its fold
    const SpringList::Bond* bond = nullptr;
    /// In all but the row.
    [[nodiscard]] bool equals(const Stretch& other) const {
      return place == other.place && nodes == other.nodes && slot == other.slot &&
             first_lane == other.first_lane && bond->stiffness == other.bond->stiffness &&
             bond->viscosity == other.bond->viscosity;
    }
  };
  [[nodiscard]] Stretch stretch_of(int node, int nodes, const SpringList::Bond& bond) const;
  [[nodiscard]] Real length_along(int axes) const;  ///< of springs at rest [m]
  [[nodiscard]] lattice::Links<Real> links_of(int row1) const;
  void fill_tables(const NetworkProblem& problem, bool skip);
  [[nodiscard]] std::vector<Stretch> by_row(const SpringList& springs,
                                            std::vector<std::size_t>& begins) const;

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
