// SPDX-License-Identifier: MIT
#pragma once
/// Tissue from closed surfaces and images, as boxes of material (model/EQUATIONS.md, "Voxels of a
/// surface", "Image to stiffness").

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "model/problem/needle_path.hpp"
#include "model/tissue/file_axis.hpp"
#include "model/tissue/scene_check.hpp"
#include "model/tissue/tissue_grid.hpp"
#include "model/tissue/triangle_surface.hpp"

namespace palpate {

/// Grid of boxes of one size, stored along x, then y, then z.
struct BoxGrid {
  Eigen::Vector3d low{0.0, 0.0, 0.0};   ///< corner of least coordinates of box (0, 0, 0) [m]
  Eigen::Vector3d size{0.0, 0.0, 0.0};  ///< edges of a box [m]
  std::array<int, 3> count{0, 0, 0};

  [[nodiscard]] std::size_t box_count() const {
    return static_cast<std::size_t>(count[0]) * static_cast<std::size_t>(count[1]) *
           static_cast<std::size_t>(count[2]);
  }
  [[nodiscard]] std::size_t index(int i, int j, int l) const { return grid_index(count, i, j, l); }
  [[nodiscard]] bool holds(int i, int j, int l) const {
    return i >= 0 && j >= 0 && l >= 0 && i < count[0] && j < count[1] && l < count[2];
  }
  [[nodiscard]] double volume() const { return size.prod(); }  ///< of one box [m^3]
};

/// Returns cubes that cover the points, with corners at integer multiples of `edge` [m].
BoxGrid cubes_around(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double edge);

struct VoxelBody {
  std::vector<std::uint8_t> inside{};  ///< per box of the grid; 1: its centre is inside the surface
  std::size_t voxel_count = 0;
  int parts = 0;        ///< number of components that are not connected by 26 neighbours
  double volume = 0.0;  ///< of the voxels [m^3]
};

/// Returns the cells whose centre is inside a surface that has passed surface_defect, by the
/// winding number of the crossings before the centre. Side tests use exact integers in units of
/// 2^-n voxels, so that a row through a vertex or along an edge counts it once.
VoxelBody voxelise(const TriangleSurface& surface, const BoxGrid& grid);

/// Voxelisation report of one surface.
struct BodyFacts {
  std::string name{};
  std::string material{};
  double surface_volume = 0.0;  ///< by the divergence theorem [m^3]
  double voxel_volume = 0.0;    ///< of all its cells, including those that other bodies take [m^3]
  std::size_t kept_cells = 0;   ///< cells that no body of higher priority takes
  int parts = 0;                ///< number of components that are not connected by 26 neighbours
};

/// Report of an image that was read.
struct ImageFacts {
  std::string format{};
  std::array<int, 3> pixels{0, 0, 0};            ///< of the file
  Eigen::Vector3d spacing{0.0, 0.0, 0.0};        ///< of the file [m]
  Eigen::Vector2d range{0.0, 0.0};               ///< raw values that map to intensity 0 and 1
  Eigen::Vector3d youngs_moduli{1.0, 1.0, 1.0};  ///< BoxBonds::youngs_moduli()
  std::string weighting{};
  std::size_t labelled_nodes = 0;
  std::vector<int> unused_labels{};  ///< of tissue.mri.materials, which no node has
};

/// Patient-specific tissue: boxes of material on a grid, and the network of their corners or
/// centres. It is built once when a scene is read and shared by all copies of the scene.
struct VoxelTissue {
  SpringNetwork network{};  ///< nodes of bone and of fixed bodies are fixed
  NodeGrid nodes{};
  BoxGrid boxes{};
  std::vector<std::uint16_t> material{};  ///< per box: index into materials plus one; 0: empty
  std::vector<std::string> materials{};
  double thinnest = 0.0;              ///< thinner layers along a needle are treated as noise [m]
  std::vector<BodyFacts> bodies{};    ///< of meshes
  std::optional<ImageFacts> image{};  ///< of an image
  std::vector<float> intensity{};     ///< of an image, 0 to 1, per place of `nodes`
};

/// Returns the materials along the line origin + xi n from `first` on; the last one is unbounded.
/// Intervals thinner than `thinnest`, except bone, are merged into the layer before. Empty boxes
/// are labelled "gap"; one of up to two boxes at the skin is merged into the soft tissue after it.
std::vector<PathInterval> voxel_intervals(const VoxelTissue& tissue,
                                          const std::vector<Material>& materials,
                                          const Eigen::Vector3d& origin,
                                          const Eigen::Vector3d& direction, double first);

/// Codes of the materials of a voxel tissue; each material has one code.
class VoxelMaterials {
 public:
  explicit VoxelMaterials(const std::vector<Material>& known) : known_(known) {}

  /// Returns the code of a material; 0 with a violation of `key` for an unknown name.
  std::uint16_t code_of(const std::string& name, const std::string& key,
                        std::vector<Violation>& broken) {
    const auto used = std::ranges::find(names_, name);
    if (used != names_.end()) { return static_cast<std::uint16_t>(used - names_.begin() + 1); }
    const Material* found = find_material(known_, name);
    if (found == nullptr) {
      broken.push_back({key, unknown_material(name, known_)});
      return 0;
    }
    names_.push_back(name);
    cells_.push_back({found->youngs_modulus, found->density, found->damping_ratio, found->viscosity,
                      found->poissons_ratio, found->retardation_time, law_of(*found)});
    bone_.push_back(role_of(*found) == TissueRole::bone);
    return static_cast<std::uint16_t>(names_.size());
  }
  [[nodiscard]] const CellMaterial& cell(std::uint16_t code) const { return cells_[code - 1U]; }
  [[nodiscard]] bool bone(std::uint16_t code) const { return code != 0 && bone_[code - 1U]; }
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }

 private:
  const std::vector<Material>& known_;
  std::vector<std::string> names_{};
  std::vector<CellMaterial> cells_{};
  std::vector<bool> bone_{};
};

/// Soft tissue that fills a box of the tissue frame outside all bodies.
struct Surround {
  std::string material{};
  Eigen::Vector3d min{0.0, 0.0, 0.0};  ///< [m]
  Eigen::Vector3d max{0.0, 0.0, 0.0};  ///< [m]
};

struct MeshSettings {
  double voxel = 0.002;  ///< edge of a voxel [m]
  int connectivity = 26;
  FileAxis inward = FileAxis::z_plus;     ///< direction of the files that points into the tissue
  Eigen::Vector3d origin{0.0, 0.0, 0.0};  ///< point of the scaled files that becomes 0 [m]
  std::optional<Surround> surround{};
};

/// A surface in the tissue frame.
struct MeshBody {
  std::string name{};  ///< name of its file
  std::string key{};   ///< scene key for messages, e.g. "tissue.mesh.files[0]"
  TriangleSurface surface{};
  std::string material{};
  bool fixed = false;
  int priority = 0;  ///< a cell belongs to the body of highest priority, or to the last of equals
};

/// Transforms the vertices of a file to the tissue frame; `scale` is in metres per unit.
void place_in_tissue(TriangleSurface& surface, double scale, FileAxis inward,
                     const Eigen::Vector3d& origin);

/// Builds the tissue: a node at each corner of a voxel. Bodies with touching voxels share nodes.
/// Nodes of bone and of fixed bodies are fixed. Adds violations to `broken` if the input is not
/// valid; the result must not be used then.
VoxelTissue mesh_tissue(const std::vector<MeshBody>& bodies, const MeshSettings& settings,
                        const std::vector<Material>& materials, std::vector<Violation>& broken);

}  // namespace palpate
