// SPDX-License-Identifier: MIT

#include "model/tissue/skin.hpp"

#include <cmath>

#include "model/problem/needle_path.hpp"
#include "model/tissue/network_builder.hpp"
#include "model/tissue/scene_check.hpp"
#include "model/tissue/solids.hpp"
#include "model/tissue/tissue_grid.hpp"
#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using Eigen::Vector3d;

Scene layered(std::shared_ptr<const Skin> skin) {
  Scene scene;
  scene.tissue.source = Source::layers;
  scene.tissue.block = {.nodes = {7, 6}, .spacing = 0.004};
  scene.tissue.layers = {{"skin", "stiff", 0.002}, {"fat", "soft", 0.011}, {"", "bone", 0.008}};
  scene.tissue.skin = std::move(skin);
  scene.materials = {
      {.name = "soft", .youngs_modulus = 5e3, .density = 950.0, .damping_ratio = 0.4},
      {.name = "stiff", .youngs_modulus = 5e4, .density = 1100.0, .viscosity = 0.1},
      {.name = "bone", .youngs_modulus = 1e9, .density = 1900.0}};
  return scene;
}

std::shared_ptr<const Skin> box_skin(const Vector3d& low, const Vector3d& high) {
  return std::make_shared<const Skin>(box_surface(low, high), true);
}

std::shared_ptr<const Skin> patch(const std::function<double(double, double)>& height,
                                  bool shapes = true) {
  return std::make_shared<const Skin>(patch_surface({0.03, 0.03}, 40, height), shapes);
}

std::string refusal(const Scene& scene) {
  std::string all;
  for (const Violation& broken : check_scene(scene)) {
    all += broken.key + ": " + broken.message + "\n";
  }
  return all;
}

TEST("depth beneath a box: to the nearest of its sides, negative above and beside it") {
  const Skin skin(box_surface({-0.02, -0.01, 0.005}, {0.02, 0.01, 0.045}), true);
  CHECK_NEAR(skin.beneath(0.003, 0.004)->top, 0.005, 1e-15);
  CHECK_NEAR(skin.beneath(0.003, 0.004)->bottom, 0.045, 1e-15);
  CHECK_NEAR(skin.beneath(0.0, 0.0)->bottom, 0.045, 1e-15);  // on the edge that two faces share
  CHECK(!skin.beneath(0.0201, 0.0));
  CHECK_NEAR(skin.depth({0.001, 0.002, 0.009}), 0.004, 1e-15);
  CHECK_NEAR(skin.depth({0.001, 0.009, 0.025}), 0.001, 1e-15);
  CHECK_NEAR(skin.depth({0.001, 0.002, 0.0}), -0.005, 1e-15);
  CHECK_NEAR(skin.depth({0.001, 0.002, 0.048}), -0.003, 1e-15);  // below the body
  CHECK_NEAR(skin.depth({0.023, 0.0, 0.001}), -0.005, 1e-15);  // 3 mm beside and 4 mm above an edge
}

TEST("the nearest of many faces is that of a search through all of them") {
  const Skin skin(patch_surface({0.03, 0.02}, 30,
                                [](double x, double y) { return 20.0 * x * y + 4.0 * y * y; }),
                  true);
  const TriangleSurface& surface = skin.surface();
  for (int n = 0; n < 40; ++n) {
    const Vector3d p(0.04 * std::sin(1.7 * n), 0.03 * std::cos(2.3 * n), 0.01 * std::sin(0.9 * n));
    double least = 1.0;
    constexpr int parts = 24;  // per edge of each face, about 0.08 mm
    for (int f = 0; f < static_cast<int>(surface.triangle.size()); ++f) {
      for (int i = 0; i <= parts; ++i) {
        for (int j = 0; i + j <= parts; ++j) {
          const Vector3d at = (i * surface.corner(f, 0) + j * surface.corner(f, 1) +
                               (parts - i - j) * surface.corner(f, 2)) /
                              parts;
          least = std::min(least, (at - p).norm());
        }
      }
    }
    CHECK(skin.distance(p) <= least + 1e-15);
    CHECK_NEAR(skin.distance(p), least, 1e-4);
  }
}

