// SPDX-License-Identifier: MIT
#pragma once
/// Forces and matrices of the cells of a list network (model/EQUATIONS.md, "Cell volume").

#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "model/kernels/instruction_set.hpp"
#include "model/kernels/kernel_views.hpp"
#include "model/kernels/relaxation.hpp"
#include "model/kernels/system.hpp"
#include "model/problem/cell_law.hpp"
#include "model/problem/problem.hpp"

namespace palpate {

/// Returns the widest kernels of cells that this processor supports.
template <class Real> cells::Kernels<Real> cell_kernels() {
  if constexpr (std::is_same_v<Real, float>) {
    return kernels_here(&KernelSet::cells_float).front();
  } else {
    return kernels_here(&KernelSet::cells_double).front();
  }
}

template <class Real> class CellForces {
 public:
  /// Takes the cells of a problem with at least one free node. Allocates.
  void take(const NetworkProblem& problem, const NodeLayout& layout) {
    const NodeVectors& places = problem.held_position();
    for (const VolumeCell& cell : problem.network().cells) {
      if (cell.stiffness == 0.0) { continue; }
      Cell mine;
      bool free = false;
      for (std::size_t n = 0; n < 8; ++n) {
        const auto node = static_cast<std::size_t>(cell.nodes[n]);
        mine.first[n] = layout.first[node];
        free = free || mine.first[n] >= 0;
        if (mine.first[n] >= 0) { continue; }
        mine.first[n] = -1 - 3 * static_cast<int>(fixed_.size());
        const auto place = places.col(cell.nodes[n]).template cast<Real>().eval();
        fixed_.push_back({place.x(), place.y(), place.z()});
      }
      if (!free) { continue; }
      mine.numbers = cell.as<Real>();
      mine.law = cell.law;
      damped_ = damped_ || cell.viscosity > 0.0;
      cells_.push_back(mine);
    }
    if (!cells_.empty()) { make_batches(problem.network().laws); }
  }
  /// Takes the initial position, if cells relax.
  void begin(const Real* q) noexcept {
    if (!relaxation_.active()) { return; }
    find_pressures(q);
    relaxation_.begin(pressure_.data());
  }
  /// Prepares the forces of a state `s` seconds after the last one that was remembered.
  void at(double s) noexcept {
    if (relaxation_.active()) { relaxation_.at(s); }
  }
  /// Remembers the state that at() prepared.
  void remember(const Real* q) noexcept {
    if (!relaxation_.active()) { return; }
    find_pressures(q);
    relaxation_.remember(pressure_.data());
  }
  /// Takes the relaxation of the same cells with other stiffnesses at the same state.
  void continue_from(const CellForces& from) noexcept {
    if (!relaxation_.active()) { return; }
    relaxation_.continue_from(from.relaxation_, [&](std::size_t n) {
      return n < cells_.size() ? cells_[n].numbers.stiffness / from.cells_[n].numbers.stiffness
                               : Real(1);
    });
  }
  [[nodiscard]] bool resembles(const CellForces& other) const {
    return relaxation_.resembles(other.relaxation_);
  }
  [[nodiscard]] bool damped() const { return damped_; }
  /// Adds the forces of all cells to f.
  void add(const Real* q, const Real* v, Real* f) const noexcept {
    if (cells_.empty()) { return; }
    const auto lanes = static_cast<std::size_t>(kernels_.lanes);
    const cells::View<Real> view{.batches = static_cast<long>(first_.size() / (8 * lanes)),
                                 .first = first_.data(),
                                 .numbers = numbers_.data(),
                                 .fixed = fixed_.empty() ? nullptr : &fixed_[0].x,
                                 .share = relaxation_.share(),
                                 .held = relaxation_.held()};
    (relaxation_.active() ? kernels_.relaxing
     : damped_            ? kernels_.damped
                          : kernels_.undamped)(view, q, v, f);
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
    for (std::size_t index = 0; index < cells_.size(); ++index) {
      const Cell& cell = cells_[index];
      const Corners<Real> x = at_corners(cell, q);
      Corners<double> exact;
      for (std::size_t n = 0; n < 8; ++n) {
        exact[n] = {static_cast<double>(x[n].x), static_cast<double>(x[n].y),
                    static_cast<double>(x[n].z)};
      }
      const auto numbers = cell.numbers.template as<double>();
      sum += cell_energy(numbers, exact);
      if (cell.law == 0) { continue; }
      const double pressure = numbers.stiffness * (volumes_of(exact, numbers.volume).mean - 1.0);
      const double elastic = 0.5 * pressure * pressure / numbers.stiffness;
      sum += numbers.volume *
             (relaxation_.energy(index, elastic, pressure, numbers.stiffness) - elastic);
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
    for (std::size_t index = 0; index < cells_.size(); ++index) {
      const Cell& cell = cells_[index];
      const auto gradient =
          cell_gradient(cell.numbers, at_corners(cell, q), rates(cell, v), relaxed(index));
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
  /// Returns the index of a cell for relaxed(), or -1 if it does not relax.
  [[nodiscard]] int relaxing(const VolumeCell& cell, const NetworkProblem& problem,
                             const NodeLayout& layout) const {
    const auto same = [&](const Cell& mine) {
      for (std::size_t n = 0; n < 8; ++n) {
        const int first = layout.first[static_cast<std::size_t>(cell.nodes[n])];
        if (first >= 0 ? mine.first[n] != first : mine.first[n] >= 0) { return false; }
        if (first >= 0) { continue; }
        const auto place = problem.held_position().col(cell.nodes[n]).template cast<Real>().eval();
        const Vector3Of<Real>& held = fixed_[static_cast<std::size_t>((-1 - mine.first[n]) / 3)];
        if (held.x != place.x() || held.y != place.y() || held.z != place.z()) { return false; }
      }
      return true;
    };
    if (!relaxation_.active()) { return -1; }
    const auto found = std::ranges::find_if(cells_, same);
    return found == cells_.end() ? -1 : static_cast<int>(found - cells_.begin());
  }
  [[nodiscard]] RelaxedCell<Real> relaxed(std::size_t index) const noexcept {
    if (!relaxation_.active()) { return {Real(1), Real(0)}; }
    return {relaxation_.share()[index], relaxation_.held()[index]};
  }
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    return relaxation_.memory_bytes() + pressure_.size() * sizeof(Real) +
           cells_.size() * sizeof(Cell) + fixed_.size() * sizeof(fixed_[0]) +
           slots_.size() * sizeof(slots_[0]) + first_.size() * sizeof(int) +
           numbers_.size() * sizeof(Real);
  }

 private:
  struct Cell {
    /// Coordinate of each corner; -1 - n for the place whose x is number n of fixed_.
    std::array<int, 8> first{};
    CellNumbers<Real> numbers{};
    int law = 0;
  };
  /// Computes kappa (J - 1) of all cells without relaxation.
  void find_pressures(const Real* q) noexcept {
    for (std::size_t n = 0; n < cells_.size(); ++n) {
      const CellNumbers<Real>& numbers = cells_[n].numbers;
      const Real mean = volumes_of(at_corners(cells_[n], q), numbers.volume).mean;
      pressure_[n] = numbers.stiffness * (mean - Real(1));
    }
  }
  [[nodiscard]] Corners<Real> at_corners(const Cell& cell, const Real* q) const noexcept {
    Corners<Real> x;
    for (std::size_t n = 0; n < 8; ++n) {
      const int at = cell.first[n];
      x[n] = at >= 0 ? Vector3Of<Real>{q[at], q[at + 1], q[at + 2]}
                     : fixed_[static_cast<std::size_t>((-1 - at) / 3)];
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

  /// Sorts the cells into batches; the last one is filled with cells without stiffness.
  void make_batches(const std::vector<MaterialLaw>& laws) {
    kernels_ = cell_kernels<Real>();
    const auto lanes = static_cast<std::size_t>(kernels_.lanes);
    const std::size_t batches = (cells_.size() + lanes - 1) / lanes;
    if (std::ranges::any_of(laws, [](const MaterialLaw& law) { return !law.branches.empty(); })) {
      std::ranges::stable_sort(cells_, {}, &Cell::law);
      for (int law = 0; law <= static_cast<int>(laws.size()); ++law) {
        relaxation_.add(law == 0 ? MaterialLaw{} : laws[static_cast<std::size_t>(law - 1)],
                        static_cast<std::size_t>(std::ranges::count(cells_, law, &Cell::law)));
      }
      relaxation_.add({}, batches * lanes - cells_.size());
      pressure_.assign(batches * lanes, Real(0));
    }
    first_.resize(8 * lanes * batches);
    numbers_.resize(4 * lanes * batches);
    for (std::size_t n = 0; n < batches * lanes; ++n) {
      const Cell& cell = cells_[std::min(n, cells_.size() - 1)];
      const bool real = n < cells_.size();
      const std::size_t batch = n / lanes;
      const std::size_t lane = n % lanes;
      for (std::size_t corner = 0; corner < 8; ++corner) {
        first_[(8 * batch + corner) * lanes + lane] = cell.first[corner];
      }
      const CellNumbers<Real>& own = cell.numbers;
      const Real numbers[4] = {real ? own.stiffness : Real(0), real ? own.viscosity : Real(0),
                               real ? own.collapse : Real(0), own.volume};
      for (std::size_t k = 0; k < 4; ++k) { numbers_[(4 * batch + k) * lanes + lane] = numbers[k]; }
    }
  }

  cells::Kernels<Real> kernels_{};
  std::vector<int> first_{};     ///< as in cells::View
  std::vector<Real> numbers_{};  ///< as in cells::View
  std::vector<Cell> cells_{};
  std::vector<Vector3Of<Real>> fixed_{};
  bool damped_ = false;
  Relaxation<Real> relaxation_{};
  std::vector<Real> pressure_{};         ///< kappa (J - 1) of each cell [Pa]
  std::vector<std::ptrdiff_t> slots_{};  ///< first rows of the blocks, cell by cell
};

}  // namespace palpate
