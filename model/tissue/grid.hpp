// SPDX-License-Identifier: MIT
#pragma once
/// Numbering of the places of a regular grid: x fastest, then y, then z.

#include <algorithm>
#include <array>
#include <cstddef>

namespace palpate {

using GridCount = std::array<int, 3>;  ///< number of places along x, y and z

inline std::size_t grid_index(const GridCount& count, int i, int j, int l) {
  return (static_cast<std::size_t>(l) * static_cast<std::size_t>(count[1]) +
          static_cast<std::size_t>(j)) *
             static_cast<std::size_t>(count[0]) +
         static_cast<std::size_t>(i);
}

/// Calls visit(i, j, l) for the places from `low` to `high`, both included, in order of their
/// index.
template <class Visit>
void for_each_between(const std::array<int, 3>& low, const std::array<int, 3>& high, Visit visit) {
  for (int l = low[2]; l <= high[2]; ++l) {
    for (int j = low[1]; j <= high[1]; ++j) {
      for (int i = low[0]; i <= high[0]; ++i) { visit(i, j, l); }
    }
  }
}

/// Calls visit(i, j, l) for all places in order of their index.
template <class Visit> void for_each_place(const GridCount& count, Visit visit) {
  for_each_between({0, 0, 0}, {count[0] - 1, count[1] - 1, count[2] - 1}, visit);
}
/// Calls visit(i, j) for all columns along z, x fastest.
template <class Visit> void for_each_column(const GridCount& count, Visit visit) {
  for_each_place({count[0], count[1], 1}, [&](int i, int j, int) { visit(i, j); });
}

/// Returns the number of cells between neighbouring nodes of a grid.
inline GridCount cells_of(const GridCount& nodes) {
  return {nodes[0] - 1, nodes[1] - 1, nodes[2] - 1};
}

/// Calls visit(i, j, l) for the nodes at the eight corners of a cell.
template <class Visit> void for_each_corner(int i, int j, int l, Visit visit) {
  for (int n = 0; n < 8; ++n) { visit(i + (n & 1), j + ((n >> 1) & 1), l + (n >> 2)); }
}

/// Calls visit(i, j, l) for the cells that contain both the node at `a` and the node at a + step,
/// in order of their index. Cell (i, j, l) has node (i, j, l) at its corner of least coordinates.
template <class Visit>
void for_each_cell_around(const GridCount& nodes, const std::array<int, 3>& a,
                          const std::array<int, 3>& step, Visit visit) {
  std::array<int, 3> low{};
  std::array<int, 3> high{};
  for (std::size_t n = 0; n < 3; ++n) {
    low[n] = std::max(step[n] == 1 ? a[n] : a[n] - 1, 0);
    high[n] = std::min(step[n] == -1 ? a[n] - 1 : a[n], nodes[n] - 2);
  }
  for_each_between(low, high, visit);
}

}  // namespace palpate