TEST("under a flat skin lies the block that is there without one") {
  const Scene flat = layered(nullptr);
  const Scene beneath = layered(patch([](double, double) { return 0.0; }));
  const SpringNetwork expected = build_network(flat);
  const SpringNetwork network = build_network(beneath);
  CHECK(layered_node_count(beneath) == layered_node_count(flat));
  CHECK_NEAR(network.rest_position, expected.rest_position, 1e-15);
  CHECK_NEAR(network.mass, expected.mass, 1e-14);
  CHECK(network.fixed == expected.fixed);
  REQUIRE(network.springs.size() == expected.springs.size());
  for (std::size_t s = 0; s < network.springs.size(); ++s) {
    const Spring& one = network.springs[s];
    const Spring& other = expected.springs[s];
    CHECK(one.a == other.a);
    CHECK(one.b == other.b);
    CHECK_NEAR(one.stiffness / other.stiffness, 1.0, 1e-10);
    CHECK_NEAR(one.viscosity, other.viscosity, 1e-10 * other.viscosity);
  }
}

TEST("a skin that only follows leaves the layers flat") {
  const auto raised = [](double, double) { return -0.012; };
  CHECK(build_network(layered(patch(raised, false))).node_count() ==
        build_network(layered(nullptr)).node_count());
  CHECK(build_network(layered(patch(raised))).node_count() ==
        build_network(layered(nullptr)).node_count() + 3 * 42);
}

TEST("layers stay as thick as they are, across the skin, on a slope") {
  const double slope = 0.5;
  const Scene scene = layered(patch([=](double x, double) { return slope * x; }));
  const double lean = std::sqrt(1.0 + slope * slope);
  const auto line = intervals_along(scene, {0.001, 0.0, 0.0}, Vector3d::UnitZ(), 0.001);
  REQUIRE(line.size() == 3);
  CHECK(line[0].label == "skin");
  CHECK(line[1].label == "fat");
  CHECK(line[2].label == "bone");
  // Depth is counted from the first nodes, here half a millimetre below the skin.
  CHECK_NEAR(line[0].end, 0.001 + 0.002 * lean, 1e-8);
  CHECK_NEAR(line[1].end, 0.001 + 0.013 * lean, 1e-8);
  CHECK(label_at(scene, {0.001, 0.0, slope * 0.001 + 0.012 * lean}, 0.0) == "fat");
  const Vector3d straight = Vector3d(-slope, 0.0, 1.0).normalized();
  const auto across = intervals_along(scene, {0.0, 0.0, 0.0}, straight, 0.0);
  CHECK_NEAR(across[0].end, 0.002, 1e-8);
  CHECK_NEAR(across[1].end, 0.013, 1e-8);
}

TEST("a line crosses every layer, however thin, and has a gap where it leaves the body") {
  Scene scene = layered(box_skin({-0.012, -0.03, 0.0}, {0.008, 0.03, 0.05}));
  scene.tissue.layers[0].thickness = 1e-7;
  const auto line =
      intervals_along(scene, {0.0, 0.0, 0.0}, Vector3d(1.0, 0.0, 1.0).normalized(), 0.0);
  REQUIRE(line.size() == 4);
  CHECK(line[0].label == "skin");
  CHECK(line[1].label == "fat");
  CHECK(line[2].label == "skin");
  CHECK_NEAR(line[0].end, 1e-7 * std::sqrt(2.0), 3e-9);
  CHECK(line[3].label == "gap");
  CHECK(line[3].friction == 0.0);
  CHECK_NEAR(line[3].begin, 0.008 * std::sqrt(2.0), 3e-9);
}

TEST("a closed body ends at its far surface") {
  const Scene scene = layered(box_skin({-0.03, -0.03, 0.0}, {0.03, 0.03, 0.012}));
  CHECK_NEAR(build_network(scene).rest_position.row(2).maxCoeff(), 0.012, 1e-15);
  CHECK_NEAR(uneven_block(scene).covered, 1.0, 0.0);
}

TEST("nodes in bone beneath a curved skin are held, and no others but those of the face") {
  Scene scene = layered(patch([](double x, double) { return 20.0 * x * x; }));
  scene.tissue.fixed = std::vector<Face>{};
  const SpringNetwork network = build_network(scene);
  bool any = false;
  for (Eigen::Index i = 0; i < network.node_count(); ++i) {
    const double depth = scene.tissue.skin->depth(network.rest_position.col(i));
    CHECK(network.is_fixed(static_cast<int>(i)) == (depth >= 0.013 - 1e-9));
    any = any || network.is_fixed(static_cast<int>(i));
  }
  CHECK(any);
}

