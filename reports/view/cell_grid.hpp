// SPDX-License-Identifier: MIT
#pragma once
/// The grid that the nodes of a network lie on, regular or not, with or without holes, and the
/// cells of tissue between them: eight corners whose twelve edges are springs.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "model/problem/spring_network.hpp"

namespace palpate {

using GridPlace = std::array<int, 3>;

class CellGrid {
 public:
  /// Nothing where the nodes lie on no grid, or no cell is whole.
  static std::optional<CellGrid> of(const SpringNetwork& network);

  [[nodiscard]] const std::vector<GridPlace>& places() const { return place_; }
  [[nodiscard]] const GridPlace& extent() const { return extent_; }
  [[nodiscard]] int node_at(const GridPlace& place) const;  ///< -1: none
  [[nodiscard]] bool is_cell(const GridPlace& lowest) const;
  /// Corner n of a cell: bit 0 along x, bit 1 along y, bit 2 along z.
  [[nodiscard]] std::array<int, 8> corners(const GridPlace& lowest) const;
  [[nodiscard]] const std::vector<GridPlace>& cells() const {
    return cells_;
  }  ///< by their lowest corner

  /// The grid of every n-th plane: a cell is there where all n^3 cells are. Its nodes keep their
  /// indices.
  [[nodiscard]] CellGrid thinned(int n) const;

 private:
  void add_nodes(std::vector<GridPlace> places, const std::vector<std::uint8_t>& present);
  template <class IsCell> void add_cells(IsCell is_cell);

  std::vector<GridPlace>
      place_{};  ///< of every node of the network; (-1, -1, -1): not on this grid
  GridPlace extent_{0, 0, 0};
  std::vector<int> node_at_{};
  std::vector<std::uint8_t> cell_at_{};
  std::vector<GridPlace> cells_{};
};

/// Place next to `place` along an axis.
inline GridPlace beside(GridPlace place, int axis, int step) {
  place[static_cast<std::size_t>(axis)] += step;
  return place;
}

/// A side of a cell, its corners counted so that the right hand points out of the cell.
struct GridFace {
  GridPlace cell{};
  std::array<int, 4> nodes{};
};

/// Sides of the cells that are `kept` towards those that are not.
std::vector<GridFace> exposed_faces(const CellGrid& grid,
                                    const std::function<bool(const GridPlace&)>& kept);

// Which nodes of a network a view shows: all where they are few, else the surface, the plane of the
// cut and what is near the tool, of every n-th plane of the grid where that is still too many.

inline constexpr int most_nodes_shown_all = 20'000;
inline constexpr int most_nodes_shown = 60'000;

/// What must be seen in full: a stretch of the tool's line, and the plane of the cut.
struct ViewFocus {
  Eigen::Vector3d begin{0.0, 0.0, 0.0};  ///< [m]
  Eigen::Vector3d end{0.0, 0.0, 0.0};    ///< [m]
  double radius = 0.0;                   ///< around the stretch [m]; 0: there is no tool
  double cut = 0.0;                      ///< y of the plane [m]
};

struct ShownNodes {
  std::vector<int> nodes{};        ///< ascending
  std::optional<CellGrid> grid{};  ///< that they lie on, in the numbering of the network
  std::string note{};              ///< what was left out; empty: nothing
};

/// `needed` are shown whatever else is.
ShownNodes shown_nodes(const SpringNetwork& network, const ViewFocus& focus,
                       const std::vector<int>& needed);

}  // namespace palpate
