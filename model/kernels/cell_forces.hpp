// SPDX-License-Identifier: MIT
#pragma once
/// Forces and matrices of the cells of a list network (model/EQUATIONS.md, "Cell volume").

#include <Eigen/SparseCore>
#include <array>
#include <cstdint>
#include <vector>

#include "model/kernels/system.hpp"
#include "model/problem/cell_law.hpp"
#include "model/problem/problem.hpp"

namespace palpate {

template <class Real> class CellForces {
 public:
  /// Takes the cells of a problem with at least one free node. Allocates.
  void take(const NetworkProblem& problem, const NodeLayout& layout) {
    const NodeVectors& places = problem.held_position();
    for (const VolumeCell& cell : problem.network().cells) {
      Cell mine;
      bool free = false;
      for (std::size_t n = 0; n < 8; ++n) {
        const auto node = static_cast<std::size_t>(cell.nodes[n]);
        mine.first[n] = layout.first[node];
        free = free || mine.first[n] >= 0;
        if (mine.first[n] >= 0) { continue; }
        mine.first[n] = -1 - static_cast<int>(fixed_.size());
        const auto place = places.col(cell.nodes[n]).template cast<Real>().eval();
        fixed_.push_back({place.x(), place.y(), place.z()});
      }
      if (!free) { continue; }
      mine.numbers = {static_cast<Real>(cell.stiffness), static_cast<Real>(cell.viscosity),
                      static_cast<Real>(cell.collapse), static_cast<Real>(cell.volume)};
      damped_ = damped_ || cell.viscosity > 0.0;
      cells_.push_back(mine);
    }
  }
  [[nodiscard]] bool damped() const { return damped_; }
  /// Adds the forces of all cells to f.
  void add(const Real* q, const Real* v, Real* f) const noexcept {
    for (const Cell& cell : cells_) {
      Corners<Real> on{};
      if (damped_) {
        add_cell_forces<true>(cell.numbers, at_corners(cell, q), rates(cell, v), on);
      } else {
        add_cell_forces<false>(cell.numbers, at_corners(cell, q), {}, on);
      }
      spread(cell, on, f);
    }
  }
  /// Adds -C(q) w to f.
  void add_damping(const Real* q, const Real* w, Real* f) const noexcept {
    if (!damped_) { return; }
    for (const Cell& cell : cells_) {
      Corners<Real> on{};
      add_cell_damping(cell.numbers, at_corners(cell, q), rates(cell, w), on);
      spread(cell, on, f);
    }
  }
  [[nodiscard]] double energy(const Real* q) const noexcept {
    double sum = 0.0;
    for (const Cell& cell : cells_) {
      const Corners<Real> x = at_corners(cell, q);
      Corners<double> exact;
      for (std::size_t n = 0; n < 8; ++n) {
        exact[n] = {static_cast<double>(x[n].x), static_cast<double>(x[n].y),
                    static_cast<double>(x[n].z)};
      }
      const CellNumbers<Real>& own = cell.numbers;
      sum += cell_energy({static_cast<double>(own.stiffness), static_cast<double>(own.viscosity),
                          static_cast<double>(own.collapse), static_cast<double>(own.volume)},
                         exact);
    }
    return sum;
  }

  /// Calls visit(first row, first column) for each pair of different free corners of a cell.
  template <class Visit> void for_each_pair(Visit visit) const {
    for (const Cell& cell : cells_) {
      for (const int row : cell.first) {
        for (const int column : cell.first) {
          if (row >= 0 && column >= 0 && row != column) { visit(row, column); }
        }
      }
    }
  }
  /// Finds the entries of matrix `a` that add_jacobian() changes. Allocates.
  void find_slots(const Eigen::SparseMatrix<Real>& a) {
    slots_.clear();
    for (const Cell& cell : cells_) {
      for (const int column : cell.first) {
        for (int c = 0; c < 3 && column >= 0; ++c) {
          for (const int row : cell.first) {
            if (row >= 0) { slots_.push_back(slot_of(a, row, column + c)); }
          }
        }
      }
    }
  }
  /// Adds on_damping C + on_stiffness K to the values of a matrix.
  void add_jacobian(const Real* q, const Real* v, Real on_damping, Real on_stiffness,
                    Real* values) const noexcept {
    auto slot = slots_.begin();
    for (const Cell& cell : cells_) {
      const auto gradient = cell_gradient(cell.numbers, at_corners(cell, q), rates(cell, v));
      for (Eigen::Index column = 0; column < 24; ++column) {
        if (cell.first[static_cast<std::size_t>(column / 3)] < 0) { continue; }
        for (Eigen::Index row = 0; row < 24; row += 3) {
          if (cell.first[static_cast<std::size_t>(row / 3)] < 0) { continue; }
          for (Eigen::Index r = 0; r < 3; ++r) {
            values[*slot + r] += on_stiffness * gradient.position(row + r, column) +
                                 on_damping * gradient.velocity(row + r, column);
          }
          ++slot;
        }
      }
    }
  }
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    return cells_.size() * sizeof(Cell) + fixed_.size() * sizeof(fixed_[0]) +
           slots_.size() * sizeof(slots_[0]);
  }

 private:
  struct Cell {
    std::array<int, 8> first{};  ///< coordinate of each corner; -1 - n for place n of fixed_
    CellNumbers<Real> numbers{};
  };
  [[nodiscard]] Corners<Real> at_corners(const Cell& cell, const Real* q) const noexcept {
    Corners<Real> x;
    for (std::size_t n = 0; n < 8; ++n) {
      const int at = cell.first[n];
      x[n] = at >= 0 ? Vector3Of<Real>{q[at], q[at + 1], q[at + 2]}
                     : fixed_[static_cast<std::size_t>(-1 - at)];
    }
    return x;
  }
  [[nodiscard]] static Corners<Real> rates(const Cell& cell, const Real* v) noexcept {
    Corners<Real> rate{};
    for (std::size_t n = 0; n < 8; ++n) {
      const int at = cell.first[n];
      if (at >= 0) { rate[n] = {v[at], v[at + 1], v[at + 2]}; }
    }
    return rate;
  }
  static void spread(const Cell& cell, const Corners<Real>& on, Real* f) noexcept {
    for (std::size_t n = 0; n < 8; ++n) {
      const int at = cell.first[n];
      if (at < 0) { continue; }
      f[at] += on[n].x;
      f[at + 1] += on[n].y;
      f[at + 2] += on[n].z;
    }
  }

  std::vector<Cell> cells_{};
  std::vector<Vector3Of<Real>> fixed_{};
  bool damped_ = false;
  std::vector<std::ptrdiff_t> slots_{};  ///< first rows of the blocks, cell by cell
};

}  // namespace palpate
