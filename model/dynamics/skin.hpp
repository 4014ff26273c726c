// SPDX-License-Identifier: MIT
#pragma once
/// The skin of a body as a surface of triangles, open or closed: how deep a place lies beneath it
/// (model/EQUATIONS.md, "Layers beneath a skin").

#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "model/dynamics/triangle_surface.hpp"

namespace palpate {

class Skin {
 public:
  /// In the tissue's frame. The surface must have passed skin_defect. `shapes_layers`: the layers of a block
  /// follow it, else it is carried along and no more.
  Skin(TriangleSurface surface, bool shapes_layers);
  ~Skin();

  [[nodiscard]] const TriangleSurface& surface() const;
  [[nodiscard]] bool shapes_layers() const;

  /// Where a line along +z is beneath the surface: from where it first meets it to where it meets it again, which
  /// for an open surface is nowhere [m]. Nothing where it misses it.
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

}  // namespace palpate
