// SPDX-License-Identifier: MIT
#include "reports/view_thinning.hpp"

#include <algorithm>
#include <numeric>

#include "reports/markup.hpp"
#include "reports/shown_units.hpp"

namespace palpate {

namespace {

using Marks = std::vector<std::uint8_t>;  // 1: the node is shown

bool is_near(const ViewFocus& focus, const Eigen::Vector3d& point) {
  const Eigen::Vector3d way = focus.end - focus.begin;
  const double along = std::clamp((point - focus.begin).dot(way) / std::max(way.squaredNorm(), 1e-300), 0.0, 1.0);
  return (point - focus.begin - along * way).norm() < focus.radius;
}

/// Marks the corners of the cells of the surface, on either side of the cut, and near the tool.
Marks shell_of(const CellGrid& grid, const SpringNetwork& network, const ViewFocus& focus) {
  Marks shown(static_cast<std::size_t>(network.node_count()), 0);
  const auto mark = [&](const GridPlace& cell) {
    for (const int node : grid.corners(cell)) { shown[static_cast<std::size_t>(node)] = 1; }
  };
  for (const GridFace& face : exposed_faces(grid, [](const GridPlace&) { return true; })) { mark(face.cell); }
  for (const GridPlace& cell : grid.cells()) {
    const std::array<int, 8> nodes = grid.corners(cell);
    const Eigen::Vector3d low = network.rest_position.col(nodes[0]);
    const Eigen::Vector3d high = network.rest_position.col(nodes[7]);
    const double reach = high.y() - low.y();
    const bool at_cut = low.y() - reach <= focus.cut && focus.cut <= high.y() + reach;
    if (at_cut || is_near(focus, 0.5 * (low + high))) { mark(cell); }
  }
  return shown;
}

Marks all_of(const CellGrid& grid) {
  Marks shown(grid.places().size(), 0);
  for (std::size_t n = 0; n < shown.size(); ++n) { shown[n] = grid.places()[n][0] >= 0; }
  return shown;
}

/// Every n-th node, and all near the tool as long as there is room.
Marks sample_of(const SpringNetwork& network, const ViewFocus& focus) {
  const auto count = static_cast<std::size_t>(network.node_count());
  Marks shown(count, 0);
  const std::size_t stride = count / most_nodes_shown_all + 1;
  for (std::size_t n = 0; n < count; n += stride) { shown[n] = 1; }
  int room = most_nodes_shown - most_nodes_shown_all;
  for (std::size_t n = 0; n < count && room > 0; ++n) {
    if (shown[n] != 0 || !is_near(focus, network.rest_position.col(static_cast<Eigen::Index>(n)))) { continue; }
    shown[n] = 1;
    --room;
  }
  return shown;
}

long count_of_marks(const Marks& marks) { return std::ranges::count(marks, std::uint8_t{1}); }

ShownNodes chosen(Marks shown, const std::vector<int>& needed, std::optional<CellGrid> grid, const std::string& which) {
  for (const int node : needed) { shown[static_cast<std::size_t>(node)] = 1; }
  ShownNodes result{.grid = std::move(grid)};
  for (std::size_t n = 0; n < shown.size(); ++n) {
    if (shown[n] != 0) { result.nodes.push_back(static_cast<int>(n)); }
  }
  if (result.nodes.size() < shown.size()) {
    result.note = short_number(static_cast<double>(result.nodes.size()), 9) + " of " +
                  short_number(static_cast<double>(shown.size()), 9) + " nodes are shown: " + which;
  }
  return result;
}

std::string near_tool(const ViewFocus& focus) {
  return focus.radius > 0.0 ? " and what is within " + quantity(mm * focus.radius, "mm") + " of the tool's line" : "";
}

}  // namespace

ShownNodes shown_nodes(const SpringNetwork& network, const ViewFocus& focus, const std::vector<int>& needed) {
  std::optional<CellGrid> grid = CellGrid::of(network);
  if (network.node_count() <= most_nodes_shown_all) {
    return chosen(Marks(static_cast<std::size_t>(network.node_count()), 1), needed, std::move(grid), "");
  }
  if (!grid) { return chosen(sample_of(network, focus), needed, std::nullopt, "every n-th" + near_tool(focus)); }
  for (int n = 1;; ++n) {
    CellGrid coarse = n == 1 ? *grid : grid->thinned(n);
    const std::string planes = n == 1 ? ""
                                      : " of every " + std::to_string(n) +
                                            (n == 2   ? "nd"
                                             : n == 3 ? "rd"
                                                      : "th") +
                                            " plane of the grid";
    const Marks all = all_of(coarse);
    if (count_of_marks(all) <= most_nodes_shown_all) {
      return chosen(all, needed, std::move(coarse), "those" + planes);
    }
    const Marks shell = shell_of(coarse, network, focus);
    if (count_of_marks(shell) > most_nodes_shown) { continue; }
    return chosen(shell, needed, std::move(coarse), "the surface, the plane of the cut" + near_tool(focus) + planes);
  }
}

}  // namespace palpate
