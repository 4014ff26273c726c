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
#include "model/dynamics/voxelise.hpp"

namespace palpate {

/// Nodes of the network on a regular grid, of which some places may be empty.
struct NodeGrid {
  Eigen::Vector3d first{0.0, 0.0, 0.0};    ///< place of node (0, 0, 0) [m]
  Eigen::Vector3d spacing{0.0, 0.0, 0.0};  ///< [m]
  std::array<int, 3> count{0, 0, 0};
  std::vector<int> node{};  ///< of the network, x fastest; -1: no node there

  [[nodiscard]] std::size_t index(int i, int j, int l) const {
    return (static_cast<std::size_t>(l) * static_cast<std::size_t>(count[1]) + static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(count[0]) +
           static_cast<std::size_t>(i);
  }
  [[nodiscard]] int at(int i, int j, int l) const { return node[index(i, j, l)]; }
  [[nodiscard]] Eigen::Vector3d place(int i, int j, int l) const {
    return first + spacing.cwiseProduct(Eigen::Vector3d(i, j, l));
  }
};

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

/// Depth along z at which tissue begins beneath a place of the skin [m]; nothing where there is none.
std::optional<double> skin_depth(const VoxelTissue& tissue, const Eigen::Vector2d& at);

/// The nodes that have none above them in their column, in the order of their index.
std::vector<int> skin_nodes(const VoxelTissue& tissue);

/// Materials of the boxes that the line origin + xi n crosses from `first` on, the last for ever. What is
/// thinner than `thinnest`, bone excepted, belongs to the layer before it; nothing is labelled "gap".
std::vector<PathInterval> voxel_intervals(const VoxelTissue& tissue, const std::vector<Material>& materials,
                                          const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                          double first);

/// Where the line crosses the planes of nodes: depth, and the nodes around it with bilinear weights.
struct PlaneCrossing {
  double depth = 0.0;  ///< [m]
  std::vector<NeedlePath::Support> supports{};
};
std::vector<PlaneCrossing> plane_crossings(const NodeGrid& grid, const Eigen::Vector3d& origin,
                                           const Eigen::Vector3d& direction);

}  // namespace palpate
