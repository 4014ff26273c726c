// SPDX-License-Identifier: MIT
#pragma once
/// Cells of a grid around a bond between two of its nodes.

#include <algorithm>
#include <array>

namespace palpate {

/// Calls visit(i, j, l) for the cells that hold both the node at `a` and that at a + step, in the order of their
/// index; cell (i, j, l) has node (i, j, l) at its corner of least coordinates. `nodes`: of the grid along each axis.
template <class Visit>
void for_each_cell_around(const std::array<int, 3>& nodes, const std::array<int, 3>& a, const std::array<int, 3>& step,
                          Visit visit) {
  std::array<int, 3> low{};
  std::array<int, 3> high{};
  for (std::size_t n = 0; n < 3; ++n) {
    low[n] = std::max(step[n] == 1 ? a[n] : a[n] - 1, 0);
    high[n] = std::min(step[n] == -1 ? a[n] - 1 : a[n], nodes[n] - 2);
  }
  for (int l = low[2]; l <= high[2]; ++l) {
    for (int j = low[1]; j <= high[1]; ++j) {
      for (int i = low[0]; i <= high[0]; ++i) { visit(i, j, l); }
    }
  }
}

}  // namespace palpate
