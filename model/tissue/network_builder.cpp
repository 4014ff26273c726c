// SPDX-License-Identifier: MIT

#include "model/tissue/network_builder.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "model/problem/problem.hpp"
#include "model/tissue/lattice.hpp"
#include "model/tissue/tissue_grid.hpp"
#include "model/tissue/voxel_tissue.hpp"

namespace palpate {

namespace {

SpringNetwork build_cells(const Scene& scene, const LatticeShape& shape) {
  return cell_lattice(shape, [&](int i, int j, int l) {
    return cell_material(
        scene,
        {.low = shape.position(i, j, l), .size = shape.spacing, .bottom = shape.spacing * (l + 1)});
  });
}

SpringNetwork build_uneven(const Scene& scene) {
  const UnevenBlock block = uneven_block(scene);
  const NodeGrid& nodes = block.nodes;
  std::vector<std::optional<CellMaterial>> cells(nodes.node.size());
  for_each_place(cells_of(nodes.count), [&](int i, int j, int l) {
    if (!block.holds(i, j, l)) { return; }
    cells[nodes.index(i, j, l)] = cell_material(scene, {.low = nodes.place(i, j, l),
                                                        .size = nodes.spacing.z(),
                                                        .bottom = nodes.place(i, j, l + 1).z()});
  });
  return grid_network(nodes, scene.tissue.block.connectivity, [&](int i, int j, int l, int, int) {
    const std::optional<CellMaterial>& cell = cells[nodes.index(i, j, l)];
    return cell ? &*cell : nullptr;
  });
}

SpringNetwork build_lattice(const Scene& scene) {
  const Lattice& lattice = scene.tissue.lattice;
  const LatticeShape shape{lattice.nodes, lattice.spacing, lattice.connectivity};
  if (lattice.weights == LatticeWeights::uniform) {
    return uniform_lattice(shape, lattice.stiffness, lattice.viscosity, lattice.node_mass);
  }
  return build_cells(scene, shape);
}

void hold_faces(const Tissue& tissue, SpringNetwork& network) {
  const std::vector<Face> fallback =
      tissue.source == Source::network ? std::vector<Face>{} : std::vector<Face>{Face::z_max};
  std::set<int> held;
  for (const Face face : tissue.fixed.value_or(fallback)) {
    const std::vector<int> nodes = face_nodes(network.rest_position, face);
    held.insert(nodes.begin(), nodes.end());
  }
  for (const int node : held) {
    if (tissue.hold_by_mass) {
      network.mass(node) *= tissue.heavy_mass_factor;
    } else {
      network.fixed[static_cast<std::size_t>(node)] = 1;
    }
  }
}

void hold_bone(const Scene& scene, SpringNetwork& network) {
  if (scene.tissue.voxels || !has_bone(scene)) { return; }  // the bone of voxels is already fixed
  for (Eigen::Index i = 0; i < network.node_count(); ++i) {
    if (in_bone(scene, network.rest_position.col(i))) {
      network.fixed[static_cast<std::size_t>(i)] = 1;
    }
  }
}

SpringNetwork unheld_network(const Scene& scene) {
  if (scene.tissue.source == Source::lattice) { return build_lattice(scene); }
  if (layers_are_uneven(scene)) { return build_uneven(scene); }
  if (scene.tissue.source == Source::layers) { return build_cells(scene, block_shape(scene)); }
  if (scene.tissue.voxels) { return scene.tissue.voxels->network; }
  SpringNetwork network = scene.tissue.network;
  recognise_lattice(network);
  return network;
}

}  // namespace

BondStiffness bond_stiffness(double youngs_modulus, double spacing, int connectivity) {
  const double ea = youngs_modulus * spacing;
  if (connectivity == 6) { return {ea, 0.0, 0.0}; }              // C11 = k1 / a, no shear
  if (connectivity == 18) { return {ea / 2.5, ea / 2.5, 0.0}; }  // isotropic: k1 = k2
  return {2.0 * ea / 3.75, ea / 3.75, 0.375 * ea / 3.75};        // k1 = 2 k2, k3 = 3/8 k2
}

Eigen::Index layered_node_count(const Scene& scene) {
  if (!layers_are_uneven(scene)) { return block_shape(scene).node_count(); }
  return std::ranges::count_if(uneven_block(scene).nodes.node, [](int node) { return node >= 0; });
}

SpringNetwork build_network(const Scene& scene) {
  SpringNetwork network = unheld_network(scene);
  hold_faces(scene.tissue, network);
  hold_bone(scene, network);
  return network;
}

std::unique_ptr<Problem> make_problem(const Scene& scene) {
  if (scene.tissue.source == Source::oscillator) {
    return std::make_unique<OscillatorProblem>(scene.tissue.oscillator);
  }
  SpringNetwork network = build_network(scene);
  std::vector<Load> loads = resolve_loads(scene, network);
  return std::make_unique<NetworkProblem>(std::move(network), std::move(loads),
                                          scene.tissue.gravity, scene.simulation.printed);
}

}  // namespace palpate
