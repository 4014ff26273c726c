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
  [[nodiscard]] int pieces() const {
    return pieces_;
  }  ///< segments of each lattice row, one per lane
  [[nodiscard]] int vectors() const { return vectors_; }  ///< per row
  [[nodiscard]] int rows1() const { return rows1_; }      ///< per layer
  [[nodiscard]] std::size_t count() const { return static_cast<std::size_t>(rows1_ * nodes_[2]); }
  [[nodiscard]] Place place_of(int node) const;
  [[nodiscard]] std::size_t row_of(const Place& place) const {
    return static_cast<std::size_t>(place[2] * rows1_ + place[1] % rows1_);
  }
  [[nodiscard]] int first_lane(const Place& place) const {
    return place[1] / rows1_ * pieces_;
  }  ///< of its fold
  /// Returns true if the nodes of a row are consecutive in the network.
  [[nodiscard]] bool follows_index() const { return axes_[0] == 0; }
  /// Returns 1 for each row with a free node.
  [[nodiscard]] std::vector<unsigned char> moving(const NetworkProblem& problem) const;

 private:
  LatticeShape shape_;
  std::array<std::size_t, 3>
      axes_{};  ///< lattice axis of the rows, of the second and of the third direction
  Place nodes_{};
  int folds_ = 1;
  int pieces_ = 1;
  int vectors_ = 0;
  int rows1_ = 0;
};

/// Returns the number of springs between two rows without free nodes.
long springs_between_fixed_rows(const NetworkProblem& problem, const LatticeRows& rows);

// Kernel data of a regular lattice: nodes in SIMD lanes, and tables of spring constants that equal
// rows share (model/EQUATIONS.md, "Lattice in lanes").

/// Returns all kernels that this processor supports, widest first.
template <class Real> std::vector<lattice::Kernels<Real>> lattice_kernels();

template <class Real> class LatticeSprings {
 public:
  /// Builds the tables. `shape` is the lattice of the problem's network. With skip = false, absent
  /// dampers and rows of fixed nodes are computed too; results are bitwise identical.
  LatticeSprings(const NetworkProblem& problem, const LatticeShape& shape, int lanes, bool skip,
                 bool may_fold);

  [[nodiscard]] NodeLayout layout() const;  ///< newly built by each call
  [[nodiscard]] const LatticeRows& rows() const { return rows_; }
  [[nodiscard]] lattice::View<Real> view() const;
  /// Returns the initial position of all nodes. Padding elements get positions far from each other.
  [[nodiscard]] Eigen::Matrix<Real, Eigen::Dynamic, 1> initial_position() const;
  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  [[nodiscard]] Eigen::Index element_of(const LatticeRows::Place& place) const;
  /// Equal springs of consecutive nodes in a row, stored with the row that computes them.
  struct Stretch {
    std::uint32_t row = 0;
    int place = 0;  ///< position of the first node in the row
    int nodes = 0;
    std::uint16_t slot = 0;
    std::uint16_t first_lane = 0;  ///< first lane of its lattice row
    const SpringList::Bond* bond = nullptr;
    /// Returns true if all members except the row are equal.
    [[nodiscard]] bool equals(const Stretch& other) const {
      return place == other.place && nodes == other.nodes && slot == other.slot &&
             first_lane == other.first_lane && bond->stiffness == other.bond->stiffness &&
             bond->viscosity == other.bond->viscosity;
    }
  };
  [[nodiscard]] Stretch stretch_of(int node, int nodes, const SpringList::Bond& bond) const;
  [[nodiscard]] Real length_along(int axes) const;  ///< rest length of the springs [m]
  [[nodiscard]] lattice::Links<Real> links_of(int row1) const;
  void fill_tables(const NetworkProblem& problem, bool skip);
  [[nodiscard]] std::vector<Stretch> by_row(const SpringList& springs,
                                            std::vector<std::size_t>& begins) const;

  const NetworkProblem& problem_;
  double spacing_;  ///< [m]
  LatticeRows rows_;
  int lanes_;
  int vectors_;
  Eigen::Index size_;  ///< length of a vector of all coordinates
  std::vector<unsigned char> row_moves_;
  bool damped_ = false;
  AlignedVector<Real> tables_{};
  std::vector<long> row_table_{};
  std::array<bool, lattice::slots> used_{};  ///< slots with a spring in at least one row
};

}  // namespace palpate
