// SPDX-License-Identifier: MIT
#pragma once
/// The skin of a body as a surface of triangles, open or closed: how deep a place lies beneath it
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
  /// In the tissue's frame. The surface must have passed skin_defect. `shapes_layers`: the layers
  /// of a block follow it, else it is carried along and no more.
  Skin(TriangleSurface surface, bool shapes_layers);
  ~Skin();

  [[nodiscard]] const TriangleSurface& surface() const;
  [[nodiscard]] bool shapes_layers() const;

  /// Where a line along +z is beneath the surface: from where it first meets it to where it meets
  /// it again, which for an open surface is nowhere [m]. Nothing where it misses it.
  struct Stretch {
    double top = 0.0;
    double bottom = std::numeric_limits<double>::infinity();
  };
  [[nodiscard]] std::optional<Stretch> beneath(double x, double y) const;
  /// From a point to the nearest place of the surface [m].
  [[nodiscard]] double distance(const Eigen::Vector3d& point) const;
  /// The distance, negative outside of those stretches.
  [[nodiscard]] double depth(const Eigen::Vector3d& point) const;

 private:
  struct Parts;
  std::unique_ptr<const Parts> parts_;
};

/// What forbids a surface as skin, in words: no faces, coordinates that are not finite or beyond
/// 10 m, as of a file in other units, a missing vertex.
std::optional<std::string> skin_defect(const TriangleSurface& surface);

// Points of a surface that a tissue carries along (model/EQUATIONS.md, "A surface in the tissue").

/// A point moves by the weighted mean of what four nodes move by.
struct EmbeddedPoint {
  std::array<int, 4> node{-1, -1, -1,
                          -1};     ///< of the network; -1: the point lies too far off and stays
  std::array<double, 4> weight{};  ///< barycentric in a tetrahedron of its cell: >= 0, sum to one

  [[nodiscard]] bool follows() const { return node[0] >= 0; }
};

/// Points in a cell of tissue, one whose eight nodes exist, by their place in it; those outside,
/// but within `reach` spacings of a cell, by the place of the nearest cell that is nearest to them.
std::vector<EmbeddedPoint> embed(const NodeVectors& points, const NodeGrid& grid, int reach = 2);

/// Where the points are when the nodes have moved from `rest` to `position` [m].
NodeVectors carried(const NodeVectors& points, const std::vector<EmbeddedPoint>& embedded,
                    const NodeVectors& rest, const NodeVectors& position);

}  // namespace palpate
