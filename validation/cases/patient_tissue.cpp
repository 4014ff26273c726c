// SPDX-License-Identifier: MIT
/// Voxels of solids whose volume is known, a voxelised cube under load, and a phantom image.
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "model/dynamics/box_bonds.hpp"
#include "model/dynamics/image_tissue.hpp"
#include "model/dynamics/lattice.hpp"
#include "model/dynamics/mesh_tissue.hpp"
#include "model/dynamics/problem.hpp"
#include "reference/solids.hpp"
#include "reference/static_response.hpp"
#include "validation/cases/patient_tissue.hpp"

namespace palpate {

namespace {

using Eigen::Vector3d;

struct Solid {
  std::string name{};
  TriangleSurface surface{};
  double volume = 0.0;  ///< exact, of the solid that the triangles stand for [m^3]
};

std::vector<Solid> solids() {
  constexpr double pi = std::numbers::pi;
  const double radius = 0.02;
  const double thickness = 0.006;
  const double disc = pi * thickness * thickness;
  const Vector3d plate(0.04, 0.03, 0.0045);
  const Vector3d corner(0.0003, 0.0002, 0.0001);
  // Faces fine enough that chords take less than 1e-3 of the volume.
  return {{"sphere", reference::sphere_surface({0.0013, 0.0007, 0.0021}, radius, 60), 4.0 / 3.0 * pi * radius * radius * radius},
          {"torus", reference::ring_surface(radius, thickness, 2.0 * pi, 240, 120), 2.0 * pi * radius * disc},
          {"letter C", reference::ring_surface(radius, thickness, 4.5, 240, 120), 4.5 * radius * disc},
          {"thin plate", reference::box_surface(corner, corner + plate), plate.prod()}};
}

double area_of(const TriangleSurface& surface) {
  double area = 0.0;
  for (int f = 0; f < static_cast<int>(surface.triangle.size()); ++f) {
    const Vector3d a = surface.corner(f, 0);
    area += 0.5 * (surface.corner(f, 1) - a).cross(surface.corner(f, 2) - a).norm();
  }
  return area;
}

void measure_surfaces(const CaseContext& /*context*/, Outcome& outcome) {
  Table table{.id = "volumes",
              .title = "Volumes",
              .columns = {"solid", "voxel (mm)", "voxels", "volume (cm^3)", "error (%)", "of its limit (1)"}};
  double worst = 0.0;
  double chords = 0.0;
  std::size_t apart = 0;
  for (const Solid& solid : solids()) {
    const double area = area_of(solid.surface);
    chords = std::max(chords, std::abs(moments_of(solid.surface).volume / solid.volume - 1.0));
    for (const double h : {0.004, 0.002, 0.001, 0.0005}) {
      const BoxGrid grid = cubes_around(solid.surface.vertex.rowwise().minCoeff(),
                                        solid.surface.vertex.rowwise().maxCoeff(), h);
      const VoxelBody body = voxelise(solid.surface, grid);
      const double error = body.volume - solid.volume;
      const double share = std::abs(error) / (0.5 * std::sqrt(3.0) * area * h);
      worst = std::max(worst, share);
      apart += voxelise(solid.surface, grid).inside == body.inside ? 0U : 1U;
      table.rows.push_back({solid.name, 1e3 * h, double(body.voxel_count), 1e6 * body.volume,
                            100.0 * error / solid.volume, share});
    }
  }
  outcome.tables.push_back(std::move(table));
  outcome.judge({.name = "error of volume, of sqrt(3)/2 h times the surface",
                 .value = worst,
                 .upper = 1.0,
                 .bound_from = "theory: a cell that is wrong in part lies within half its diagonal of the surface"});
  outcome.judge({.name = "volume of the faces against the solid's closed form",
                 .value = chords,
                 .upper = 2e-3,
                 .bound_from = "theory: chords of 120 sides enclose 1 - sin(2 pi/120)/(2 pi/120) less, both ways round"});
  outcome.judge({.name = "voxelisations that differ from the first",
                 .value = double(apart),
                 .upper = 0.0,
                 .bound_from = "theory: nothing of chance takes part"});
}

const std::vector<Material>& phantom_materials() {
  static const std::vector<Material> materials{{.name = "soft", .youngs_modulus = 2e3, .density = 900.0},
                                               {.name = "stiff", .youngs_modulus = 2e6, .density = 1100.0}};
  return materials;
}

/// How far a push on the middle of the skin goes in [m/N].
double compliance(SpringNetwork network) {
  const NodeVectors& at = network.rest_position;
  const double bottom = at.row(2).maxCoeff();
  for (Eigen::Index i = 0; i < network.node_count(); ++i) {
    if (at(2, i) > bottom - 1e-9) { network.fixed[static_cast<std::size_t>(i)] = 1; }
  }
  const NetworkProblem problem(std::move(network));
  Eigen::VectorXd push = Eigen::VectorXd::Zero(problem.dof());
  Eigen::Index middle = 0;
  const Vector3d centre = problem.network().rest_position.rowwise().mean();
  (problem.network().rest_position.colwise() - Vector3d(centre.x(), centre.y(), 0.0)).colwise().squaredNorm().minCoeff(&middle);
  push(problem.coordinate(static_cast<int>(middle)) + 2) = 1.0;
  return reference::StaticResponse(problem).compliance(push);
}

void measure_cube(const CaseContext& /*context*/, Outcome& outcome) {
  const double h = 0.002;
  const MeshBody body{.name = "cube", .surface = reference::box_surface({0, 0, 0}, Vector3d::Constant(10.0 * h)), .material = "soft"};
  std::vector<Violation> broken;
  const VoxelTissue cube = mesh_tissue({body}, {.voxel = h}, phantom_materials(), broken);
  const Material& soft = phantom_materials().front();
  const SpringNetwork lattice = cell_lattice({{11, 11, 11}, h, 26}, [&](int, int, int) {
    return CellMaterial{soft.youngs_modulus, soft.density, soft.damping_ratio, {}};
  });
  outcome.judge({.name = "compliance of a voxelised cube against the lattice's",
                 .value = std::abs(compliance(cube.network) / compliance(lattice) - 1.0),
                 .upper = 1e-10,
                 .bound_from = "theory: the same springs; what two solves leave"});
}

/// Layers of one brightness each, in units of a scanner.
void measure_image(const CaseContext& /*context*/, Outcome& outcome) {
  ImageVolume image{.format = "phantom", .count = {9, 8, 12}, .spacing = {0.9e-3, 1.1e-3, 1.3e-3}};
  const auto brightness = [](int l) { return 300.0 + 50.0 * l; };
  for (int l = 0; l < 12; ++l) { image.value.insert(image.value.end(), 72, static_cast<float>(brightness(l))); }
  const ImageSettings settings{.percentiles = {0.0, 100.0}, .lookup = {{0.0, "stiff"}, {1.0, "soft"}}};
  std::vector<Violation> broken;
  const VoxelTissue tissue = image_tissue(image, nullptr, settings, phantom_materials(), {0.0, 0.0}, broken);
  const auto modulus = [](int l) { return 2e6 * std::pow(1e-3, l / 11.0); };
  double worst = 0.0;
  for (const Spring& spring : tissue.network.springs) {
    const int la = spring.a / 72;
    const int lb = spring.b / 72;
    const bool upright = spring.b - spring.a == 72;
    const int i = spring.a % 9;
    const int j = spring.a / 9 % 8;
    const bool inside = i > 0 && i < 8 && j > 0 && j < 7;
    if (!upright || !inside) { continue; }
    const double unit = box_bonds(image.spacing, 26).stiffness[2];
    worst = std::max(worst, std::abs(spring.stiffness / (unit * 0.5 * (modulus(la) + modulus(lb))) - 1.0));
  }
  outcome.judge({.name = "nodes of a phantom of 9 x 8 x 12 pixels", .value = double(tissue.network.node_count()), .lower = 864.0, .upper = 864.0, .bound_from = "theory: one a pixel"});
  outcome.judge({.name = "stiffness of springs along z against the lookup in closed form",
                 .value = worst,
                 .upper = 1e-5,
                 .bound_from = "theory: intensities in single precision, E = 2e6 Pa * 1e-3^I"});
  const Eigen::Matrix3d isotropic = Eigen::Matrix3d::Constant(0.4) + 0.8 * Eigen::Matrix3d::Identity();
  outcome.judge({.name = "elasticity of its boxes against an isotropic body's",
                 .value = (box_bonds(image.spacing, 26).elasticity - isotropic).cwiseAbs().maxCoeff(),
                 .upper = 1e-12,
                 .bound_from = "theory: boxes this near to cubes can be isotropic"});
}

}  // namespace

std::vector<Case> patient_tissue_cases() {
  return {{.name = "tissue/surfaces",
           .suite = "model",
           .claim = "Voxels of a sphere, a torus, a letter C and a thin plate come to their volumes at first order, "
                    "the same every time",
           .measure = measure_surfaces,
           .quick = false,
           .weight = 5.0},
          {.name = "tissue/cube",
           .suite = "model",
           .claim = "A voxelised cube gives way under a push as the lattice of its size does",
           .measure = measure_cube,
           .quick = false},
          {.name = "tissue/image",
           .suite = "model",
           .claim = "A phantom image becomes the nodes and springs that its brightness says",
           .measure = measure_image,
           .quick = false},
          skin_case(), hertz_case()};
}

}  // namespace palpate
