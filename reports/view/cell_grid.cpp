// SPDX-License-Identifier: MIT

#include "reports/view/cell_grid.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "reports/html/html_page.hpp"
#include "reports/plot/shown_units.hpp"

namespace palpate {

namespace {

constexpr GridPlace nowhere{-1, -1, -1};

std::size_t slot(const GridPlace& extent, const GridPlace& p) {
  return (static_cast<std::size_t>(p[2]) * static_cast<std::size_t>(extent[1]) +
          static_cast<std::size_t>(p[1])) *
             static_cast<std::size_t>(extent[0]) +
         static_cast<std::size_t>(p[0]);
}

bool within(const GridPlace& extent, const GridPlace& p) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (p[axis] < 0 || p[axis] >= extent[axis]) { return false; }
  }
  return true;
}

/// Index of the grid plane of each coordinate along an axis.
std::vector<int> planes_of(const Eigen::RowVectorXd& coordinate) {
  const double same = 1e-6 * (coordinate.maxCoeff() - coordinate.minCoeff());
  std::vector<double> planes(coordinate.begin(), coordinate.end());
  std::ranges::sort(planes);
  std::size_t kept = 0;
  for (const double plane : planes) {
    if (kept == 0 || plane - planes[kept - 1] > same) { planes[kept++] = plane; }
  }
  planes.resize(kept);
  std::vector<int> index;
  for (const double x : coordinate) {
    index.push_back(static_cast<int>(std::ranges::upper_bound(planes, x + same) - planes.begin()) -
                    1);
  }
  return index;
}

/// Grid indices of the nodes; empty if few nodes share planes, so that there is no grid.
std::vector<GridPlace> places_by_planes(const NodeVectors& position) {
  constexpr double most_room = 64.0;  // maximum number of grid positions per node
  std::array<std::vector<int>, 3> index;
  double room = 1.0;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    auto& planes = index[static_cast<std::size_t>(axis)];
    planes = planes_of(position.row(axis));
    room *= 1.0 + *std::ranges::max_element(planes);
  }
  if (room > most_room * static_cast<double>(position.cols())) { return {}; }
  std::vector<GridPlace> places;
  for (std::size_t n = 0; n < index[0].size(); ++n) {
    places.push_back({index[0][n], index[1][n], index[2][n]});
  }
  return places;
}

std::vector<GridPlace> places_of(const SpringNetwork& network) {
  const auto& shape = network.springs.lattice();
  if (!shape) { return places_by_planes(network.rest_position); }
  std::vector<GridPlace> places;
  for (int node = 0; node < shape->node_count(); ++node) { places.push_back(shape->place(node)); }
  return places;
}

/// Bit `axis` of a node is set if a spring connects it to the next node along that axis.
std::vector<std::uint8_t> edges_of(const SpringNetwork& network,
                                   const std::vector<GridPlace>& places) {
  std::vector<std::uint8_t> edges(places.size(), 0);
  for (const Spring& spring : network.springs) {
    const auto a = static_cast<std::size_t>(spring.a);
    const auto b = static_cast<std::size_t>(spring.b);
    GridPlace step{};
    int apart = 0;
    for (std::size_t n = 0; n < 3; ++n) {
      step[n] = places[b][n] - places[a][n];
      apart += std::abs(step[n]);
    }
    if (apart != 1) { continue; }
    for (unsigned axis = 0; axis < 3; ++axis) {
      const auto bit = static_cast<std::uint8_t>(1U << axis);
      if (step[axis] != 0) { edges[step[axis] > 0 ? a : b] |= bit; }
    }
  }
  return edges;
}

}  // namespace

int CellGrid::node_at(const GridPlace& place) const {
  return within(extent_, place) ? node_at_[slot(extent_, place)] : -1;
}

bool CellGrid::is_cell(const GridPlace& lowest) const {
  return within(extent_, lowest) && cell_at_[slot(extent_, lowest)] != 0;
}

std::array<int, 8> CellGrid::corners(const GridPlace& lowest) const {
  std::array<int, 8> nodes{};
  for (int n = 0; n < 8; ++n) {
    nodes[static_cast<std::size_t>(n)] =
        node_at({lowest[0] + (n & 1), lowest[1] + (n >> 1 & 1), lowest[2] + (n >> 2)});
  }
  return nodes;
}

void CellGrid::add_nodes(std::vector<GridPlace> places, const std::vector<std::uint8_t>& present) {
  place_ = std::move(places);
  for (std::size_t n = 0; n < place_.size(); ++n) {
    if (present[n] == 0) { place_[n] = nowhere; }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      extent_[axis] = std::max(extent_[axis], place_[n][axis] + 1);
    }
  }
  node_at_.assign(slot(extent_, {0, 0, extent_[2]}), -1);
  cell_at_.assign(node_at_.size(), 0);
  for (std::size_t n = 0; n < place_.size(); ++n) {
    if (place_[n] != nowhere) { node_at_[slot(extent_, place_[n])] = static_cast<int>(n); }
  }
}

template <class IsCell> void CellGrid::add_cells(IsCell is_cell) {
  for (const GridPlace& place : place_) {
    if (place == nowhere || !is_cell(place)) { continue; }
    cell_at_[slot(extent_, place)] = 1;
    cells_.push_back(place);
  }
}

