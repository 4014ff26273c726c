// SPDX-License-Identifier: MIT
#include "model/dynamics/embedded_surface.hpp"

#include <cmath>

#include "model/dynamics/network_builder.hpp"
#include "model/dynamics/tissue_grid.hpp"
#include "tests/check.hpp"

namespace {

using namespace palpate;
using Eigen::Vector3d;

Scene block() {
  Scene scene;
  scene.tissue.lattice = {.nodes = {5, 4, 6}, .spacing = 0.01, .weights = LatticeWeights::uniform};
  return scene;
}

NodeVectors places(int count, double reach) {
  NodeVectors points(3, count);
  for (int n = 0; n < count; ++n) {
    points.col(n) = Vector3d(0.02 * std::sin(1.3 * n), 0.015 * std::cos(2.1 * n), 0.025 + 0.025 * std::sin(0.7 * n));
  }
  return reach * points;
}

TEST("points inside follow every affine movement exactly") {
  const Scene scene = block();
  const NodeVectors rest = build_network(scene).rest_position;
  const NodeVectors points = places(60, 1.0);
  const auto embedded = embed(points, *tissue_grid(scene));
  Eigen::Matrix3d map;
  map << 1.1, 0.2, -0.1, 0.05, 0.9, 0.3, -0.2, 0.1, 1.3;
  const Vector3d shift(0.01, -0.02, 0.03);
  CHECK_NEAR(carried(points, embedded, rest, (map * rest).colwise() + shift), (map * points).colwise() + shift, 1e-15);
  for (const EmbeddedPoint& point : embedded) {
    double sum = 0.0;
    for (const double weight : point.weight) {
      CHECK(weight >= 0.0);
      sum += weight;
    }
    CHECK_NEAR(sum, 1.0, 1e-15);
  }
}

TEST("a point on a node is that node's") {
  const Scene scene = block();
  const NodeVectors rest = build_network(scene).rest_position;
  const auto embedded = embed(rest, *tissue_grid(scene));
  for (Eigen::Index i = 0; i < rest.cols(); ++i) {
    const EmbeddedPoint& point = embedded[static_cast<std::size_t>(i)];
    double own = 0.0;
    for (std::size_t n = 0; n < 4; ++n) { own += point.node[n] == i ? point.weight[n] : 0.0; }
    CHECK_NEAR(own, 1.0, 1e-12);
  }
}

TEST("a point outside goes with the nearest place of a cell, and one far off stays") {
  const Scene scene = block();
  const NodeVectors rest = build_network(scene).rest_position;
  NodeVectors points(3, 5);
  points.col(0) = Vector3d(0.0, 0.0, -0.004);      // above the skin
  points.col(1) = Vector3d(0.026, 0.0, 0.013);     // beside it
  points.col(2) = Vector3d(0.0, 0.0, -0.0199);     // two spacings, not quite
  points.col(3) = Vector3d(0.0, 0.0, -0.0201);     // two spacings and more
  points.col(4) = Vector3d(0.0, 1e6, std::nan(""));
  const auto embedded = embed(points, *tissue_grid(scene));
  CHECK(embedded[0].follows() && embedded[1].follows() && embedded[2].follows());
  CHECK(!embedded[3].follows() && !embedded[4].follows());
  NodeVectors position = rest;
  position.row(2) += 0.1 * rest.row(2) + 0.2 * rest.row(0);  // shear and stretch
  const NodeVectors moved = carried(points, embedded, rest, position);
  CHECK_NEAR(moved(2, 0) - points(2, 0), 0.0, 1e-15);                            // as at z = 0
  CHECK_NEAR(moved(2, 1) - points(2, 1), 0.1 * 0.013 + 0.2 * 0.02, 1e-15);       // as at x = 0.02
  CHECK_NEAR(moved(2, 3), points(2, 3), 0.0);
}

TEST("cells that lack a corner carry nothing") {
  NodeGrid grid = *tissue_grid(block());
  grid.node[grid.index(2, 1, 0)] = -1;
  NodeVectors point(3, 1);
  point.col(0) = grid.first + Vector3d(0.0145, 0.005, 0.005);  // in cell (1, 0, 0), nearest whole cell (0, 0, 0)
  const EmbeddedPoint found = embed(point, grid).front();
  CHECK(found.follows());
  for (std::size_t n = 0; n < 4; ++n) { CHECK(found.weight[n] == 0.0 || found.node[n] % 5 <= 1); }
}

}  // namespace