TEST("a pit of one cell stays open though all its corners exist") {
  const auto pit = [](double x, double y) {
    return std::max(std::abs(x), std::abs(y)) < 0.0015 ? 0.0041 : 0.0;
  };
  Scene scene = layered(std::make_shared<const Skin>(patch_surface({0.03, 0.03}, 120, pit), true));
  scene.tissue.block.nodes = {8, 8};  // a column of cells about x = 0 and y = 0
  const UnevenBlock block = uneven_block(scene);
  CHECK(!block.holds(3, 3, 0));
  CHECK(block.holds(3, 3, 1));
  CHECK(block.holds(2, 3, 0));
  const SpringNetwork network = build_network(scene);
  Scene whole = scene;
  whole.tissue.skin = nullptr;
  CHECK(network.node_count() == build_network(whole).node_count());
  // Four body diagonals of the cell and two diagonals of its top are removed; those of its sides
  // are shared with neighbouring cells.
  CHECK(build_network(whole).springs.size() - network.springs.size() == 6);
}

TriangleSurface joined(const TriangleSurface& a, const TriangleSurface& b) {
  TriangleSurface both = a;
  const auto before = static_cast<int>(a.vertex.cols());
  both.vertex.resize(3, before + b.vertex.cols());
  both.vertex << a.vertex, b.vertex;
  for (const auto& [i, j, k] : b.triangle) {
    both.triangle.push_back({i + before, j + before, k + before});
  }
  return both;
}

TEST("several sheets of an open surface above one column are refused, closed surfaces are not") {
  const auto sheet = [](double z) {
    return patch_surface({0.03, 0.03}, 8, [z](double, double) { return z; });
  };
  const auto refusal_of = [](TriangleSurface surface) {
    return refusal(layered(std::make_shared<const Skin>(std::move(surface), true)));
  };
  CHECK(refusal_of(sheet(0.0)).empty());
  CHECK_CONTAINS(
      refusal_of(joined(sheet(0.0), sheet(0.004))),
      "tissue.skin.path: beneath [-0.01, -0.008] m it has faces at z = 0 and 0.004 m, and "
      "they are not of a closed surface");
  const TriangleSurface body = box_surface({-0.02, -0.02, 0.001}, {0.02, 0.02, 0.015});
  CHECK(refusal_of(body).empty());
  CHECK_CONTAINS(refusal_of(joined(sheet(0.0), body)), "at z = 0 and 0.001 m");
  CHECK_CONTAINS(refusal_of(joined(body, sheet(0.008))), "at z = 0.001 and 0.008 m");
  CHECK(refusal_of(joined(body, sheet(0.018))).empty());  // below the end of the tissue
  TriangleSurface pierced = body;
  pierced.triangle.pop_back();
  CHECK_CONTAINS(refusal_of(pierced), "they are not of a closed surface");
  const auto turned = [](double x, double) { return 0.004 - 0.1 * x; };
  CHECK(refusal(layered(patch(turned))).empty());
}

