// SPDX-License-Identifier: MIT
#pragma once
/// Tissue as point masses connected by spring-dampers (model/EQUATIONS.md, "Network").

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <optional>
#include <span>
#include <vector>

#include "model/problem/cell_law.hpp"
#include "model/problem/material_law.hpp"

namespace palpate {

/// Spring with damper. The force on node a is (k (L - L0) + c L') u, with u from a to b.
template <class Real> struct SpringOf {
  int a = 0;
  int b = 0;
  Real stiffness{};    ///< k  [N/m]
  Real viscosity{};    ///< c  [N s/m]
  Real rest_length{};  ///< L0 [m]
  int law = 0;         ///< 0: linear and elastic; n: number n - 1 of SpringNetwork::laws

  /// Returns the spring in another precision, between other ends.
  template <class To> [[nodiscard]] SpringOf<To> between(int to_a, int to_b) const {
    return {to_a,
            to_b,
            static_cast<To>(stiffness),
            static_cast<To>(viscosity),
            static_cast<To>(rest_length),
            law};
  }
};
using Spring = SpringOf<double>;

/// Numbering of the nodes of a regular lattice: x fastest, then y, then z.
struct LatticeShape {
  std::array<int, 3> nodes{};
  double spacing = 0.0;  ///< [m]
  int connectivity = 26;

  [[nodiscard]] int node_count() const { return nodes[0] * nodes[1] * nodes[2]; }
  [[nodiscard]] int index(int i, int j, int l) const { return (l * nodes[1] + j) * nodes[0] + i; }
  [[nodiscard]] std::array<int, 3> place(int node) const {  ///< (i, j, l) of an index
    return {node % nodes[0], node / nodes[0] % nodes[1], node / (nodes[0] * nodes[1])};
  }
  /// Returns the position of a node [m]; x and y are centred on 0, and z begins at 0.
  [[nodiscard]] Eigen::Vector3d position(int i, int j, int l) const;
  /// Returns the natural length of a spring with an offset of `step` nodes along each axis [m].
  [[nodiscard]] double bond_length(const std::array<int, 3>& step) const;
  /// Returns true if a spring connects two of 26 neighbours at their distance, to rounding error.
  [[nodiscard]] bool has_bond(const Spring& spring) const;
};

/// Compressed, ordered list of springs. Consecutive nodes with the same springs, as in a lattice,
/// store them once; other networks need less than twice the memory of a plain list. The list of a
/// regular lattice keeps its shape while every added spring belongs to it.
class SpringList {
 public:
  /// A spring relative to its node a.
  struct Bond {
    int to = 0;   ///< b - a
    int law = 0;  ///< as in a spring
    double stiffness = 0.0;
    double viscosity = 0.0;
    double rest_length = 0.0;
    bool operator==(const Bond&) const = default;
  };
  /// Consecutive nodes, from first_node, with the same bonds; ordered by node, then by bond.
  struct Run {
    int first_node = 0;
    int nodes = 0;
    std::uint32_t first_bond = 0;
    std::uint32_t bonds = 0;
    std::size_t first_spring = 0;  ///< index in the list
  };
  class Iterator;
  using value_type = Spring;
  using const_iterator = Iterator;

  SpringList() = default;
  SpringList(std::initializer_list<Spring> springs)
      : SpringList(std::span(springs.begin(), springs.size())) {}
  SpringList(const std::vector<Spring>& springs) : SpringList(std::span(springs)) {}
  explicit SpringList(std::span<const Spring> springs,
                      const std::optional<LatticeShape>& lattice = {});
  /// Creates an empty list for a lattice with at least two nodes along each axis.
  explicit SpringList(const LatticeShape& lattice) : lattice_(lattice) {}

  /// Appends a spring. The list loses its lattice if the spring does not belong to it.
  void push_back(const Spring& spring);
  /// Calls change(std::vector<Spring>&) and replaces the springs by the result.
  template <class Change> void edit(Change change) {
    std::vector<Spring> all = listed();
    change(all);
    *this = SpringList(all, lattice_);
  }
  /// Calls change(Spring&) for each spring.
  template <class Change> void change_each(Change change) {
    edit([&](std::vector<Spring>& all) {
      for (Spring& spring : all) { change(spring); }
    });
  }
  [[nodiscard]] std::vector<Spring> listed() const;

  /// Returns the regular lattice of the springs; empty for any other network.
  [[nodiscard]] const std::optional<LatticeShape>& lattice() const { return lattice_; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] Spring operator[](std::size_t n) const;  ///< n < size()
  [[nodiscard]] Spring back() const { return (*this)[size_ - 1]; }
  [[nodiscard]] Iterator begin() const;
  [[nodiscard]] Iterator end() const;

  [[nodiscard]] std::span<const Run> runs() const { return runs_; }
  [[nodiscard]] std::span<const Bond> bonds(const Run& run) const {
    return std::span(bonds_).subspan(run.first_bond, run.bonds);
  }
  /// Returns every bond of the network, possibly several times.
  [[nodiscard]] std::span<const Bond> kinds() const { return bonds_; }
  static Spring spring_of(int node, const Bond& bond) {
    return {node, node + bond.to, bond.stiffness, bond.viscosity, bond.rest_length, bond.law};
  }
  [[nodiscard]] std::size_t memory_bytes() const {
    return runs_.capacity() * sizeof(Run) + bonds_.capacity() * sizeof(Bond);
  }

