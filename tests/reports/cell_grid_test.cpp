// SPDX-License-Identifier: MIT
#include "reports/cell_grid.hpp"

#include <Eigen/Geometry>

#include "model/dynamics/lattice.hpp"
#include "tests/check.hpp"

using namespace palpate;

namespace {

SpringNetwork block(std::array<int, 3> nodes) {
  return uniform_lattice({.nodes = nodes, .spacing = 0.01, .connectivity = 26}, 10.0, 0.0, 1e-3);
}

bool everywhere(const GridPlace&) { return true; }

/// By the divergence theorem; negative where sides point inwards.
double enclosed_volume(const std::vector<GridFace>& faces, const NodeVectors& position) {
  double volume = 0.0;
  for (const GridFace& face : faces) {
    const Eigen::Vector3d a = position.col(face.nodes[0]);
    const Eigen::Vector3d b = position.col(face.nodes[1]);
    const Eigen::Vector3d c = position.col(face.nodes[2]);
    const Eigen::Vector3d d = position.col(face.nodes[3]);
    volume += (a.dot(b.cross(c)) + a.dot(c.cross(d))) / 6.0;
  }
  return volume;
}

/// Without the nodes that `gone` holds, and without their springs.
SpringNetwork without(const SpringNetwork& network, const std::function<bool(const Eigen::Vector3d&)>& gone) {
  SpringNetwork rest;
  std::vector<int> number(static_cast<std::size_t>(network.node_count()), -1);
  std::vector<int> kept;
  for (int n = 0; n < network.node_count(); ++n) {
    if (gone(network.rest_position.col(n))) { continue; }
    number[static_cast<std::size_t>(n)] = static_cast<int>(kept.size());
    kept.push_back(n);
  }
  rest.rest_position = network.rest_position(Eigen::all, kept);
  rest.mass = network.mass(kept);
  rest.fixed.assign(kept.size(), 0);
  for (Spring spring : network.springs) {
    spring.a = number[static_cast<std::size_t>(spring.a)];
    spring.b = number[static_cast<std::size_t>(spring.b)];
    if (spring.a >= 0 && spring.b >= 0) { rest.springs.push_back(spring); }
  }
  return rest;
}

}  // namespace

TEST("a lattice has a cell between every eight nodes, and its sides enclose its volume") {
  const SpringNetwork network = block({4, 5, 6});
  const auto grid = CellGrid::of(network);
  CHECK(grid && grid->cells().size() == 3 * 4 * 5);
  const std::vector<GridFace> faces = exposed_faces(*grid, everywhere);
  CHECK(faces.size() == 2 * (3 * 4 + 4 * 5 + 3 * 5));
  CHECK_NEAR(enclosed_volume(faces, network.rest_position), 0.03 * 0.04 * 0.05, 1e-18);  // rounding
}

TEST("a voxel body with a gap has no cells across it") {
  // A U of two legs of 3 x 3 nodes on a base, the gap between them one cell wide.
  const SpringNetwork network =
      without(block({8, 3, 6}), [](const Eigen::Vector3d& x) { return std::abs(x.x()) < 0.01 && x.z() < 0.015; });
  const auto grid = CellGrid::of(network);
  CHECK(grid.has_value());
  const double base = 0.07 * 0.02 * 0.03;
  const double legs = 2.0 * 0.02 * 0.02 * 0.02;
  CHECK_NEAR(enclosed_volume(exposed_faces(*grid, everywhere), network.rest_position), base + legs, 1e-17);
}

TEST("a cell that lacks a spring along an edge is no tissue") {
  SpringNetwork network = block({4, 3, 3});
  network.springs.edit([](std::vector<Spring>& all) {
    std::erase_if(all, [](const Spring& spring) { return spring.a == 1 && spring.b == 2; });
  });
  const auto grid = CellGrid::of(network);
  CHECK(grid && grid->cells().size() == 3 * 2 * 2 - 1);
}

TEST("planes of nodes need not be equally far apart") {
  SpringNetwork network = block({3, 3, 3});
  for (auto node : network.rest_position.colwise()) { node.z() += 40.0 * node.z() * node.z(); }
  const auto grid = CellGrid::of(network);
  CHECK(grid && grid->cells().size() == 8);
}

TEST("nodes anywhere are on no grid") {
  SpringNetwork network = block({5, 5, 5});
  std::srand(3);
  network.rest_position += 0.002 * NodeVectors::Random(3, 125);
  network.springs.edit([](std::vector<Spring>& all) {
    std::erase_if(all, [](const Spring& spring) { return spring.a == 62; });  // nor are they a lattice
  });
  CHECK(!CellGrid::of(network));
}

TEST("every second plane gives cells of twice the size where all small ones are") {
  const SpringNetwork network = block({5, 5, 7});
  const CellGrid coarse = CellGrid::of(network)->thinned(2);
  CHECK(coarse.cells().size() == 2 * 2 * 3);
  CHECK_NEAR(enclosed_volume(exposed_faces(coarse, everywhere), network.rest_position), 0.04 * 0.04 * 0.06, 1e-17);
}
