// SPDX-License-Identifier: MIT
#pragma once
/// Sides of a view's cells behind the cut, as a picture of it shows them.

#include <array>
#include <cstddef>
#include <vector>

#include "reports/view.hpp"

namespace palpate {

struct ViewSide {
  std::array<int, 4> nodes{};
  int cell = 0;  ///< its lowest corner
};

/// Those towards +x, +y or -z. At most about `most`: whole squares of small sides become one.
std::vector<ViewSide> seen_sides(const View& view, std::size_t most);

}  // namespace palpate