 private:
  /// Bonds that later nodes can share.
  struct Pattern {
    std::uint32_t first_bond = 0;
    std::uint32_t bonds = 0;
  };
  void settle();
  [[nodiscard]] bool same(const Pattern& known, const Run& run) const;

  std::optional<LatticeShape> lattice_{};
  std::vector<Run> runs_{};
  std::vector<Bond> bonds_{};
  std::size_t size_ = 0;
  bool open_ = false;                ///< the last run can receive further bonds
  std::array<Pattern, 9> recent_{};  ///< as many as a lattice layer has
  std::size_t next_recent_ = 0;
};

[[nodiscard]] bool is_damped(const SpringList& springs);

class SpringList::Iterator {
 public:
  using iterator_concept = std::forward_iterator_tag;
  using iterator_category = std::input_iterator_tag;
  using value_type = Spring;
  using difference_type = std::ptrdiff_t;
  using reference = Spring;

  Iterator() = default;
  Iterator(const Run* run, const Bond* bonds) : bonds_(bonds), run_(run) {}
  Spring operator*() const {
    return spring_of(run_->first_node + node_, bonds_[run_->first_bond + bond_]);
  }
  Iterator& operator++() {
    if (++bond_ == run_->bonds) {
      bond_ = 0;
      if (++node_ == run_->nodes) {
        node_ = 0;
        ++run_;
      }
    }
    return *this;
  }
  Iterator operator++(int) {
    Iterator before = *this;
    ++*this;
    return before;
  }
  bool operator==(const Iterator& other) const {
    return bond_ == other.bond_ && node_ == other.node_ && run_ == other.run_;
  }

 private:
  const Bond* bonds_ = nullptr;
  const Run* run_ = nullptr;
  int node_ = 0;
  std::uint32_t bond_ = 0;
};

inline auto SpringList::begin() const -> Iterator { return {runs_.data(), bonds_.data()}; }
inline auto SpringList::end() const -> Iterator {
  return {runs_.data() + runs_.size(), bonds_.data()};
}

using NodeVectors = Eigen::Matrix<double, 3, Eigen::Dynamic>;  ///< one column per node

/// The way in which a compiler's options make Eigen allocate and align.
template <bool plain_malloc, int static_alignment> struct EigenMemory {};
/// Defined by the library for the way in which it was compiled. A program that was compiled in
/// another way, for example with -mavx, does not link instead of freeing memory of the library in
/// the wrong way (docs/install.md, "Eigen").
using EigenMemoryHere =
    EigenMemory<EIGEN_MALLOC_ALREADY_ALIGNED != 0, EIGEN_MAX_STATIC_ALIGN_BYTES>;
bool has_same_eigen_memory_as_library(EigenMemoryHere) noexcept;
inline const bool same_eigen_memory = has_same_eigen_memory_as_library({});

/// Cell of eight nodes that resists changes of its volume (model/EQUATIONS.md, "Cell volume"). One
/// of a material with nu = 1/4 has no stiffness.
struct VolumeCell : CellNumbers<double> {
  std::array<int, 8> nodes{};  ///< corner n is at (n & 1, n >> 1 & 1, n >> 2) of the cell
  int law = 0;                 ///< as in a spring; stiffening has no effect on volumes
};

/// Network of point masses, springs and cells.
struct SpringNetwork {
  NodeVectors rest_position{};         ///< X   [m]
  NodeVectors initial_displacement{};  ///< x(0) - X [m]; no columns: all zero
  NodeVectors initial_velocity{};      ///< x'(0) [m/s]; no columns: all zero
  Eigen::VectorXd mass{};              ///< [kg]
  std::vector<std::uint8_t> fixed{};   ///< 1: the node never moves
  SpringList springs{};
  /// Laws of springs and cells that stiffen or relax.
  std::vector<MaterialLaw> laws{};
  /// Cells that resist changes of volume; all cells of a grid that is not a regular lattice.
  std::vector<VolumeCell> cells{};

  [[nodiscard]] Eigen::Index node_count() const { return rest_position.cols(); }
  /// Returns the number of a law for springs and cells; adds the law if it is new.
  int law_number(const MaterialLaw& law);
  /// Returns the law of a spring with a number above 0.
  [[nodiscard]] const MaterialLaw& law_of(const Spring& spring) const {
    return laws[static_cast<std::size_t>(spring.law - 1)];
  }
  [[nodiscard]] bool is_fixed(int node) const { return fixed[static_cast<std::size_t>(node)] != 0; }
  [[nodiscard]] Eigen::Vector3d initial_place(int node) const {  ///< x(0) of one node [m]
    if (initial_displacement.cols() == 0) { return rest_position.col(node); }
    return rest_position.col(node) + initial_displacement.col(node);
  }
  [[nodiscard]] NodeVectors initial_position() const {
    if (initial_displacement.cols() == 0) { return rest_position; }
    return rest_position + initial_displacement;
  }
};

/// Returns true if a spring or a cell has viscosity.
[[nodiscard]] bool is_damped(const SpringNetwork& network);
/// Returns true if a spring or a cell relaxes.
[[nodiscard]] bool relaxes(const SpringNetwork& network);
/// Returns true if a cell resists changes of its volume.
[[nodiscard]] bool has_volume_terms(const SpringNetwork& network);

}  // namespace palpate