TEST("scenes that a skin makes impossible are refused by name") {
  CHECK_CONTAINS(refusal(layered(patch([](double, double) { return 0.5; }))),
                 "tissue.skin.path: no cell of the block");
  CHECK_CONTAINS(refusal(layered(patch([](double, double) { return 0.0195; }))),
                 "from z = 0.0195 to 0.0195 m");
  CHECK_CONTAINS(refusal(layered(patch([](double, double) { return -1e5; }))),
                 "tissue.skin.path: its highest place");
  Scene bare = layered(patch([](double, double) { return 0.0; }));
  bare.tissue.source = Source::oscillator;
  CHECK_CONTAINS(refusal(bare), "tissue.skin: given");
  Scene needle = layered(patch([](double, double) { return -0.012; }));
  needle.needle = Needle{};
  CHECK_CONTAINS(refusal(needle), "needle.entry");
  Scene probe = layered(patch([](double x, double) { return 3.0 * std::max(x - 0.004, 0.0); }));
  probe.probe = Probe{.size = {0.01, 0.01}, .entry = {0.006, 0.0}};
  probe.drive = Drive{};
  CHECK(refusal(probe).empty());
  probe.probe->entry.x() = 0.009;
  CHECK_CONTAINS(refusal(probe), "probe.entry: [0.009, 0] m; no tissue lies beneath at its side");
  probe.probe->entry.x() = 0.0;
  probe.probe->map = PalpationGrid{.sites = {3, 1}, .spacing = 0.009};
  CHECK_CONTAINS(refusal(probe),
                 "probe.map: its site at [-0.009, 0] m: no tissue lies beneath at its side");
  CHECK_CONTAINS(skin_defect(box_surface({0, 0, 0}, {1, 1, 150})).value_or(""),
                 "must lie within 10 m");
  TriangleSurface broken = box_surface({0, 0, 0}, {1, 1, 1});
  broken.vertex(1, 3) = std::nan("");
  CHECK_CONTAINS(skin_defect(broken).value_or(""), "vertex 3");
  CHECK_CONTAINS(skin_defect(TriangleSurface{}).value_or(""), "no faces");
}

Scene block() {
  Scene scene;
  scene.tissue.lattice = {.nodes = {5, 4, 6}, .spacing = 0.01, .weights = LatticeWeights::uniform};
  return scene;
}

NodeVectors places(int count, double reach) {
  NodeVectors points(3, count);
  for (int n = 0; n < count; ++n) {
    points.col(n) = Vector3d(0.02 * std::sin(1.3 * n), 0.015 * std::cos(2.1 * n),
                             0.025 + 0.025 * std::sin(0.7 * n));
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
  CHECK_NEAR(carried(points, embedded, rest, (map * rest).colwise() + shift),
             (map * points).colwise() + shift, 1e-15);
  for (const EmbeddedPoint& point : embedded) {
    double sum = 0.0;
    for (const double weight : point.weight) {
      CHECK(weight >= 0.0);
      sum += weight;
    }
    CHECK_NEAR(sum, 1.0, 1e-15);
  }
}

TEST("a point on a node has the weight of that node alone") {
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

TEST("a point outside moves with the nearest point of a cell, and a distant one stays") {
  const Scene scene = block();
  const NodeVectors rest = build_network(scene).rest_position;
  NodeVectors points(3, 5);
  points.col(0) = Vector3d(0.0, 0.0, -0.004);   // above the skin
  points.col(1) = Vector3d(0.026, 0.0, 0.013);  // beside it
  points.col(2) = Vector3d(0.0, 0.0, -0.0199);  // two spacings, not quite
  points.col(3) = Vector3d(0.0, 0.0, -0.0201);  // two spacings and more
  points.col(4) = Vector3d(0.0, 1e6, std::nan(""));
  const auto embedded = embed(points, *tissue_grid(scene));
  CHECK(embedded[0].follows());
  CHECK(embedded[1].follows());
  CHECK(embedded[2].follows());
  CHECK(!embedded[3].follows());
  CHECK(!embedded[4].follows());
  NodeVectors position = rest;
  position.row(2) += 0.1 * rest.row(2) + 0.2 * rest.row(0);  // shear and stretch
  const NodeVectors moved = carried(points, embedded, rest, position);
  CHECK_NEAR(moved(2, 0) - points(2, 0), 0.0, 1e-15);                       // as at z = 0
  CHECK_NEAR(moved(2, 1) - points(2, 1), 0.1 * 0.013 + 0.2 * 0.02, 1e-15);  // as at x = 0.02
  CHECK_NEAR(moved(2, 3), points(2, 3), 0.0);
}

TEST("cells that lack a corner carry nothing") {
  NodeGrid grid = *tissue_grid(block());
  grid.node[grid.index(2, 1, 0)] = -1;
  NodeVectors point(3, 1);
  point.col(0) = grid.first +
                 Vector3d(0.0145, 0.005, 0.005);  // in cell (1, 0, 0), nearest whole cell (0, 0, 0)
  const EmbeddedPoint found = embed(point, grid).front();
  CHECK(found.follows());
  for (std::size_t n = 0; n < 4; ++n) { CHECK((found.weight[n] == 0.0 || found.node[n] % 5 <= 1)); }
}

}  // namespace PALPATE_FILE
