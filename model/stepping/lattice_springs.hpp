// SPDX-License-Identifier: MIT
#pragma once
/// A regular lattice as its kernels see it: nodes in lanes, springs in tables of a row that equal rows
/// share (model/EQUATIONS.md, "Lattice in lanes").

#include <cstdint>
#include <vector>

#include "model/stepping/lattice_rows.hpp"
#include "model/stepping/lattice_view.hpp"
#include "model/stepping/node_layout.hpp"

namespace palpate {

/// The best kernels that this processor can run.
template <class Real>
lattice::Kernels<Real> lattice_kernels() noexcept;

template <class Real>
class LatticeSprings {
 public:
  /// `shape` is lattice_of() the problem's network. skip = false goes through dampers and rows of fixed
  /// nodes that are not there or do nothing, to the same bits.
  LatticeSprings(const NetworkProblem& problem, const LatticeShape& shape, int lanes, bool skip);

  [[nodiscard]] const NodeLayout& layout() const { return layout_; }
  [[nodiscard]] const LatticeRows& rows() const { return rows_; }
  [[nodiscard]] lattice::View<Real> view() const;
  /// Places of all nodes, and far from each other of what the vectors hold beside them.
  [[nodiscard]] Eigen::Matrix<Real, Eigen::Dynamic, 1> initial_position() const;
  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  [[nodiscard]] Eigen::Index element_of(const LatticeRows::Place& place) const;
  void lay_out(const NetworkProblem& problem, bool skip);
  /// A spring as the row sees it that it leads from.
  struct Bond {
    LatticeRows::Place from;
    std::size_t slot;
  };
  [[nodiscard]] Bond bond_of(const Spring& spring) const;
  void fill_tables(const NetworkProblem& problem, bool skip);
  [[nodiscard]] std::vector<std::uint32_t> by_row(const std::vector<Spring>& springs,
                                                  std::vector<std::uint32_t>& begins) const;

  const NetworkProblem& problem_;
  double spacing_;  ///< [m]
  LatticeRows rows_;
  int lanes_;
  int vectors_;
  bool damped_ = false;
  NodeLayout layout_{};
  std::vector<Real> tables_{};
  std::vector<long> row_table_{};
  std::vector<unsigned char> row_moves_{};
  std::array<bool, lattice::slots> used_{};  ///< slots that some row has a spring in
};

}  // namespace palpate
