// SPDX-License-Identifier: MIT
#pragma once
/// Skin of a body as an open or closed surface of triangles, and the depth of points below it
/// (model/EQUATIONS.md, "Layers beneath a skin").

#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/problem/spring_network.hpp"
#include "model/tissue/tissue_grid.hpp"
#include "model/tissue/triangle_surface.hpp"

namespace palpate {

class Skin {
 public:
  /// Builds the skin from a surface in the tissue frame that has passed skin_defect. With
  /// `shapes_layers` the layers of a block follow it; otherwise it is only embedded in the tissue.
  Skin(TriangleSurface surface, bool shapes_layers);
  ~Skin();

  [[nodiscard]] const TriangleSurface& surface() const;
  [[nodiscard]] bool shapes_layers() const;

  /// Interval [m] of a line along +z below the surface, from its first to its second intersection;
  /// it is unbounded below a single sheet. Empty if the line does not intersect the surface.
  struct Stretch {
    double top = 0.0;
    double bottom = std::numeric_limits<double>::infinity();
    bool between_sheets =
        false;  ///< an end is on an open surface: the end of the tissue is unknown
  };
  [[nodiscard]] std::optional<Stretch> beneath(double x, double y) const;
  /// Returns the distance from a point to the nearest point of the surface [m].
  [[nodiscard]] double distance(const Eigen::Vector3d& point) const;
  /// Returns the distance [m], negative outside of these intervals.
  [[nodiscard]] double depth(const Eigen::Vector3d& point) const;

 private:
  struct Parts;
  std::unique_ptr<const Parts> parts_;
};

/// Returns the reason why a surface cannot be a skin: no faces, a missing vertex, or coordinates
/// that are not finite or exceed 10 m (usually a file in other units). Empty for a valid surface.
std::optional<std::string> skin_defect(const TriangleSurface& surface);

/// Surface point that moves with the weighted mean of four nodes (model/EQUATIONS.md, "A surface in
/// the tissue").
struct EmbeddedPoint {
  std::array<int, 4> node{-1, -1, -1, -1};  ///< -1: too far from the tissue, does not move
  std::array<double, 4> weight{};           ///< barycentric: >= 0, sum to one

  [[nodiscard]] bool follows() const { return node[0] >= 0; }
};

/// Embeds points in cells with eight existing nodes. A point outside, but within `reach` spacings
/// of a cell, uses the nearest position in the nearest cell.
std::vector<EmbeddedPoint> embed(const NodeVectors& points, const NodeGrid& grid, int reach = 2);

/// Returns the points after the nodes have moved from `rest` to `position` [m].
NodeVectors carried(const NodeVectors& points, const std::vector<EmbeddedPoint>& embedded,
                    const NodeVectors& rest, const NodeVectors& position);

}  // namespace palpate
