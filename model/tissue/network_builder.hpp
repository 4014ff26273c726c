// SPDX-License-Identifier: MIT
#pragma once
/// Conversion of a Scene to the SpringNetwork that is simulated (model/EQUATIONS.md, "Material to
/// springs").

#include "model/problem/scene.hpp"

namespace palpate {

/// Stiffness of the edges (k1), face diagonals (k2) and body diagonals (k3) of a cubic lattice with
/// homogenised Young's modulus E. 26 and 18 neighbours are isotropic with Poisson's ratio 1/4; 6
/// neighbours have stiffness along the axes only. E [Pa], a [m], results [N/m].
struct BondStiffness {
  double edge = 0.0;
  double face_diagonal = 0.0;
  double body_diagonal = 0.0;
};
BondStiffness bond_stiffness(double youngs_modulus, double spacing, int connectivity);

/// Builds the network of any source except the oscillator. The scene's faces are fixed or made
/// heavy, and nodes in bone are fixed (tissue_grid.hpp). The scene must have passed check_scene.
SpringNetwork build_network(const Scene& scene);

/// Returns the number of nodes of a scene with source = layers, without building the network.
Eigen::Index layered_node_count(const Scene& scene);

}  // namespace palpate
