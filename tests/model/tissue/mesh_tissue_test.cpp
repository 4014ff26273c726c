// SPDX-License-Identifier: MIT

#include <Eigen/Geometry>
#include <cmath>
#include <ctime>
#include <limits>
#include <numbers>

#include "model/tissue/lattice.hpp"
#include "model/tissue/network_builder.hpp"
#include "model/tissue/solids.hpp"
#include "model/tissue/triangle_surface.hpp"
#include "model/tissue/voxel_tissue.hpp"
#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using Eigen::Vector3d;

std::string defect_of(const TriangleSurface& surface) {
  return surface_defect(surface).value_or("none");
}

TriangleSurface unit_box() { return box_surface(Vector3d::Zero(), Vector3d::Ones()); }

/// Both surfaces as one.
TriangleSurface joined(TriangleSurface one, const TriangleSurface& other) {
  const int first = static_cast<int>(one.vertex.cols());
  one.vertex.conservativeResize(3, first + other.vertex.cols());
  one.vertex.rightCols(other.vertex.cols()) = other.vertex;
  for (const auto& t : other.triangle) {
    one.triangle.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  return one;
}

TEST("a box has its volume, centroid and inertia, wherever it lies") {
  const Vector3d edges(0.02, 0.03, 0.05);
  const Vector3d low(1.0, -2.0, 0.5);
  const SolidMoments solid = moments_of(box_surface(low, low + edges));
  const double volume = edges.prod();
  // Rounding of coordinates near 2 m against edges of 0.02 m: 1e-14 relative.
  CHECK_NEAR(solid.volume, volume, 1e-13 * volume);
  CHECK_NEAR(solid.centroid, Vector3d(low + 0.5 * edges), 1e-14);
  const double xx = volume / 12.0 * (edges.y() * edges.y() + edges.z() * edges.z());
  CHECK_NEAR(solid.inertia(0, 0), xx, 1e-12 * xx);
  CHECK_NEAR(solid.inertia(0, 1), 0.0, 1e-12 * xx);
}

TEST("volumes of spheres and rings converge at second order of their faces") {
  const double sphere = 4.0 / 3.0 * std::numbers::pi;
  const double coarse =
      std::abs(moments_of(sphere_surface(Vector3d::Zero(), 1.0, 20)).volume - sphere);
  const double fine =
      std::abs(moments_of(sphere_surface(Vector3d::Zero(), 1.0, 40)).volume - sphere);
  CHECK_NEAR(std::log2(coarse / fine), 2.0, 0.05);
  // A wedge between two planes through z holds the integral of r dA over the polygon times
  // sin(step): the polygon's area times its centroid's radius, 1.
  const int steps = 24;
  const int around = 16;
  const double angle = 1.5 * std::numbers::pi;
  const double area = 0.5 * around * 0.3 * 0.3 * std::sin(2.0 * std::numbers::pi / around);
  const double exact = steps * std::sin(angle / steps) * area;
  CHECK_NEAR(moments_of(ring_surface(1.0, 0.3, angle, steps, around)).volume, exact, 1e-12 * exact);
}

TEST("sound surfaces have no defect") {
  CHECK(!surface_defect(unit_box()));
  CHECK(!surface_defect(sphere_surface(Vector3d::Zero(), 1.0, 12)));
  CHECK(!surface_defect(ring_surface(1.0, 0.3, 2.0 * std::numbers::pi, 40, 20)));
  CHECK(!surface_defect(ring_surface(1.0, 0.3, 4.5, 40, 20)));
}

TEST("a defect of a surface is named with its faces, edges and vertices") {
  const auto defect = [](auto change) {
    TriangleSurface box = unit_box();
    change(box);
    return defect_of(box);
  };
  const std::string open = defect([](TriangleSurface& box) { box.triangle.pop_back(); });
  CHECK_CONTAINS(open, "open: edge (");
  CHECK_CONTAINS(open, "has no face on its other side");
  const std::string turned =
      defect([](TriangleSurface& box) { std::swap(box.triangle[5][0], box.triangle[5][1]); });
  CHECK_CONTAINS(turned, "turned against each other");
  CHECK_CONTAINS(turned, "5");
  const std::string inverted = defect([](TriangleSurface& box) {
    for (auto& face : box.triangle) { std::swap(face[0], face[1]); }
  });
  CHECK_CONTAINS(inverted, "inside out: its volume is -1 m^3");
  const std::string lost = defect([](TriangleSurface& box) { box.vertex(1, 3) = std::nan(""); });
  CHECK_CONTAINS(lost, "vertex 3 has a coordinate that is not finite");
  const std::string missing = defect([](TriangleSurface& box) { box.triangle[2][1] = 8; });
  CHECK_CONTAINS(missing, "face 2 names vertex 8; 0 to 7");
}

TEST("a surface that intersects itself is named with both faces") {
  const TriangleSurface other = box_surface(Vector3d::Constant(0.5), Vector3d::Constant(1.4));
  TriangleSurface two = joined(unit_box(), other);
  CHECK_CONTAINS(defect_of(two), "cross each other");
  two.vertex.rightCols(other.vertex.cols()).array() += 2.0;  // two bodies without a common point
  CHECK(!surface_defect(two));
}

TEST("welding joins a soup of faces and drops those without area") {
  const TriangleSurface box = unit_box();
  TriangleSurface soup;
  soup.vertex.resize(3, 3 * 12 + 3);
  for (int f = 0; f < 12; ++f) {
    for (int n = 0; n < 3; ++n) { soup.vertex.col(3 * f + n) = box.corner(f, n); }
    soup.triangle.push_back({3 * f, 3 * f + 1, 3 * f + 2});
  }
  soup.vertex.rightCols(3).setZero();
  soup.triangle.push_back({36, 37, 38});
  CHECK_CONTAINS(defect_of(soup), "open");
  weld(soup);
  CHECK(!surface_defect(soup));
  CHECK(soup.triangle.size() == 12);
}

BoxGrid grid_of(const TriangleSurface& surface, double edge) {
  return cubes_around(surface.vertex.rowwise().minCoeff(), surface.vertex.rowwise().maxCoeff(),
                      edge);
}

/// Calls `visit` with the centre of every cell and whether the body fills it.
void visit_cells(const BoxGrid& grid, const VoxelBody& body, auto visit) {
  for (int l = 0; l < grid.count[2]; ++l) {
    for (int j = 0; j < grid.count[1]; ++j) {
      for (int i = 0; i < grid.count[0]; ++i) {
        visit(Vector3d(grid.low + grid.size.cwiseProduct(Vector3d(i + 0.5, j + 0.5, l + 0.5))),
              body.inside[grid.index(i, j, l)] != 0);
      }
    }
  }
}

/// Winding number of a closed surface about a point: sum of the faces' solid angles over 4 pi.
double winding(const TriangleSurface& surface, const Vector3d& at) {
  double sum = 0.0;
  for (int f = 0; f < static_cast<int>(surface.triangle.size()); ++f) {
    const Vector3d a = surface.corner(f, 0) - at;
    const Vector3d b = surface.corner(f, 1) - at;
    const Vector3d c = surface.corner(f, 2) - at;
    const double below = a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() +
                         b.dot(c) * a.norm() + c.dot(a) * b.norm();
    sum += 2.0 * std::atan2(a.dot(b.cross(c)), below);
  }
  return sum / (4.0 * std::numbers::pi);
}

double area(const TriangleSurface& surface) {
  double sum = 0.0;
  for (int f = 0; f < static_cast<int>(surface.triangle.size()); ++f) {
    const Vector3d a = surface.corner(f, 0);
    sum += 0.5 * (surface.corner(f, 1) - a).cross(surface.corner(f, 2) - a).norm();
  }
  return sum;
}

TEST("a box that ends on walls of cells is filled to the last cell, wherever it lies") {
  for (const Vector3d& at :
       {Vector3d(0.0, 0.0, 0.0), Vector3d(-0.008, 0.012, 0.1), Vector3d(-1.0, -1.0, -1.0)}) {
    const TriangleSurface box = box_surface(at, at + Vector3d(0.01, 0.02, 0.03));
    const BoxGrid grid =
        cubes_around(at - Vector3d::Constant(0.004), at + Vector3d::Constant(0.04), 0.002);
    const VoxelBody body = voxelise(box, grid);
    CHECK_NEAR(double(body.voxel_count), 5.0 * 10.0 * 15.0, 0.0);
    CHECK(body.parts == 1);
  }
}

TEST("every cell agrees with the winding number of the surface about its centre") {
  const TriangleSurface shapes[] = {sphere_surface({0.001, 0.002, 0.003}, 0.02, 6),
                                    ring_surface(0.02, 0.006, 2.0 * std::numbers::pi, 16, 9),
                                    ring_surface(0.02, 0.006, 4.5, 16, 9)};
  for (const TriangleSurface& shape : shapes) {
    const BoxGrid grid = grid_of(shape, 0.0017);
    const VoxelBody body = voxelise(shape, grid);
    int wrong = 0;
    int inside = 0;
    visit_cells(grid, body, [&](const Vector3d& centre, bool filled) {
      const bool truth = winding(shape, centre) > 0.5;
      inside += truth ? 1 : 0;
      wrong += truth != filled ? 1 : 0;
    });
    CHECK(wrong == 0);
    CHECK(inside > 100);
  }
}

TEST("rows through vertices and along edges count them once") {
  // Octahedron whose vertices and edges are exactly on rows of cell centres.
  const double h = 0.001;
  const TriangleSurface shape = sphere_surface(Vector3d::Constant(0.5 * h), 10.0 * h, 1);
  const BoxGrid grid = cubes_around(Vector3d::Constant(-12.0 * h), Vector3d::Constant(12.0 * h), h);
  const VoxelBody body = voxelise(shape, grid);
  int wrong = 0;
  visit_cells(grid, body, [&](const Vector3d& centre, bool filled) {
    const double sum = (centre - Vector3d::Constant(0.5 * h)).lpNorm<1>() / h;
    wrong += (sum < 9.5 && !filled) || (sum > 10.5 && filled) ? 1 : 0;  // between, either is right
  });
  CHECK(wrong == 0);
  // A face includes about half of its cells: of the 402 centres on the surface (4 n^2 + 2) some are
  // inside and some outside.
  CHECK(body.voxel_count > 1000);
  CHECK(body.voxel_count < 1600);
}

TEST("a letter C, whose centroid is outside, is grown from a seed inside") {
  const TriangleSurface c = ring_surface(0.02, 0.004, 5.0, 60, 24);
  const SolidMoments solid = moments_of(c);
  CHECK(winding(c, solid.centroid) < 0.5);
  const VoxelBody body = voxelise(c, grid_of(c, 0.001));
  CHECK(body.parts == 1);
  CHECK_NEAR(body.volume, solid.volume, 0.02 * solid.volume);
}

TEST("a neck narrower than a voxel leaves two parts, and both are kept") {
  const TriangleSurface two = joined(box_surface(Vector3d::Zero(), Vector3d::Constant(0.01)),
                                     box_surface({0.0, 0.0, 0.0115}, {0.01, 0.01, 0.02}));
  const VoxelBody body = voxelise(two, grid_of(two, 0.0005));
  CHECK(body.parts == 2);
  CHECK_NEAR(body.volume, 1e-6 * (1.0 + 0.85), 1e-15);
}

/// Returns volume, centroid and inertia of voxels that are homogeneous cubes.
SolidMoments moments_of_voxels(const VoxelBody& body, const BoxGrid& grid) {
  SolidMoments solid{.volume = body.volume};
  const double each = grid.volume();
  Eigen::Matrix3d second =
      body.volume * (grid.size.cwiseAbs2() / 12.0).asDiagonal().toDenseMatrix();
  for_each_place(grid.count, [&](int i, int j, int l) {
    if (body.inside[grid.index(i, j, l)] == 0) { return; }
    const Vector3d at = grid.low + grid.size.cwiseProduct(Vector3d(i + 0.5, j + 0.5, l + 0.5));
    solid.centroid += each / body.volume * at;
    second += each * at * at.transpose();
  });
  second -= body.volume * solid.centroid * solid.centroid.transpose();
  solid.inertia = second.trace() * Eigen::Matrix3d::Identity() - second;
  return solid;
}

TEST("volume, centroid and inertia of voxels converge at first order") {
  const TriangleSurface shapes[] = {
      sphere_surface({0.0013, 0.0007, 0.0021}, 0.02, 24),
      ring_surface(0.02, 0.006, 2.0 * std::numbers::pi, 60, 30),
      ring_surface(0.02, 0.006, 4.5, 60, 30),
      box_surface({0.0003, 0.0002, 0.0001}, {0.0403, 0.0302, 0.0046})};
  for (const TriangleSurface& shape : shapes) {
    const SolidMoments exact = moments_of(shape);
    const double surface = area(shape);
    for (const double h : {0.004, 0.002, 0.001, 0.0005}) {
      const BoxGrid grid = grid_of(shape, h);
      const SolidMoments voxels = moments_of_voxels(voxelise(shape, grid), grid);
      // A partly wrong cell is within half its diagonal of the surface, so the error is at most the
      // volume of that shell.
      const double shell = surface * h * std::sqrt(3.0);
      const double reach =
          (shape.vertex.colwise() - exact.centroid).colwise().norm().maxCoeff() + h;
      CHECK_NEAR(voxels.volume, exact.volume, 0.5 * shell);
      CHECK_NEAR(voxels.centroid, exact.centroid, shell * reach / exact.volume);
      CHECK_NEAR(voxels.inertia, exact.inertia, shell * reach * reach);
    }
  }
}

TEST("two million voxels of 200,000 faces take less than ten seconds, its check included") {
  const TriangleSurface sphere = sphere_surface(Vector3d::Zero(), 0.08, 158);
  CHECK(sphere.triangle.size() >= 199000);
  const std::clock_t begin = std::clock();  // processor time: the machine may be busy
  CHECK(!surface_defect(sphere));
  const BoxGrid grid = grid_of(sphere, 0.001);
  const VoxelBody body = voxelise(sphere, grid);
  const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  CHECK(body.voxel_count > 2000000);
  if (!check::sanitized) { CHECK(seconds < 10.0); }
}

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

TEST("a surface in millimetres is placed in metres") {
  TriangleSurface sphere = sphere_surface({5.0, 0.0, 20.0}, 20.0, 24);
  place_in_tissue(sphere, 1e-3, FileAxis::z_plus, {0.005, 0.0, 0.0});
  // Rounding of 40 mm.
  CHECK_NEAR(sphere.vertex.row(2).maxCoeff(), 0.040, 1e-15);
  CHECK_NEAR(sphere.vertex.row(2).minCoeff(), 0.0, 1e-15);
  CHECK_NEAR(sphere.vertex.row(0).maxCoeff() + sphere.vertex.row(0).minCoeff(), 0.0, 1e-15);
}

VoxelTissue build(const std::vector<MeshBody>& bodies, const MeshSettings& settings) {
  std::vector<Violation> broken;
  VoxelTissue tissue = mesh_tissue(bodies, settings, materials, broken);
  REQUIRE(broken.empty());
  return tissue;
}

std::string refusal(const std::vector<MeshBody>& bodies, const MeshSettings& settings) {
  std::vector<Violation> broken;
  mesh_tissue(bodies, settings, materials, broken);
  return broken.empty() ? "" : broken.front().key + ": " + broken.front().message;
}

TEST("a cube of voxels is the lattice of its size, spring by spring") {
  const double edge = 0.02;
  for (const int connectivity : {6, 18, 26}) {
    const MeshSettings settings{.voxel = 0.004, .connectivity = connectivity};
    const Vector3d low(-0.5 * edge, -0.5 * edge, 0.0);
    // Cell borders are at multiples of the voxel. A side of 0.01 has 2.5 voxels, so the box is
    // shifted by half a voxel.
    const Vector3d shift(0.002, 0.002, 0.0);
    const VoxelTissue tissue = build(
        {body(box_surface(low + shift, low + shift + Vector3d::Constant(edge)), "soft")}, settings);
    const SpringNetwork lattice = cell_lattice({{6, 6, 6}, 0.004, connectivity}, [](int, int, int) {
      return CellMaterial{5e3, 1000.0, 0.4, {}};
    });
    CHECK_NEAR(double(tissue.network.springs.size()), double(lattice.springs.size()), 0.0);
    CHECK_NEAR(tissue.network.mass, lattice.mass, 0.0);
    for (std::size_t s = 0; s < lattice.springs.size(); ++s) {
      const Spring& mine = tissue.network.springs[s];
      const Spring& its = lattice.springs[s];
      CHECK(mine.a == its.a);
      CHECK(mine.b == its.b);
      // E a / 3.75 against (a / 3.75) E: four roundings
      CHECK_NEAR(mine.stiffness / its.stiffness, 1.0, 1e-15);
      CHECK_NEAR(mine.viscosity / its.viscosity, 1.0, 1e-15);
    }
  }
}

TEST("mass is density times the volume of the voxels") {
  const VoxelTissue tissue =
      build({body(ring_surface(0.02, 0.006, 4.5, 60, 30), "stiff")}, {.voxel = 0.001});
  CHECK_NEAR(tissue.network.mass.sum(), 1200.0 * tissue.bodies[0].voxel_volume, 1e-15);
  CHECK(tissue.network.mass.minCoeff() > 0.0);
}

TEST("bodies that touch share the nodes between them; a gap keeps them apart") {
  const auto springs_across = [](double gap) {
    const VoxelTissue tissue =
        build({body(box_surface({0.0, 0.0, 0.0}, {0.01, 0.01, 0.01}), "soft"),
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
  CHECK(over_wall == 0);                              // through its nodes, not past them
  const auto [apart, over_gap] = springs_across(0.002);
  CHECK_NEAR(double(apart), 2.0 * 6.0 * 6.0 * 6.0, 0.0);
  CHECK(over_gap == 0);
}

TEST("of two bodies in one place the one of higher priority has it, of equals the last") {
  const TriangleSurface large = box_surface({0.0, 0.0, 0.0}, {0.01, 0.01, 0.01});
  const TriangleSurface small = box_surface({0.002, 0.002, 0.002}, {0.006, 0.006, 0.006});
  const auto kept = [&](int first, int second) {
    const VoxelTissue t =
        build({body(large, "soft", first), body(small, "stiff", second)}, {.voxel = 0.002});
    return std::pair(t.bodies[0].kept_cells, t.bodies[1].kept_cells);
  };
  CHECK(kept(0, 0) == std::pair(std::size_t{117}, std::size_t{8}));
  CHECK(kept(1, 0) == std::pair(std::size_t{125}, std::size_t{0}));
}

TEST("a box around bodies whose corners are not in order is refused") {
  for (const Eigen::Vector3d& max :
       {Eigen::Vector3d(-0.01, 0.01, 0.01), Eigen::Vector3d(0.01, 0.01, 0.0)}) {
    std::vector<Violation> broken;
    const MeshSettings settings{.voxel = 0.002, .surround = Surround{"soft", {0.0, 0.0, 0.0}, max}};
    (void)mesh_tissue({}, settings, {}, broken);
    CHECK(std::ranges::any_of(
        broken, [](const Violation& each) { return each.key == "tissue.mesh.surround.max"; }));
  }
}

TEST("what surrounds bodies fills the rest of its box, and nodes of bone never move") {
  const MeshSettings settings{.voxel = 0.002,
                              .surround = Surround{"soft", {0.0, 0.0, 0.0}, {0.01, 0.01, 0.01}}};
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
  CHECK_CONTAINS(refusal({}, {}), "tissue.mesh.files: is missing");
  CHECK_CONTAINS(
      refusal({body(box, "wood")}, {}),
      "tissue.mesh.files[0].material: unknown material \"wood\"; known are soft, stiff, bone");
  CHECK_CONTAINS(refusal({body(box, "soft")}, {.voxel = 1e-6}),
                 "1e+12 voxels around the bodies of 0.01 m; at most 1e8");
  const TriangleSurface plate = box_surface({0.0, 0.0, 0.0001}, {0.01, 0.01, 0.0005});
  CHECK_CONTAINS(refusal({body(plate, "soft")}, {}),
                 "no voxel's centre is inside soft.stl, which is thinner");
  TriangleSurface open = box;
  open.triangle.pop_back();
  CHECK_CONTAINS(refusal({body(open, "soft")}, {}),
                 "tissue.mesh.files[0].path: soft.stl: open: edge");
}

Scene scene_of(const std::vector<MeshBody>& bodies) {
  Scene scene;
  scene.materials = materials;
  scene.tissue.source = Source::mesh;
  scene.tissue.voxels = std::make_shared<const VoxelTissue>(build(bodies, {.voxel = 0.002}));
  return scene;
}

TEST("the intervals of a needle are the bodies on its line and the gaps between them") {
  Scene scene = scene_of({body(box_surface({-0.01, -0.01, 0.0}, {0.01, 0.01, 0.01}), "soft"),
                          body(box_surface({-0.01, -0.01, 0.014}, {0.01, 0.01, 0.02}), "stiff"),
                          body(box_surface({-0.01, -0.01, 0.02}, {0.01, 0.01, 0.03}), "bone")});
  scene.needle = Needle{};
  const NeedlePath path(scene, build_network(scene));
  CHECK_NEAR(double(path.intervals().size()), 4.0, 0.0);
  const std::vector<std::string> labels{"soft", "gap", "stiff", "bone"};
  const std::vector<double> begins{0.0, 0.01, 0.014, 0.02};
  REQUIRE(path.intervals().size() == labels.size());
  for (std::size_t n = 0; n < labels.size(); ++n) {
    CHECK(path.intervals()[n].label == labels[n]);
    CHECK_NEAR(path.intervals()[n].begin, begins[n], 1e-12);
    if (n + 1 < labels.size()) { CHECK_NEAR(path.intervals()[n].end, begins[n + 1], 1e-12); }
  }
  CHECK_NEAR(path.bone(), 0.02, 1e-12);
  CHECK_NEAR(double(path.knots().size()), 6.0 + 9.0, 0.0);  // planes of nodes; none in the gap
  scene.needle->direction = {std::tan(0.3), 0.0, 1.0};
  const NeedlePath slanted(scene, build_network(scene));
  CHECK_NEAR(slanted.intervals()[0].end, 0.01 / std::cos(0.3), 1e-12);
  CHECK_NEAR(slanted.bone(), 0.02 / std::cos(0.3), 1e-12);
}

TEST("a short gap before the first voxels of a line is filled by them, a long one stays") {
  for (const double low : {0.004, 0.006}) {  // length of the body on the line: two and three voxels
    const Scene scene =
        scene_of({body(box_surface({-0.01, -0.01, 0.0}, {0.0, 0.01, 0.02}), "stiff"),
                  body(box_surface({0.0, -0.01, low}, {0.01, 0.01, 0.02}), "soft")});
    const auto line = intervals_along(scene, {0.0005, 0.0, 0.0}, Vector3d::UnitZ(), 0.0);
    const bool joined = low < 0.005;
    CHECK(line.front().label == (joined ? "soft" : "gap"));
    CHECK_NEAR(line.front().begin, 0.0, 0.0);
    CHECK_NEAR(double(line.size()), joined ? 1.0 : 2.0, 0.0);
  }
}

}  // namespace PALPATE_FILE
