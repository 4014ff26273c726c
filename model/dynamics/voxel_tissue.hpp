// SPDX-License-Identifier: MIT
#pragma once
/// Tissue from a patient: boxes of material on a grid, and the network of their corners or centres
/// (model/EQUATIONS.md, "Voxels of a surface", "Image to stiffness"). Built once when a scene is read
/// (mesh_tissue.hpp, image_tissue.hpp) and shared by every copy of the scene.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "model/dynamics/needle_path.hpp"
#include "model/dynamics/node_grid.hpp"
#include "model/dynamics/voxelise.hpp"

namespace palpate {

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
  std::vector<std::uint16_t> material{};  ///< per box; 0: nothing, else one more than an index of materials
  std::vector<std::string> materials{};
  double thinnest = 0.0;              ///< layers thinner than this along a needle are noise [m]
  std::vector<BodyFacts> bodies{};    ///< of meshes
  std::optional<ImageFacts> image{};  ///< of an image
  std::vector<float> intensity{};     ///< of an image, 0 to 1, per place of `nodes`
};

/// Materials of the boxes that the line origin + xi n crosses from `first` on, the last for ever. What is
/// thinner than `thinnest`, bone excepted, belongs to the layer before it; nothing is labelled "gap". At the skin a
/// gap of up to two boxes belongs to the soft tissue after it.
std::vector<PathInterval> voxel_intervals(const VoxelTissue& tissue, const std::vector<Material>& materials,
                                          const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                          double first);

}  // namespace palpate