std::optional<CellGrid> CellGrid::of(const SpringNetwork& network) {
  if (network.node_count() == 0) { return std::nullopt; }
  CellGrid grid;
  std::vector<GridPlace> places = places_of(network);
  if (places.empty()) { return std::nullopt; }
  const std::vector<std::uint8_t> edges = edges_of(network, places);
  grid.add_nodes(std::move(places), std::vector<std::uint8_t>(edges.size(), 1));
  grid.add_cells([&](const GridPlace& lowest) {
    const std::array<int, 8> nodes = grid.corners(lowest);
    for (unsigned n = 0; n < 8; ++n) {
      const auto wanted = static_cast<std::uint8_t>(~n & 7U);  // axes with a further corner
      if (nodes[n] < 0 || (edges[static_cast<std::size_t>(nodes[n])] & wanted) != wanted) {
        return false;
      }
    }
    return true;
  });
  if (grid.cells_.empty()) { return std::nullopt; }
  return grid;
}

CellGrid CellGrid::thinned(int n) const {
  CellGrid grid;
  std::vector<GridPlace> places = place_;
  std::vector<std::uint8_t> present(places.size(), 0);
  for (std::size_t node = 0; node < places.size(); ++node) {
    present[node] = std::ranges::all_of(places[node], [n](int index) { return index % n == 0; });
    for (int& index : places[node]) { index /= n; }
  }
  grid.add_nodes(std::move(places), present);
  grid.add_cells([&](const GridPlace& lowest) {
    const std::array<int, 8> nodes = grid.corners(lowest);
    if (std::ranges::find(nodes, -1) != nodes.end()) { return false; }
    for (int part = 0; part < n * n * n; ++part) {
      const GridPlace fine{n * lowest[0] + part % n, n * lowest[1] + part / n % n,
                           n * lowest[2] + part / (n * n)};
      if (!is_cell(fine)) { return false; }
    }
    return true;
  });
  return grid;
}

std::vector<GridFace> exposed_faces(const CellGrid& grid,
                                    const std::function<bool(const GridPlace&)>& kept) {
  // Corners of the faces towards -x, +x, -y, +y, -z, +z.
  static constexpr std::array<std::array<std::size_t, 4>, 6> sides{
      {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
  std::vector<GridFace> faces;
  for (const GridPlace& cell : grid.cells()) {
    if (!kept(cell)) { continue; }
    const std::array<int, 8> nodes = grid.corners(cell);
    for (int side = 0; side < 6; ++side) {
      const GridPlace next = beside(cell, side / 2, side % 2 == 0 ? -1 : 1);
      if (grid.is_cell(next) && kept(next)) { continue; }
      GridFace face{cell, {}};
      for (std::size_t n = 0; n < 4; ++n) {
        face.nodes[n] = nodes[sides[static_cast<std::size_t>(side)][n]];
      }
      faces.push_back(face);
    }
  }
  return faces;
}

namespace {

using Marks = std::vector<std::uint8_t>;  // 1: the node is shown

bool is_near(const ViewFocus& focus, const Eigen::Vector3d& point) {
  const Eigen::Vector3d way = focus.end - focus.begin;
  const double along =
      std::clamp((point - focus.begin).dot(way) / std::max(way.squaredNorm(), 1e-300), 0.0, 1.0);
  return (point - focus.begin - along * way).norm() < focus.radius;
}

/// Marks the corners of the cells at the surface, on both sides of the cut, and near the tool.
Marks shell_of(const CellGrid& grid, const SpringNetwork& network, const ViewFocus& focus) {
  Marks shown(static_cast<std::size_t>(network.node_count()), 0);
  const auto mark = [&](const GridPlace& cell) {
    for (const int node : grid.corners(cell)) { shown[static_cast<std::size_t>(node)] = 1; }
  };
  for (const GridFace& face : exposed_faces(grid, [](const GridPlace&) { return true; })) {
    mark(face.cell);
  }
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

/// Selects every n-th node, and all nodes near the tool up to the limit.
Marks sample_of(const SpringNetwork& network, const ViewFocus& focus) {
  const auto count = static_cast<std::size_t>(network.node_count());
  Marks shown(count, 0);
  const std::size_t stride = count / most_nodes_shown_all + 1;
  for (std::size_t n = 0; n < count; n += stride) { shown[n] = 1; }
  int room = most_nodes_shown - most_nodes_shown_all;
  for (std::size_t n = 0; n < count && room > 0; ++n) {
    if (shown[n] != 0 || !is_near(focus, network.rest_position.col(static_cast<Eigen::Index>(n)))) {
      continue;
    }
    shown[n] = 1;
    --room;
  }
  return shown;
}

long count_of_marks(const Marks& marks) { return std::ranges::count(marks, std::uint8_t{1}); }

ShownNodes chosen(Marks shown, const std::vector<int>& needed, std::optional<CellGrid> grid,
                  const std::string& which) {
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
  return focus.radius > 0.0
             ? " and what is within " + quantity(mm * focus.radius, "mm") + " of the tool's line"
             : "";
}

}  // namespace

ShownNodes shown_nodes(const SpringNetwork& network, const ViewFocus& focus,
                       const std::vector<int>& needed) {
  std::optional<CellGrid> grid = CellGrid::of(network);
  if (network.node_count() <= most_nodes_shown_all) {
    return chosen(Marks(static_cast<std::size_t>(network.node_count()), 1), needed, std::move(grid),
                  "");
  }
  if (!grid) {
    return chosen(sample_of(network, focus), needed, std::nullopt, "every n-th" + near_tool(focus));
  }
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
    return chosen(shell, needed, std::move(coarse),
                  "the surface, the plane of the cut" + near_tool(focus) + planes);
  }
}

}  // namespace palpate
