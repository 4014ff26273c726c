// SPDX-License-Identifier: MIT

#include "model/tissue/network_builder.hpp"

#include <algorithm>

#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate;

Material material(const char* name, double youngs_modulus, double density) {
  return {.name = name, .youngs_modulus = youngs_modulus, .density = density};
}

Scene cube_scene() {
  Scene scene;
  scene.materials = {material("soft", 1e3, 1000.0), material("hard", 1e5, 2000.0)};
  scene.tissue.lattice = {.nodes = {5, 5, 5}, .spacing = 0.01, .material = "soft"};
  return scene;
}

/// Two layers of 2 cells and 1.5 cells; the third and fourth cells are cut by nothing and halfway.
Scene layered_scene() {
  Scene scene = cube_scene();
  scene.tissue.source = Source::layers;
  scene.tissue.block = {.nodes = {3, 3}, .spacing = 0.01};
  scene.tissue.layers = {{"skin", "soft", 0.025}, {"bone", "hard", 0.015}};
  return scene;
}

auto fixed_nodes(const SpringNetwork& network) { return std::ranges::count(network.fixed, 1); }

/// Modulus from which the vertical spring below an inner node was computed: k1 = 2 E a / 3.75.
double modulus_below(const SpringNetwork& network, int node, int plane) {
  const auto found = std::ranges::find_if(
      network.springs, [&](const Spring& s) { return s.a == node && s.b == node + plane; });
  return (*found).stiffness * 3.75 / (2.0 * 0.01);
}

double mass_of_level(const SpringNetwork& network, double z) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < network.node_count(); ++i) {
    if (std::abs(network.rest_position(2, i) - z) < 1e-9) { sum += network.mass(i); }
  }
  return sum;
}

TEST("z-max is held when a scene says nothing, nothing in a network of files, else the faces") {
  Scene scene = cube_scene();
  const SpringNetwork network = build_network(scene);
  for (int i = 0; i < network.node_count(); ++i) { CHECK(network.is_fixed(i) == (i >= 100)); }
  Scene files = scene;
  files.tissue.source = Source::network;
  files.tissue.network = network;
  files.tissue.network.fixed.assign(125, 0);
  CHECK(fixed_nodes(build_network(files)) == 0);
  scene.tissue.fixed = std::vector<Face>{};
  CHECK(fixed_nodes(build_network(scene)) == 0);
  scene.tissue.fixed = std::vector<Face>{Face::x_min, Face::x_max, Face::y_min};
  CHECK(fixed_nodes(build_network(scene)) == 25 + 25 + 25 - 5 - 5);
}

TEST("a face held by mass is a million times heavier and not fixed") {
  Scene scene = cube_scene();
  const double light = build_network(scene).mass(112);
  scene.tissue.hold_by_mass = true;
  const SpringNetwork network = build_network(scene);
  CHECK(!network.is_fixed(112));
  CHECK_NEAR(network.mass(112), 1e6 * light, 1e-9);
}

TEST("every face of a cube has its n^2 nodes at the extreme coordinate") {
  const SpringNetwork network = build_network(cube_scene());
  for (int face = 0; face < 6; ++face) {
    const std::vector<int> nodes = face_nodes(network.rest_position, static_cast<Face>(face));
    CHECK(nodes.size() == 25);
    const int axis = face / 2;
    const auto row = network.rest_position.row(axis);
    const double extreme = face % 2 == 1 ? row.maxCoeff() : row.minCoeff();
    for (const int node : nodes) { CHECK_NEAR(network.rest_position(axis, node), extreme, 1e-15); }
  }
}

TEST("a load on a face acts on the face's nodes") {
  Scene scene = cube_scene();
  scene.loads.push_back({.face = Face::z_min, .force = {0.0, 0.0, 1.0}});
  const SpringNetwork network = build_network(scene);
  const std::vector<Load> loads = resolve_loads(scene, network);
  REQUIRE(loads.size() == 1);
  CHECK(!loads[0].face);
  CHECK(loads[0].nodes == face_nodes(network.rest_position, Face::z_min));
}

TEST("a record of a point is the nearest node, the lowest index of equals") {
  const SpringNetwork network = build_network(cube_scene());
  CHECK(record_node({"a", 17}, network) == 17);
  // x = 0.01 is nearer than 0
  CHECK(record_node({"b", Eigen::Vector3d(0.0051, -0.0001, 0.0)}, network) == 13);
  CHECK(record_node({"c", Eigen::Vector3d(0.005, 0.0, 0.0)}, network) == 12);  // halfway
}

TEST("a cell that straddles two layers takes their mean by its share of each") {
  const SpringNetwork network = build_network(layered_scene());
  CHECK(network.node_count() == 3 * 3 * 5);  // 40 mm: four cells
  const double cell = 4e-6 / 2.0;            // four cells a level, half to each side [m^3]
  CHECK_NEAR(mass_of_level(network, 0.0), cell * 1000.0, 1e-12);
  CHECK_NEAR(mass_of_level(network, 0.01), cell * 2000.0, 1e-12);
  CHECK_NEAR(mass_of_level(network, 0.02), cell * (1000.0 + 1500.0), 1e-12);
  CHECK_NEAR(mass_of_level(network, 0.03), cell * (1500.0 + 2000.0), 1e-12);
}

