// SPDX-License-Identifier: MIT
#include "reports/view_skin.hpp"

#include <Eigen/Geometry>

#include "model/dynamics/embedded_surface.hpp"
#include "model/dynamics/skin.hpp"
#include "model/dynamics/tissue_grid.hpp"
#include "reports/markup.hpp"

namespace palpate {

namespace {

Eigen::AlignedBox3d around(const NodeGrid& grid) {
  Eigen::AlignedBox3d box(grid.first, grid.place(grid.count[0] - 1, grid.count[1] - 1, grid.count[2] - 1));
  const Eigen::Vector3d room = Eigen::Vector3d::Constant(0.5 * box.diagonal().maxCoeff());
  return {box.min() - room, box.max() + room};
}

std::vector<std::array<int, 3>> faces_around(const TriangleSurface& surface, const Eigen::AlignedBox3d& box) {
  std::vector<std::array<int, 3>> faces;
  for (const auto& face : surface.triangle) {
    Eigen::AlignedBox3d around_face;
    for (const int vertex : face) { around_face.extend(Eigen::Vector3d(surface.vertex.col(vertex))); }
    if (box.intersects(around_face)) { faces.push_back(face); }
  }
  return faces;
}

}  // namespace

std::optional<ViewSurface> view_of_skin(const Scene& scene, std::vector<std::string>& notes) {
  const std::optional<NodeGrid> grid = scene.tissue.skin ? tissue_grid(scene) : std::nullopt;
  if (!grid) { return {}; }
  const TriangleSurface& surface = scene.tissue.skin->surface();
  ViewSurface skin{.label = "skin", .triangles = faces_around(surface, around(*grid))};
  const auto in_words = [](std::size_t count) { return short_number(static_cast<double>(count), 9); };
  if (skin.triangles.size() > most_faces_shown) {
    notes.push_back("the skin is not shown: " + in_words(skin.triangles.size()) +
                    " of its faces lie around the tissue, and a page takes " + in_words(most_faces_shown));
    return {};
  }
  if (skin.triangles.size() < surface.triangle.size()) {
    notes.push_back(in_words(skin.triangles.size()) + " of " + in_words(surface.triangle.size()) +
                    " faces of the skin are shown: those around the tissue");
  }
  std::vector<int> vertices;
  std::vector<int> number(static_cast<std::size_t>(surface.vertex.cols()), -1);
  for (auto& face : skin.triangles) {
    for (int& vertex : face) {
      int& own = number[static_cast<std::size_t>(vertex)];
      if (own < 0) {
        own = static_cast<int>(vertices.size());
        vertices.push_back(vertex);
      }
      vertex = own;
    }
  }
  skin.rest = surface.vertex(Eigen::all, vertices);
  for (const EmbeddedPoint& point : embed(skin.rest, *grid)) {
    std::vector<ViewSurface::Support>& supports = skin.vertices.emplace_back();
    for (std::size_t n = 0; point.follows() && n < point.node.size(); ++n) {
      if (point.weight[n] > 0.0) { supports.push_back({point.node[n], point.weight[n]}); }
    }
  }
  return skin;
}

}  // namespace palpate
