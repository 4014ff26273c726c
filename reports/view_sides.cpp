// SPDX-License-Identifier: MIT
#include "reports/view_sides.hpp"

#include <cmath>
#include <map>

namespace palpate {

namespace {

/// A side of `span` x `span` cells towards +x, +y or -z, which can be seen.
struct GridSide {
  std::size_t axis = 0;
  std::array<int, 3> place{};  ///< of the first cell
  int span = 1;
};

/// Sides of the cells behind the cut, by their places.
class SeenSides {
 public:
  explicit SeenSides(const View& view) : view_(view) {
    for (std::size_t n = 0; n < view.place.size(); ++n) { node_at_[view.place[n]] = static_cast<int>(n); }
    for (const auto& place : view.place) {
      for (std::size_t axis = 0; kept(place) && axis < 3; ++axis) {
        std::array<int, 3> next = place;
        next[axis] += axis == 2 ? -1 : 1;
        if (!kept(next)) { sides_.push_back({axis, place}); }
      }
    }
  }
  [[nodiscard]] std::vector<ViewSide> nodes(std::size_t most) const {
    const auto n =
        static_cast<int>(std::ceil(std::sqrt(static_cast<double>(sides_.size()) / static_cast<double>(most))));
    std::map<std::array<int, 4>, std::vector<GridSide>> squares;
    for (const GridSide& side : sides_) {
      std::array<int, 4> square{static_cast<int>(side.axis), 0, 0, 0};
      for (std::size_t c = 0; c < 3; ++c) { square[c + 1] = c == side.axis ? side.place[c] : side.place[c] / n * n; }
      squares[square].push_back(side);
    }
    std::vector<ViewSide> nodes;
    for (const auto& [square, sides] : squares) {
      if (sides.size() == static_cast<std::size_t>(n * n)) {
        nodes.push_back(corners({sides[0].axis, {square[1], square[2], square[3]}, n}));
      } else {
        for (const GridSide& side : sides) { nodes.push_back(corners(side)); }
      }
    }
    return nodes;
  }

 private:
  [[nodiscard]] bool kept(const std::array<int, 3>& place) const {
    const auto found = node_at_.find(place);
    if (found == node_at_.end() || view_.cell[static_cast<std::size_t>(found->second)] == 0) { return false; }
    const int opposite = node_at_.at({place[0] + 1, place[1] + 1, place[2] + 1});
    return 0.5 * (view_.rest(1, found->second) + view_.rest(1, opposite)) <= view_.cut;
  }
  [[nodiscard]] ViewSide corners(const GridSide& side) const {
    static constexpr std::array<std::array<int, 4>, 3> of_cell{{{1, 3, 7, 5}, {2, 6, 7, 3}, {0, 2, 3, 1}}};
    ViewSide result{.cell = node_at_.at(side.place)};
    for (std::size_t n = 0; n < 4; ++n) {
      std::array<int, 3> place = side.place;
      for (std::size_t c = 0; c < 3; ++c) {
        place[c] += (of_cell[side.axis][n] >> c & 1) * (c == side.axis ? 1 : side.span);
      }
      result.nodes[n] = node_at_.at(place);
    }
    return result;
  }

  const View& view_;
  std::map<std::array<int, 3>, int> node_at_;
  std::vector<GridSide> sides_;
};

}  // namespace

std::vector<ViewSide> seen_sides(const View& view, std::size_t most) { return SeenSides(view).nodes(most); }

}  // namespace palpate