TEST("vertical springs of a layered block carry their own layer's stiffness") {
  const SpringNetwork network = build_network(layered_scene());
  CHECK_NEAR(modulus_below(network, 4, 9), 1e3, 1e-10);
  CHECK_NEAR(modulus_below(network, 4 + 18, 9), 0.5 * (1e3 + 1e5), 1e-7);
  CHECK_NEAR(modulus_below(network, 4 + 27, 9), 1e5, 1e-7);
}

TEST("a gap between layers has no nodes, springs or mass, and leaves its neighbours as they are") {
  Scene scene = layered_scene();
  scene.tissue.layers = {{"sheet", "soft", 0.01},
                         {.tissue = "air", .thickness = 0.022, .gap = true},
                         {"ground", "hard", 0.018}};
  const SpringNetwork network = build_network(scene);
  const int plane = 3 * 3;
  CHECK(network.node_count() == 2 * plane + 3 * plane);  // cells at 0, 30 and 40 mm
  CHECK(layered_node_count(scene) == network.node_count());
  const double cell = 4e-6 / 2.0;
  CHECK_NEAR(mass_of_level(network, 0.01), cell * 1000.0, 1e-12);
  CHECK_NEAR(mass_of_level(network, 0.02), 0.0, 0.0);
  CHECK_NEAR(mass_of_level(network, 0.03), cell * 2000.0, 1e-12);
  for (const Spring& spring : network.springs) {
    CHECK((spring.a < 2 * plane) == (spring.b < 2 * plane));
  }
  // The gap takes 2 mm of the cell from 30 to 40 mm and does not soften it.
  CHECK_NEAR(modulus_below(network, 2 * plane + 4, plane), 1e5, 1e-7);
  CHECK_NEAR(modulus_below(network, 4, plane), 1e3, 1e-10);
  scene.tissue.inclusions = {
      {.centre = {0.005, 0.005, 0.02}, .size = {0.015, 0.015, 0.015}, .material = "soft"}};
  // Two cells from 10 to 30 mm: four nodes at 20 mm are new.
  CHECK(build_network(scene).node_count() == network.node_count() + 4);
  scene.tissue.inclusions.clear();
  for (Material& each : scene.materials) { each.poissons_ratio = 0.45; }
  const std::vector<VolumeCell> cells = build_network(scene).cells;
  CHECK(cells.size() == 2 * 2 * 3);  // one of the sheet and two of the ground in each column
  for (const VolumeCell& volume : cells) {
    CHECK((volume.nodes[0] < 2 * plane) == (volume.nodes[7] < 2 * plane));
  }
}

TEST("the cells of an inclusion are of its material, and later inclusions win") {
  Scene scene = cube_scene();
  const Inclusion all{.shape = Inclusion::Shape::box,
                      .centre = {0.0, 0.0, 0.02},
                      .size = {1.0, 1.0, 1.0},
                      .material = "hard"};
  scene.tissue.inclusions = {all};
  CHECK_NEAR(build_network(scene).mass.sum(), 64e-6 * 2000.0, 1e-14);
  const Inclusion ball{
      .centre = {0.005, 0.005, 0.025}, .size = {0.011, 0.0, 0.0}, .material = "soft"};
  scene.tissue.inclusions = {all, ball};  // holds the centre of one cell alone
  CHECK_NEAR(build_network(scene).mass.sum(), 63e-6 * 2000.0 + 1e-6 * 1000.0, 1e-14);
  scene.tissue.inclusions = {ball, all};
  CHECK_NEAR(build_network(scene).mass.sum(), 64e-6 * 2000.0, 1e-14);
}

TEST("uniform weights give every spring and every node the same") {
  Scene scene;
  scene.tissue.lattice = {.nodes = {3, 3, 3},
                          .weights = LatticeWeights::uniform,
                          .stiffness = 7.0,
                          .viscosity = 0.3,
                          .node_mass = 2e-3};
  const SpringNetwork network = build_network(scene);
  for (const Spring& s : network.springs) {
    CHECK(s.stiffness == 7.0);
    CHECK(s.viscosity == 0.3);
  }
  CHECK_NEAR(network.mass, Eigen::VectorXd::Constant(27, 2e-3), 0.0);
}

/// Layers of soft tissue and of bone. The border is in the middle of the third cell.
Scene bone_scene() {
  Scene scene = layered_scene();
  scene.materials.push_back(material("bone", 1e9, 2000.0));
  scene.tissue.layers = {{"fat", "soft", 0.025}, {"vertebra", "bone", 0.025}};
  scene.tissue.fixed = std::vector<Face>{};
  return scene;
}

