// SPDX-License-Identifier: MIT
#include "model/dynamics/mesh_tissue.hpp"

#include <cmath>
#include <numeric>

#include "model/dynamics/grid_network.hpp"
#include "model/dynamics/rules.hpp"
#include "model/dynamics/voxel_materials.hpp"

namespace palpate {

namespace {

using Eigen::Vector3d;

constexpr double most_boxes = 1e8;  // in the box around all bodies

struct Bounds {
  Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity());
  Vector3d high = -low;

  void include(const Vector3d& a, const Vector3d& b) {
    low = low.cwiseMin(a);
    high = high.cwiseMax(b);
  }
};

class MeshVoxels {
 public:
  MeshVoxels(const std::vector<MeshBody>& bodies, const MeshSettings& settings,
             const std::vector<Material>& materials, std::vector<Violation>& broken)
      : bodies_(bodies), settings_(settings), materials_(materials), broken_(broken) {}

  VoxelTissue run() {
    check_surfaces();
    if (!broken_.empty() || !lay_grid()) { return {}; }
    fill_surround();
    fill_bodies();
    if (!broken_.empty()) { return {}; }
    tissue_.materials = materials_.names();
    number_nodes();
    make_network();
    return std::move(tissue_);
  }

 private:
  void check_surfaces() {
    if (bodies_.empty()) { broken_.push_back({"tissue.mesh.files", "is missing; at least one file is needed"}); }
    for (const MeshBody& body : bodies_) {
      if (const auto defect = surface_defect(body.surface)) {
        broken_.push_back({body.key + ".path", body.name + ": " + *defect});
      }
    }
  }

  bool lay_grid() {
    Bounds bounds;
    for (const MeshBody& body : bodies_) {
      bounds.include(body.surface.vertex.rowwise().minCoeff(), body.surface.vertex.rowwise().maxCoeff());
    }
    if (settings_.surround) { bounds.include(settings_.surround->min, settings_.surround->max); }
    const double boxes = ((bounds.high - bounds.low) / settings_.voxel).array().ceil().max(1.0).prod();
    if (!(boxes <= most_boxes)) {
      broken_.push_back({"tissue.mesh.voxel", number_in_words(settings_.voxel) + " m; makes " +
                                                  number_in_words(boxes) + " voxels around the bodies of " +
                                                  number_in_words((bounds.high - bounds.low).maxCoeff()) +
                                                  " m; at most 1e8"});
      return false;
    }
    tissue_.boxes = cubes_around(bounds.low, bounds.high, settings_.voxel);
    tissue_.material.assign(tissue_.boxes.box_count(), 0);
    owner_.assign(tissue_.boxes.box_count(), -1);
    return true;
  }

  void fill_surround() {
    if (!settings_.surround) { return; }
    const Surround& s = *settings_.surround;
    const std::uint16_t code = materials_.code_of(s.material, "tissue.mesh.surround.material", broken_);
    const BoxGrid& grid = tissue_.boxes;
    for (int l = 0; l < grid.count[2]; ++l) {
      for (int j = 0; j < grid.count[1]; ++j) {
        for (int i = 0; i < grid.count[0]; ++i) {
          const Vector3d centre = grid.low + grid.size.cwiseProduct(Vector3d(i + 0.5, j + 0.5, l + 0.5));
          const bool inside = (centre - s.min).minCoeff() > 0.0 && (s.max - centre).minCoeff() > 0.0;
          if (inside) { tissue_.material[grid.index(i, j, l)] = code; }
        }
      }
    }
  }

  void fill_bodies() {
    std::vector<std::size_t> order(bodies_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, [&](std::size_t n) { return bodies_[n].priority; });
    tissue_.bodies.resize(bodies_.size());
    for (const std::size_t n : order) { fill_body(n); }
    for (const int owner : owner_) {
      if (owner >= 0) { ++tissue_.bodies[static_cast<std::size_t>(owner)].kept_cells; }
    }
  }

  void fill_body(std::size_t n) {
    const MeshBody& body = bodies_[n];
    const std::uint16_t code = materials_.code_of(body.material, body.key + ".material", broken_);
    const VoxelBody voxels = voxelise(body.surface, tissue_.boxes);
    tissue_.bodies[n] = {.name = body.name,
                         .material = body.material,
                         .surface_volume = moments_of(body.surface).volume,
                         .voxel_volume = voxels.volume,
                         .parts = voxels.parts};
    if (voxels.voxel_count == 0) {
      broken_.push_back({"tissue.mesh.voxel", number_in_words(settings_.voxel) + " m; no voxel's centre is inside " +
                                                  body.name + ", which is thinner; must be smaller"});
    }
    for (std::size_t box = 0; box < voxels.inside.size(); ++box) {
      if (voxels.inside[box] == 0) { continue; }
      tissue_.material[box] = code;
      owner_[box] = static_cast<int>(n);
    }
  }

  void number_nodes() {
    const BoxGrid& boxes = tissue_.boxes;
    NodeGrid& nodes = tissue_.nodes;
    nodes.first = boxes.low;
    nodes.spacing = boxes.size;
    nodes.count = {boxes.count[0] + 1, boxes.count[1] + 1, boxes.count[2] + 1};
    nodes.node.assign(nodes.index(0, 0, nodes.count[2]), -1);
    for (int l = 0; l < boxes.count[2]; ++l) {
      for (int j = 0; j < boxes.count[1]; ++j) {
        for (int i = 0; i < boxes.count[0]; ++i) {
          if (tissue_.material[boxes.index(i, j, l)] == 0) { continue; }
          for (int corner = 0; corner < 8; ++corner) {
            nodes.node[nodes.index(i + (corner & 1), j + ((corner >> 1) & 1), l + (corner >> 2))] = 0;
          }
        }
      }
    }
    palpate::number_nodes(nodes);
  }

  void make_network() {
    const BoxGrid& boxes = tissue_.boxes;
    tissue_.network = grid_network(tissue_.nodes, settings_.connectivity,
                                   [&](int i, int j, int l, int, int) -> const CellMaterial* {
                                     const std::uint16_t code = tissue_.material[boxes.index(i, j, l)];
                                     return code == 0 ? nullptr : &materials_.cell(code);
                                   });
    grid::for_each_node(tissue_.nodes, [&](const std::array<int, 3>& at, int node) {
      for_each_cell_around(tissue_.nodes.count, at, {0, 0, 0}, [&](int i, int j, int l) {
        const std::size_t box = boxes.index(i, j, l);
        const bool held = owner_[box] >= 0 && bodies_[static_cast<std::size_t>(owner_[box])].fixed;
        if (held || materials_.bone(tissue_.material[box])) {
          tissue_.network.fixed[static_cast<std::size_t>(node)] = 1;
        }
      });
    });
  }

  const std::vector<MeshBody>& bodies_;
  const MeshSettings& settings_;
  VoxelMaterials materials_;
  std::vector<Violation>& broken_;
  VoxelTissue tissue_{};
  std::vector<int> owner_{};  ///< body that has the box, -1: none
};

}  // namespace

void place_in_tissue(TriangleSurface& surface, double scale, FileAxis inward, const Vector3d& origin) {
  surface.vertex = axis_map(inward).matrix() * ((scale * surface.vertex).colwise() - origin);
}

VoxelTissue mesh_tissue(const std::vector<MeshBody>& bodies, const MeshSettings& settings,
                        const std::vector<Material>& materials, std::vector<Violation>& broken) {
  return MeshVoxels(bodies, settings, materials, broken).run();
}

}  // namespace palpate
