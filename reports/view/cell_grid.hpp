// SPDX-License-Identifier: MIT
#pragma once
/// Grid planes through the nodes of a network, and the tissue cells between them. Spacing may vary
/// and nodes may be missing. A cell has eight corners, and its twelve edges are springs.

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
  /// Finds the grid of a network. Returns nothing if the nodes are not on a grid or if there is no
  /// complete cell.
  static std::optional<CellGrid> of(const SpringNetwork& network);

  [[nodiscard]] const std::vector<GridPlace>& places() const { return place_; }
  [[nodiscard]] const GridPlace& extent() const { return extent_; }
  [[nodiscard]] int node_at(const GridPlace& place) const;  ///< node index; -1: no node
  [[nodiscard]] bool is_cell(const GridPlace& lowest) const;
  /// Node indices of the corners of a cell. Corner n has bit 0 along x, bit 1 along y, bit 2 along
  /// z.
  [[nodiscard]] std::array<int, 8> corners(const GridPlace& lowest) const;
  /// Cells by their lowest corners.
  [[nodiscard]] const std::vector<GridPlace>& cells() const { return cells_; }

  /// Returns the grid of every n-th plane. A cell exists if all n^3 original cells exist. Node
  /// indices do not change.
  [[nodiscard]] CellGrid thinned(int n) const;

 private:
  void add_nodes(std::vector<GridPlace> places, const std::vector<std::uint8_t>& present);
  template <class IsCell> void add_cells(IsCell is_cell);

  std::vector<GridPlace> place_{};  ///< of every node; (-1, -1, -1): not on this grid
  GridPlace extent_{0, 0, 0};
  std::vector<int> node_at_{};
  std::vector<std::uint8_t> cell_at_{};
  std::vector<GridPlace> cells_{};
};

/// Grid indices shifted by `step` along an axis.
inline GridPlace beside(GridPlace place, int axis, int step) {
  place[static_cast<std::size_t>(axis)] += step;
  return place;
}

/// Face of a cell. The corners are ordered by the right-hand rule with the normal out of the cell.
struct GridFace {
  GridPlace cell{};
  std::array<int, 4> nodes{};
};

/// Faces between the cells for which `kept` is true and all other space.
std::vector<GridFace> exposed_faces(const CellGrid& grid,
                                    const std::function<bool(const GridPlace&)>& kept);

// Selection of the nodes for a view: all nodes of a small network, else the surface, the cut plane
// and the region near the tool. A network that is still too large is thinned to every n-th grid
// plane.

inline constexpr int most_nodes_shown_all = 20'000;
inline constexpr int most_nodes_shown = 60'000;

/// Region shown in full resolution: a segment of the tool path, and the cut plane.
struct ViewFocus {
  Eigen::Vector3d begin{0.0, 0.0, 0.0};  ///< [m]
  Eigen::Vector3d end{0.0, 0.0, 0.0};    ///< [m]
  double radius = 0.0;                   ///< radius around the segment [m]; 0: no tool
  double cut = 0.0;                      ///< y coordinate of the plane [m]
};

struct ShownNodes {
  std::vector<int> nodes{};        ///< node indices in ascending order
  std::optional<CellGrid> grid{};  ///< grid of these nodes, with node indices of the network
  std::string note{};              ///< description of the omitted nodes; empty if none
};

/// Selects the nodes to show. The nodes in `needed` are always included.
ShownNodes shown_nodes(const SpringNetwork& network, const ViewFocus& focus,
                       const std::vector<int>& needed);

}  // namespace palpate