void check_free_springs_are_soft(const SpringNetwork& network) {
  for (const Spring& s : network.springs) {
    if (network.is_fixed(s.a) && network.is_fixed(s.b)) { continue; }
    CHECK(s.stiffness <= 2.0 * 1e3 * 0.01 / 3.75 * (1.0 + 1e-12));
  }
}

TEST("nodes in a layer of bone are fixed, and no node that moves feels bone's modulus") {
  const SpringNetwork network = build_network(bone_scene());
  CHECK(network.node_count() == 3 * 3 * 6);
  for (int i = 0; i < network.node_count(); ++i) {
    CHECK(network.is_fixed(i) == (network.rest_position(2, i) > 0.025));
  }
  check_free_springs_are_soft(network);
  CHECK_NEAR(modulus_below(network, 4 + 18, 9), 1e3, 1e-9);  // half bone: the mean of the rest
  CHECK_NEAR(mass_of_level(network, 0.02), 4e-6 * 1000.0, 1e-12);
}

TEST("a node on the surface of bone is fixed, and one a micrometre above it is free") {
  Scene scene = bone_scene();
  scene.tissue.layers[1].thickness = 0.02;
  for (const auto& [above, fixed] : {std::pair{0.0, 27}, {0.9e-9, 27}, {1e-6, 18}}) {
    scene.tissue.layers[0].thickness = 0.03 + above;
    CHECK(fixed_nodes(build_network(scene)) == fixed);
  }
}

TEST("bone in the middle of layers fixes its nodes, and the layers around it keep their mean") {
  Scene scene = bone_scene();
  scene.tissue.layers = {{"fat", "soft", 0.015}, {"lamina", "bone", 0.01}, {"deep", "hard", 0.02}};
  const SpringNetwork network = build_network(scene);
  CHECK(fixed_nodes(network) == 9);
  CHECK_NEAR(modulus_below(network, 4 + 9, 9), 1e3, 1e-9);
  CHECK_NEAR(modulus_below(network, 4 + 18, 9), 1e5, 1e-7);
}

TEST("an inclusion of bone fixes the nodes in it, and cells that it cuts stay as they were") {
  Scene scene = cube_scene();
  scene.materials.push_back(material("bone", 1e9, 2000.0));
  scene.tissue.fixed = std::vector<Face>{};
  Inclusion process{.shape = Inclusion::Shape::box,
                    .centre = {0.0, 0.0, 0.02},
                    .size = {0.02, 0.02, 0.02},
                    .material = "bone"};
  scene.tissue.inclusions = {process};
  const SpringNetwork flush = build_network(scene);  // its surface runs through nodes
  CHECK(fixed_nodes(flush) == 27);
  CHECK_NEAR(flush.mass.sum(), 56e-6 * 1000.0 + 8e-6 * 2000.0, 1e-14);
  process.size.setConstant(0.016);  // holds the centres of its eight cells, and one node
  scene.tissue.inclusions = {process};
  const SpringNetwork cut = build_network(scene);
  CHECK(fixed_nodes(cut) == 1);
  CHECK(cut.is_fixed(62));
  check_free_springs_are_soft(cut);
  CHECK_NEAR(cut.mass.sum(), 64e-6 * 1000.0, 1e-14);
}

TEST("softer tissue within bone moves, and its border does not") {
  Scene scene = bone_scene();
  scene.tissue.layers = {{"vertebra", "bone", 0.05}};
  scene.tissue.block.nodes = {7, 7};
  scene.tissue.inclusions = {{.shape = Inclusion::Shape::box,
                              .centre = {0.0, 0.0, 0.025},
                              .size = {0.04, 0.04, 0.03},
                              .material = "soft"}};
  const SpringNetwork canal = build_network(scene);
  CHECK(std::ranges::count(canal.fixed, 0) == 3 * 3 * 2);
  scene.tissue.inclusions[0].size = {0.025, 0.025, 0.025};  // cuts cells whose centre is in bone
  for (const SpringNetwork& network : {canal, build_network(scene)}) {
    CHECK(std::ranges::count(network.fixed, 0) > 0);
    check_free_springs_are_soft(network);
  }
}

TEST("bone holds the nodes of uniform lattices and of networks too") {
  Scene scene = bone_scene();
  scene.tissue.source = Source::lattice;
  scene.tissue.lattice = {.nodes = {3, 3, 6}, .spacing = 0.01, .weights = LatticeWeights::uniform};
  const SpringNetwork uniform = build_network(scene);
  CHECK(fixed_nodes(uniform) == 27);
  scene.tissue.source = Source::network;
  scene.tissue.network = uniform;
  scene.tissue.network.fixed.assign(54, 0);
  CHECK(build_network(scene).fixed == uniform.fixed);
}

TEST("a material called bone that is said to be tissue is like any other") {
  Scene scene = bone_scene();
  scene.materials.back().role = TissueRole::tissue;
  const SpringNetwork network = build_network(scene);
  CHECK(fixed_nodes(network) == 0);
  CHECK_NEAR(modulus_below(network, 4 + 18, 9), 0.5 * (1e3 + 1e9), 1e-3);
}

}  // namespace PALPATE_FILE
