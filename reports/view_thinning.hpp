// SPDX-License-Identifier: MIT
#pragma once
/// Which nodes of a network a view shows: all where they are few, else the surface, the plane of the cut and
/// what is near the tool, of every n-th plane of the grid where that is still too many.

#include <optional>
#include <string>
#include <vector>

#include "reports/cell_grid.hpp"

namespace palpate {

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
ShownNodes shown_nodes(const SpringNetwork& network, const ViewFocus& focus, const std::vector<int>& needed);

}  // namespace palpate
