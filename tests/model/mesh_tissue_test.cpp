// SPDX-License-Identifier: MIT
#include "model/dynamics/mesh_tissue.hpp"

#include <numbers>

#include "model/dynamics/lattice.hpp"
#include "model/dynamics/network_builder.hpp"
#include "reference/solids.hpp"
#include "tests/check.hpp"

namespace {

using namespace palpate;
using Eigen::Vector3d;
using reference::box_surface;

const std::vector<Material> materials{
    {.name = "soft", .youngs_modulus = 5e3, .density = 1000.0, .damping_ratio = 0.4},
    {.name = "stiff", .youngs_modulus = 5e4, .density = 1200.0, .damping_ratio = 0.2},
    {.name = "bone", .youngs_modulus = 1e9, .density = 1900.0}};

MeshBody body(TriangleSurface surface, std::string material, int priority = 0) {
  return {.name = material + ".stl",
          .key = "tissue.mesh.files[0]",
          .surface = std::move(surface),
          .material = std::move(material),
          .priority = priority};
}

VoxelTissue build(const std::vector<MeshBody>& bodies, const MeshSettings& settings) {
  std::vector<Violation> broken;
  VoxelTissue tissue = mesh_tissue(bodies, settings, materials, broken);
  CHECK(broken.empty());
  return tissue;
}

std::string refusal(const std::vector<MeshBody>& bodies, const MeshSettings& settings) {
  std::vector<Violation> broken;
  mesh_tissue(bodies, settings, materials, broken);
  return broken.empty() ? "" : broken.front().key + ": " + broken.front().message;
}

bool has(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

TEST("a cube of voxels is the lattice of its size, spring by spring") {
  const double edge = 0.02;
  for (const int connectivity : {6, 18, 26}) {
    const MeshSettings settings{.voxel = 0.004, .connectivity = connectivity};
    const Vector3d low(-0.5 * edge, -0.5 * edge, 0.0);
    // Walls of cells at multiples of the voxel: 0.01 is 2.5 of them, so the box is moved by half a voxel.
    const Vector3d shift(0.002, 0.002, 0.0);
    const VoxelTissue tissue =
        build({body(box_surface(low + shift, low + shift + Vector3d::Constant(edge)), "soft")}, settings);
    const SpringNetwork lattice = cell_lattice({{6, 6, 6}, 0.004, connectivity}, [](int, int, int) {
      return CellMaterial{5e3, 1000.0, 0.4, {}};
    });
    CHECK_NEAR(double(tissue.network.springs.size()), double(lattice.springs.size()), 0.0);
    CHECK_NEAR(tissue.network.mass, lattice.mass, 0.0);
    double apart = 0.0;
    for (std::size_t s = 0; s < lattice.springs.size(); ++s) {
      const Spring& mine = tissue.network.springs[s];
      const Spring& its = lattice.springs[s];
      CHECK(mine.a == its.a && mine.b == its.b);
      apart = std::max(
          {apart, std::abs(mine.stiffness / its.stiffness - 1.0), std::abs(mine.viscosity / its.viscosity - 1.0)});
    }
    CHECK_NEAR(apart, 0.0, 1e-15);  // E a / 3.75 against (a / 3.75) E: four roundings
  }
}

TEST("mass is density times the volume of the voxels") {
  const VoxelTissue tissue =
      build({body(reference::ring_surface(0.02, 0.006, 4.5, 60, 30), "stiff")}, {.voxel = 0.001});
  CHECK_NEAR(tissue.network.mass.sum(), 1200.0 * tissue.bodies[0].voxel_volume, 1e-15);
  CHECK(tissue.network.mass.minCoeff() > 0.0);
}

TEST("bodies that touch share the nodes between them; a gap keeps them apart") {
  const auto springs_across = [](double gap) {
    const VoxelTissue tissue = build({body(box_surface({0.0, 0.0, 0.0}, {0.01, 0.01, 0.01}), "soft"),
                                      body(box_surface({0.0, 0.0, 0.01 + gap}, {0.01, 0.01, 0.02 + gap}), "stiff")},
                                     {.voxel = 0.002});
    int across = 0;
    for (const Spring& s : tissue.network.springs) {
      const double a = tissue.network.rest_position(2, s.a) - 0.01 - 0.5 * gap;
      const double b = tissue.network.rest_position(2, s.b) - 0.01 - 0.5 * gap;
      across += a * b < -1e-12 ? 1 : 0;
    }
    return std::pair(tissue.network.node_count(), across);
  };
  const auto [joined, over_wall] = springs_across(0.0);
  CHECK_NEAR(double(joined), 6.0 * 6.0 * 11.0, 0.0);  // one plane of nodes for both
  CHECK_NEAR(double(over_wall), 0.0, 0.0);            // through its nodes, not past them
  const auto [apart, over_gap] = springs_across(0.002);
  CHECK_NEAR(double(apart), 2.0 * 6.0 * 6.0 * 6.0, 0.0);
  CHECK_NEAR(double(over_gap), 0.0, 0.0);
}

TEST("of two bodies in one place the one of higher priority has it, of equals the last") {
  const TriangleSurface large = box_surface({0.0, 0.0, 0.0}, {0.01, 0.01, 0.01});
  const TriangleSurface small = box_surface({0.002, 0.002, 0.002}, {0.006, 0.006, 0.006});
  const auto kept = [&](int first, int second) {
    const VoxelTissue t = build({body(large, "soft", first), body(small, "stiff", second)}, {.voxel = 0.002});
    return std::pair(t.bodies[0].kept_cells, t.bodies[1].kept_cells);
  };
  CHECK(kept(0, 0) == std::pair(std::size_t{117}, std::size_t{8}));
  CHECK(kept(1, 0) == std::pair(std::size_t{125}, std::size_t{0}));
}

TEST("what surrounds bodies fills the rest of its box, and nodes of bone never move") {
  const MeshSettings settings{.voxel = 0.002, .surround = Surround{"soft", {0.0, 0.0, 0.0}, {0.01, 0.01, 0.01}}};
  const VoxelTissue tissue =
      build({body(box_surface({0.004, 0.004, 0.004}, {0.006, 0.006, 0.006}), "bone")}, settings);
  CHECK_NEAR(double(tissue.network.node_count()), 216.0, 0.0);
  CHECK_NEAR(double(std::ranges::count(tissue.network.fixed, 1)), 8.0, 0.0);
}

TEST("the file's axis that points inwards becomes z, and its origin zero") {
  TriangleSurface box = box_surface({10.0, 20.0, 30.0}, {11.0, 22.0, 33.0});
  place_in_tissue(box, 0.001, FileAxis::x_minus, {0.011, 0.02, 0.03});
  const Vector3d low = box.vertex.rowwise().minCoeff();
  const Vector3d high = box.vertex.rowwise().maxCoeff();
  CHECK_NEAR(low, Vector3d(-0.002, 0.0, 0.0), 1e-15);
  CHECK_NEAR(high, Vector3d(0.0, 0.003, 0.001), 1e-15);
  CHECK(moments_of(box).volume > 0.0);  // turned, not mirrored
}

TEST("what cannot become voxels is refused with its key") {
  const TriangleSurface box = box_surface(Vector3d::Zero(), Vector3d::Constant(0.01));
  CHECK(has(refusal({}, {}), "tissue.mesh.files: is missing"));
  CHECK(has(refusal({body(box, "wood")}, {}),
            "tissue.mesh.files[0].material: unknown material \"wood\"; known are soft, stiff, bone"));
  CHECK(has(refusal({body(box, "soft")}, {.voxel = 1e-6}), "1e+12 voxels around the bodies of 0.01 m; at most 1e8"));
  const TriangleSurface plate = box_surface({0.0, 0.0, 0.0001}, {0.01, 0.01, 0.0005});
  CHECK(has(refusal({body(plate, "soft")}, {}), "no voxel's centre is inside soft.stl, which is thinner"));
  TriangleSurface open = box;
  open.triangle.pop_back();
  CHECK(has(refusal({body(open, "soft")}, {}), "tissue.mesh.files[0].path: soft.stl: open: edge"));
}

TEST("a needle meets the bodies on its line, and gaps between them") {
  Scene scene;
  scene.materials = materials;
  scene.tissue.source = Source::mesh;
  scene.tissue.voxels = std::make_shared<const VoxelTissue>(
      build({body(box_surface({-0.01, -0.01, 0.0}, {0.01, 0.01, 0.01}), "soft"),
             body(box_surface({-0.01, -0.01, 0.014}, {0.01, 0.01, 0.02}), "stiff"),
             body(box_surface({-0.01, -0.01, 0.02}, {0.01, 0.01, 0.03}), "bone")},
            {.voxel = 0.002}));
  scene.needle = Needle{};
  const NeedlePath path = tool_path(scene, build_network(scene));
  CHECK_NEAR(double(path.intervals().size()), 4.0, 0.0);
  const std::vector<std::string> labels{"soft", "gap", "stiff", "bone"};
  const std::vector<double> ends{0.01, 0.014, 0.02};
  for (std::size_t n = 0; n < labels.size(); ++n) { CHECK(path.intervals()[n].label == labels[n]); }
  for (std::size_t n = 0; n < ends.size(); ++n) { CHECK_NEAR(path.intervals()[n].end, ends[n], 1e-12); }
  CHECK_NEAR(path.bone(), 0.02, 1e-12);
  CHECK_NEAR(double(path.knots().size()), 6.0 + 9.0, 0.0);  // planes of nodes; none in the gap
  scene.needle->direction = {std::tan(0.3), 0.0, 1.0};
  const NeedlePath slanted = tool_path(scene, build_network(scene));
  CHECK_NEAR(slanted.intervals()[0].end, 0.01 / std::cos(0.3), 1e-12);
  CHECK_NEAR(slanted.bone(), 0.02 / std::cos(0.3), 1e-12);
}

TEST("where the skin is steep a short gap before the line's own voxels is theirs, a long one stays a gap") {
  for (const double low : {0.004, 0.006}) {  // of the body on the line: two voxels and three
    Scene scene;
    scene.materials = materials;
    scene.tissue.source = Source::mesh;
    scene.tissue.voxels = std::make_shared<const VoxelTissue>(
        build({body(box_surface({-0.01, -0.01, 0.0}, {0.0, 0.01, 0.02}), "stiff"),
               body(box_surface({0.0, -0.01, low}, {0.01, 0.01, 0.02}), "soft")},
              {.voxel = 0.002}));
    const auto line = intervals_along(scene, {0.0005, 0.0, 0.0}, Vector3d::UnitZ(), 0.0);
    const bool joined = low < 0.005;
    CHECK(line.front().label == (joined ? "soft" : "gap"));
    CHECK_NEAR(line.front().begin, 0.0, 0.0);
    CHECK_NEAR(double(line.size()), joined ? 1.0 : 2.0, 0.0);
  }
}

}  // namespace
