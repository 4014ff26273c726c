// SPDX-License-Identifier: MIT
#pragma once
/// Tissue from closed surfaces, one material each (model/EQUATIONS.md, "Voxels of a surface").

#include <optional>
#include <string>
#include <vector>

#include "model/dynamics/file_axis.hpp"
#include "model/dynamics/scene_check.hpp"
#include "model/dynamics/voxel_tissue.hpp"

namespace palpate {

/// Soft tissue in a box of the tissue frame, wherever no body is.
struct Surround {
  std::string material{};
  Eigen::Vector3d min{0.0, 0.0, 0.0};  ///< [m]
  Eigen::Vector3d max{0.0, 0.0, 0.0};  ///< [m]
};

struct MeshSettings {
  double voxel = 0.002;  ///< edge of a voxel [m]
  int connectivity = 26;
  FileAxis inward = FileAxis::z_plus;     ///< of the files; points into the tissue
  Eigen::Vector3d origin{0.0, 0.0, 0.0};  ///< of the files, after scaling, that becomes [0, 0, 0] [m]
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
void place_in_tissue(TriangleSurface& surface, double scale, FileAxis inward, const Eigen::Vector3d& origin);

/// Voxels are the cells of a lattice with a node at each corner. Bodies whose voxels touch share the nodes
/// between them and so are joined; a gap of a voxel or more keeps them apart. Nodes of bone and of fixed
/// bodies are fixed. What forbids it goes to `broken`, and then the tissue is of no use.
VoxelTissue mesh_tissue(const std::vector<MeshBody>& bodies, const MeshSettings& settings,
                        const std::vector<Material>& materials, std::vector<Violation>& broken);

}  // namespace palpate
