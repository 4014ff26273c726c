// SPDX-License-Identifier: MIT
#pragma once
/// From a Scene to the SpringNetwork that is simulated (model/EQUATIONS.md, "Material to springs").

#include "model/problem/scene.hpp"

namespace palpate {

/// Stiffness of the edges (k1), face diagonals (k2) and body diagonals (k3) of a cubic lattice
/// whose homogenised Young's modulus is E. 26 and 18 neighbours are isotropic with Poisson's ratio
/// 1/4; 6 neighbours resist only along the axes. E [Pa], a [m], results [N/m].
struct BondStiffness {
  double edge = 0.0;
  double face_diagonal = 0.0;
  double body_diagonal = 0.0;
};
BondStiffness bond_stiffness(double youngs_modulus, double spacing, int connectivity);

/// The network of any source but the oscillator, with the scene's faces fixed (or made heavy)
/// and the nodes in bone fixed (tissue_map.hpp).
/// The scene must have passed check_scene.
SpringNetwork build_network(const Scene& scene);

/// Nodes that build_network makes of a scene with source = layers, without building it.
Eigen::Index layered_node_count(const Scene& scene);

}  // namespace palpate
