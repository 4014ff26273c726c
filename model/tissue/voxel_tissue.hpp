// SPDX-License-Identifier: MIT
#pragma once
/// From a closed surface to the cubic cells inside it (model/EQUATIONS.md, "Voxels of a surface").

#include <Eigen/Core>
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

/// Boxes of one size in rows along x, then y, then z.
struct BoxGrid {
  Eigen::Vector3d low{0.0, 0.0, 0.0};   ///< corner of least coordinates of box (0, 0, 0) [m]
  Eigen::Vector3d size{0.0, 0.0, 0.0};  ///< edges of a box [m]
  std::array<int, 3> count{0, 0, 0};

  [[nodiscard]] std::size_t box_count() const {
    return static_cast<std::size_t>(count[0]) * static_cast<std::size_t>(count[1]) *
           static_cast<std::size_t>(count[2]);
  }
  [[nodiscard]] std::size_t index(int i, int j, int l) const {
    return (static_cast<std::size_t>(l) * static_cast<std::size_t>(count[1]) +
            static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(count[0]) +
           static_cast<std::size_t>(i);
  }
  [[nodiscard]] bool holds(int i, int j, int l) const {
    return i >= 0 && j >= 0 && l >= 0 && i < count[0] && j < count[1] && l < count[2];
  }
  [[nodiscard]] double volume() const { return size.prod(); }  ///< of one box [m^3]
};

/// Cubes with corners at whole multiples of `edge` [m] that cover the points.
BoxGrid cubes_around(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double edge);

struct VoxelBody {
  std::vector<std::uint8_t> inside{};  ///< per box of the grid; 1: its centre is inside the surface
  std::size_t voxel_count = 0;
  int parts = 0;        ///< that growth over 26 neighbours does not join
  double volume = 0.0;  ///< of the voxels [m^3]
};

/// The cells whose centre lies inside. Whether it does is decided row by row with the winding
/// number of the crossings before it, whose sides are exact in whole numbers of a voxel's 2^-n, so
/// that a row through a vertex or along an edge counts it once. The cells are then grown from a
/// seed, the first cell so proved inside, over 26 neighbours, and from another seed as long as
/// there are any left. The surface must have passed surface_defect.
VoxelBody voxelise(const TriangleSurface& surface, const BoxGrid& grid);

/// Volume, centroid and inertia of the cells, each a homogeneous cube.
SolidMoments moments_of(const VoxelBody& body, const BoxGrid& grid);

// Tissue from a patient: boxes of material on a grid, and the network of their corners or centres
// (model/EQUATIONS.md, "Voxels of a surface", "Image to stiffness"). Built once when a scene is
// read (mesh_tissue.hpp, image_tissue.hpp) and shared by every copy of the scene.

/// What became of one surface.
struct BodyFacts {
  std::string name{};
  std::string material{};
  double surface_volume = 0.0;  ///< by the divergence theorem [m^3]
  double voxel_volume = 0.0;    ///< of its own cells, before others take some [m^3]
  std::size_t kept_cells = 0;   ///< that no body of higher priority took
  int parts = 0;                ///< that growth over 26 neighbours does not join
};

/// What was read from an image, for people.
struct ImageFacts {
  std::string format{};
  std::array<int, 3> pixels{0, 0, 0};            ///< of the file
  Eigen::Vector3d spacing{0.0, 0.0, 0.0};        ///< of the file [m]
  Eigen::Vector2d range{0.0, 0.0};               ///< intensities that stand for 0 and 1
  Eigen::Vector3d youngs_moduli{1.0, 1.0, 1.0};  ///< BoxBonds::youngs_moduli()
  std::string weighting{};
  std::size_t labelled_nodes = 0;
};

struct VoxelTissue {
  SpringNetwork network{};  ///< bone and bodies said to be fixed are
  NodeGrid nodes{};
  BoxGrid boxes{};
  std::vector<std::uint16_t>
      material{};  ///< per box; 0: nothing, else one more than an index of materials
  std::vector<std::string> materials{};
  double thinnest = 0.0;              ///< layers thinner than this along a needle are noise [m]
  std::vector<BodyFacts> bodies{};    ///< of meshes
  std::optional<ImageFacts> image{};  ///< of an image
  std::vector<float> intensity{};     ///< of an image, 0 to 1, per place of `nodes`
};

/// Materials of the boxes that the line origin + xi n crosses from `first` on, the last for ever.
/// What is thinner than `thinnest`, bone excepted, belongs to the layer before it; nothing is
/// labelled "gap". At the skin a gap of up to two boxes belongs to the soft tissue after it.
std::vector<PathInterval> voxel_intervals(const VoxelTissue& tissue,
                                          const std::vector<Material>& materials,
                                          const Eigen::Vector3d& origin,
                                          const Eigen::Vector3d& direction, double first);

// Tissue from closed surfaces, one material each (model/EQUATIONS.md, "Voxels of a surface").

/// Soft tissue in a box of the tissue frame, wherever no body is.
struct Surround {
  std::string material{};
  Eigen::Vector3d min{0.0, 0.0, 0.0};  ///< [m]
  Eigen::Vector3d max{0.0, 0.0, 0.0};  ///< [m]
};

struct MeshSettings {
  double voxel = 0.002;  ///< edge of a voxel [m]
  int connectivity = 26;
  FileAxis inward = FileAxis::z_plus;  ///< of the files; points into the tissue
  Eigen::Vector3d origin{0.0, 0.0,
                         0.0};  ///< of the files, after scaling, that becomes [0, 0, 0] [m]
  std::optional<Surround> surround{};
};

/// A surface in the tissue frame.
struct MeshBody {
  std::string name{};  ///< of its file
  std::string key{};   ///< "tissue.mesh.files[0]", for what is wrong with it
  TriangleSurface surface{};
  std::string material{};
  bool fixed = false;
  int priority = 0;  ///< the highest has the cell; of equals the last
};

/// A file's vertices in the tissue frame; `scale` is metres per unit of the file,
/// and `inward` and `origin` as in MeshSettings.
void place_in_tissue(TriangleSurface& surface, double scale, FileAxis inward,
                     const Eigen::Vector3d& origin);

/// Voxels are the cells of a lattice with a node at each corner. Bodies whose voxels touch share
/// the nodes between them and so are joined; a gap of a voxel or more keeps them apart. Nodes of
/// bone and of fixed bodies are fixed. What forbids it goes to `broken`, and then the tissue is of
/// no use.
VoxelTissue mesh_tissue(const std::vector<MeshBody>& bodies, const MeshSettings& settings,
                        const std::vector<Material>& materials, std::vector<Violation>& broken);

}  // namespace palpate
