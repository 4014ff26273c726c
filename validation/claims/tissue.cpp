// SPDX-License-Identifier: MIT
/// Voxels of solids with known volume, a voxelised cube under load, and a phantom image.

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <array>
#include <numbers>

#include "model/problem/needle_path.hpp"
#include "model/tissue/image_tissue.hpp"
#include "model/tissue/network_builder.hpp"
#include "model/tissue/skin.hpp"
#include "model/tissue/solids.hpp"
#include "model/tissue/tissue_grid.hpp"
#include "model/tissue/voxel_tissue.hpp"
#include "reference/exact_problems.hpp"
#include "reference/static_equilibrium.hpp"
#include "validation/claims/groups.hpp"
#include "validation/claims/network_fixture.hpp"

namespace palpate {

namespace {

using Eigen::Vector3d;

struct Solid {
  std::string name{};
  TriangleSurface surface{};
  double volume = 0.0;  ///< exact volume of the solid that the triangles represent [m^3]
};

std::vector<Solid> solids() {
  constexpr double pi = std::numbers::pi;
  const double radius = 0.02;
  const double thickness = 0.006;
  const double disc = pi * thickness * thickness;
  const Vector3d plate(0.04, 0.03, 0.0045);
  const Vector3d corner(0.0003, 0.0002, 0.0001);
  // Faces fine enough that chords take less than 1e-3 of the volume.
  return {{"sphere", sphere_surface({0.0013, 0.0007, 0.0021}, radius, 60),
           4.0 / 3.0 * pi * radius * radius * radius},
          {"torus", ring_surface(radius, thickness, 2.0 * pi, 240, 120), 2.0 * pi * radius * disc},
          {"letter C", ring_surface(radius, thickness, 4.5, 240, 120), 4.5 * radius * disc},
          {"thin plate", box_surface(corner, corner + plate), plate.prod()}};
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
  Table& table = outcome.table(
      "volumes", "Volumes", "",
      {"solid", "voxel (mm)", "voxels", "volume (cm^3)", "error (%)", "of its limit (1)"});
  Largest worst;
  Largest chords;
  std::size_t apart = 0;
  for (const Solid& solid : solids()) {
    const double area = area_of(solid.surface);
    chords.add(std::abs(moments_of(solid.surface).volume / solid.volume - 1.0));
    for (const double h : {0.004, 0.002, 0.001, 0.0005}) {
      const BoxGrid grid = cubes_around(solid.surface.vertex.rowwise().minCoeff(),
                                        solid.surface.vertex.rowwise().maxCoeff(), h);
      const VoxelBody body = voxelise(solid.surface, grid);
      const double error = body.volume - solid.volume;
      const double share = std::abs(error) / (0.5 * std::sqrt(3.0) * area * h);
      worst.add(share);
      apart += voxelise(solid.surface, grid).inside == body.inside ? 0U : 1U;
      table.rows.push_back({solid.name, 1e3 * h, body.voxel_count, 1e6 * body.volume,
                            100.0 * error / solid.volume, share});
    }
  }
  outcome.judge_at_most(
      "error of volume, of sqrt(3)/2 h times the surface", worst.value(), 1.0,
      "theory: a cell that is wrong in part lies within half its diagonal of the surface");
  outcome.judge_at_most(
      "volume of the faces against the solid's closed form", chords.value(), 2e-3,
      "theory: chords of 120 sides enclose 1 - sin(2 pi/120)/(2 pi/120) less, both ways round");
  outcome.judge_at_most("voxelisations that differ from the first", double(apart), 0.0,
                        "theory: nothing of chance takes part");
}

const std::vector<Material> phantom_materials{
    {.name = "soft", .youngs_modulus = 2e3, .density = 900.0},
    {.name = "stiff", .youngs_modulus = 2e6, .density = 1100.0}};

/// Returns the compliance for a force on the middle of the skin [m/N].
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
  (problem.network().rest_position.colwise() - Vector3d(centre.x(), centre.y(), 0.0))
      .colwise()
      .squaredNorm()
      .minCoeff(&middle);
  push(problem.coordinate(static_cast<int>(middle)) + 2) = 1.0;
  return reference::StaticResponse(problem).compliance(push);
}

void measure_cube(const CaseContext& context, Outcome& outcome) {
  const double h = 0.002;
  const MeshBody body{.name = "cube",
                      .surface = box_surface({0, 0, 0}, Vector3d::Constant(10.0 * h)),
                      .material = "soft"};
  std::vector<Violation> broken;
  const VoxelTissue cube = mesh_tissue({body}, {.voxel = h}, phantom_materials, broken);
  const Material& soft = phantom_materials.front();
  const SpringNetwork lattice = cell_lattice({{11, 11, 11}, h, 26}, [&](int, int, int) {
    return CellMaterial{soft.youngs_modulus, soft.density, soft.damping_ratio, {}};
  });
  outcome.judge_at_most(
      "compliance of a voxelised cube against the lattice's",
      std::abs(compliance(networks::candidate(context, cube.network)) / compliance(lattice) - 1.0),
      1e-10, "theory: the same springs; what two solves leave");
}

/// Layers of one brightness each, in units of a scanner.
/// Intensities of an image without symmetry, against means and percentiles computed afresh.
void measure_intensities(Outcome& outcome) {
  const std::array<int, 3> count{7, 6, 5};
  ImageVolume image{.format = "phantom", .count = count, .spacing = {1e-3, 1e-3, 1e-3}};
  const auto pixel = [](int i, int j, int l) { return (17 * i + 5 * j * j + 23 * l * l) % 101; };
  std::vector<double> sorted;
  for (int l = 0; l < count[2]; ++l) {
    for (int j = 0; j < count[1]; ++j) {
      for (int i = 0; i < count[0]; ++i) {
        image.value.push_back(static_cast<float>(pixel(i, j, l)));
        sorted.push_back(pixel(i, j, l));
      }
    }
  }
  std::ranges::sort(sorted);
  const auto percentile_of = [&](double percent) {
    const double place = 0.01 * percent * static_cast<double>(sorted.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    const double share = place - static_cast<double>(below);
    return (1.0 - share) * sorted[below] + share * sorted[below + 1];
  };
  const double low = percentile_of(4.0);
  const double high = percentile_of(93.0);
  std::vector<Violation> broken;
  const ImageSamples samples = sample_image(image, nullptr, {.percentiles = {4.0, 93.0}}, broken);
  Largest worst;
  std::size_t node = 0;
  for (int l = 0; l < count[2]; ++l) {
    for (int j = 0; j < count[1]; ++j) {
      for (int i = 0; i < count[0]; ++i, ++node) {
        double sum = 0.0;
        int pixels = 0;
        for (int y = std::max(0, j - 1); y <= std::min(count[1] - 1, j + 1); ++y) {
          for (int x = std::max(0, i - 1); x <= std::min(count[0] - 1, i + 1); ++x) {
            sum += pixel(x, y, l);
            ++pixels;
          }
        }
        const double expected = std::clamp((sum / pixels - low) / (high - low), 0.0, 1.0);
        worst.add(node < samples.intensity.size()
                      ? std::abs(static_cast<double>(samples.intensity[node]) - expected)
                      : std::nan(""));
      }
    }
  }
  outcome.judge_at_most("intensities against means of 3 x 3 pixels between percentiles",
                        worst.value(), 1e-6, "theory: single precision of a number below 1");
  // Fat is bright and water dark on a T1 image, so every tissue here is darker on a T2 image.
  const std::vector<LookupPoint> t1 = lookup_points(Weighting::t1);
  const std::vector<LookupPoint> t2 = lookup_points(Weighting::t2);
  Smallest ratio;
  for (std::size_t n = 0; n < t1.size(); ++n) {
    ratio.add(t1[n].material == t2[n].material ? t1[n].intensity / t2[n].intensity : std::nan(""));
  }
  outcome.judge_at_least("brightness of a tissue on T1 over that on T2", ratio.value(),
                         0.45 / 0.35 - 1e-12,
                         "least ratio of both tables: ligament 0.15 to 0.08, muscle 0.45 to 0.35, "
                         "fat 0.90 to 0.70");
}

/// A ball of heavy material in a block: what the block weighs more is its volume.
void measure_inclusion(const CaseContext& context, Outcome& outcome) {
  Scene scene;
  scene.tissue.source = Source::lattice;
  scene.tissue.lattice = {.nodes = {33, 33, 33}, .spacing = 1e-3, .material = "light"};
  scene.materials = {{.name = "light", .youngs_modulus = 1e4, .density = 1000.0},
                     {.name = "heavy", .youngs_modulus = 1e4, .density = 2000.0}};
  constexpr double diameter = 0.02;
  scene.tissue.inclusions = {
      {.centre = {0.0001, -0.0002, 0.0161}, .size = {diameter, 0.0, 0.0}, .material = "heavy"}};
  const SpringNetwork network = networks::candidate(context, build_network(scene));
  double mass = 0.0;
  for (int n = 0; n < network.node_count(); ++n) { mass += network.mass(n); }
  const double light = 1000.0 * std::pow(0.032, 3);
  const double ball = std::numbers::pi / 6.0 * std::pow(diameter, 3);
  outcome.judge_near("mass of an inclusion over that of its ball", (mass - light) / (1000.0 * ball),
                     1.0, 0.01,
                     "a cell is in or out by its centre: of 1,257 cells at the border the root of "
                     "their number, 35 of 4,189, may be too many or too few");
}

/// Largest distance of the elasticity of a homogeneous block of springs from that of an isotropic
/// body of Poisson's ratio 1/4, both over C11, by the energies of affine displacements.
double anisotropy(const SpringNetwork& network) {
  const NetworkProblem problem(network);
  const Eigen::SparseMatrix<double> stiffness = networks::stiffness_of(problem);
  const NodeVectors& rest = network.rest_position;
  const auto energy = [&](const Eigen::Matrix3d& strain) {
    const Eigen::VectorXd u = (strain * rest).eval().reshaped();
    return u.dot(stiffness * u);
  };
  const auto unit = [](int a, int b) {
    Eigen::Matrix3d strain = Eigen::Matrix3d::Zero();
    strain(a, b) = 1.0;
    return strain;
  };
  const double c11 = energy(unit(0, 0));
  Largest off;
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3;
    const double along = energy(unit(a, a));
    const double across = energy(unit(b, b));
    off.add(std::abs(along / c11 - 1.0));
    off.add(std::abs(energy(unit(a, b)) / c11 - 1.0 / 3.0));
    off.add(std::abs(energy(unit(a, a) + unit(b, b)) - along - across - 2.0 / 3.0 * c11) / c11);
  }
  return off.value();
}

void measure_image(const CaseContext& context, Outcome& outcome) {
  measure_intensities(outcome);
  measure_inclusion(context, outcome);
  ImageVolume image{.format = "phantom", .count = {9, 8, 12}, .spacing = {0.9e-3, 1.1e-3, 1.3e-3}};
  const auto brightness = [](int l) { return 300.0 + 50.0 * l; };
  for (int l = 0; l < 12; ++l) {
    image.value.insert(image.value.end(), 72, static_cast<float>(brightness(l)));
  }
  const ImageSettings settings{.percentiles = {0.0, 100.0},
                               .lookup = {{0.0, "stiff"}, {1.0, "soft"}}};
  std::vector<Violation> broken;
  const VoxelTissue tissue =
      image_tissue(image, nullptr, settings, phantom_materials, {0.0, 0.0}, broken);
  const auto modulus = [](int l) { return 2e6 * std::pow(1e-3, l / 11.0); };
  Largest worst;
  const SpringNetwork network = networks::candidate(context, tissue.network);
  for (const Spring& spring : network.springs) {
    const int la = spring.a / 72;
    const int lb = spring.b / 72;
    const bool upright = spring.b - spring.a == 72;
    const int i = spring.a % 9;
    const int j = spring.a / 9 % 8;
    const bool inside = i > 0 && i < 8 && j > 0 && j < 7;
    if (!upright || !inside) { continue; }
    const double unit = box_bonds(image.spacing, 26).stiffness[2];
    worst.add(std::abs(spring.stiffness / (unit * 0.5 * (modulus(la) + modulus(lb))) - 1.0));
  }
  outcome.judge_equal("nodes of a phantom of 9 x 8 x 12 pixels", double(network.node_count()),
                      864.0, "theory: one a pixel");
  outcome.judge_at_most("stiffness of springs along z against the lookup in closed form",
                        worst.value(), 1e-5,
                        "theory: intensities in single precision, E = 2e6 Pa * 1e-3^I");
  Largest uneven;
  const ImageSettings alike{.percentiles = {0.0, 100.0}, .lookup = {{0.0, "soft"}, {1.0, "soft"}}};
  for (const Vector3d& size : {image.spacing, Vector3d(1.0e-3, 1.05e-3, 1.1e-3)}) {
    image.spacing = size;
    uneven.add(anisotropy(networks::candidate(
        context,
        image_tissue(image, nullptr, alike, phantom_materials, {0.0, 0.0}, broken).network)));
  }
  outcome.judge_at_most("elasticity of uneven boxes against an isotropic body's", uneven.value(),
                        1e-11,
                        "theory: boxes this near to cubes can be isotropic; rounding of a sum over "
                        "8,000 springs");
}

// A rigid sphere, pressed without friction into a half space of voxels, against Hertz's solution
// (Johnson, Contact Mechanics, 1985, sections 3.2 and 4.2), on three grids.

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double poisson = 0.25;          // of a network whose springs pull along their axes
constexpr double modulus = 10e3;          // E [Pa]
constexpr double sphere = 0.02;           // R [m]
constexpr double contact = 0.002;         // a [m]; strains are about 0.2 a / R
constexpr double reach = 6.0 * contact;   // of the grid, sideways and down [m]
constexpr double widest = 1.5 * contact;  // nodes that may touch [m]

double indentation() { return contact * contact / sphere; }

double hertz_force() {
  return 4.0 / 3.0 * modulus / (1.0 - poisson * poisson) * std::sqrt(sphere) *
         std::pow(indentation(), 1.5);
}

/// Displacement by one newton along z at the origin of a half space z >= 0 (Boussinesq).
Vector3d point_load(const Vector3d& at) {
  const double rho = at.norm();
  const double factor = (1.0 + poisson) / (2.0 * std::numbers::pi * modulus * rho);
  const double sideways = at.z() / (rho * rho) - (1.0 - 2.0 * poisson) / (rho + at.z());
  return factor * Vector3d(at.x() * sideways, at.y() * sideways,
                           2.0 * (1.0 - poisson) + at.z() * at.z() / (rho * rho));
}

/// A block of a half space, of the symmetry of a square. Its faces within the body move as those of
/// the half space do under the whole force in one point.
class HalfSpace {
 public:
  explicit HalfSpace(int cells)
      : cells_(cells),
        spacing_(reach / cells),
        shape_{{2 * cells + 1, 2 * cells + 1, cells + 1}, spacing_, 26} {
    number();
    const NetworkProblem problem(cell_lattice(shape_, [](int, int, int) {
      return CellMaterial{modulus, 1000.0, 0.0, {}};
    }));
    const Eigen::SparseMatrix<double> stiffness = reference::LinearProblem(problem).stiffness();
    const Eigen::SparseMatrix<double> all = all_from_free();
    response_.emplace(Eigen::SparseMatrix<double>(all.transpose() * stiffness * all));
    far_ = (*response_)(-(all.transpose() * (stiffness * far_field())));
  }

  /// Force on a rigid sphere at the given indentation [N].
  [[nodiscard]] double force(double depth) const {
    std::vector<std::array<int, 2>> nodes;
    for (int j = 0; j <= cells_; ++j) {
      for (int i = 0; i <= cells_; ++i) {
        if (std::hypot(i, j) * spacing_ <= widest) { nodes.push_back({i, j}); }
      }
    }
    const auto count = static_cast<Eigen::Index>(nodes.size());
    MatrixXd sinking(count, count);  // of node m by one newton on each image of n
    VectorXd images(count), profile(count);
    for (Eigen::Index n = 0; n < count; ++n) {
      const auto [i, j] = nodes[static_cast<std::size_t>(n)];
      images(n) = (i > 0 ? 2.0 : 1.0) * (j > 0 ? 2.0 : 1.0);
      profile(n) = depth - spacing_ * spacing_ * (i * i + j * j) / (2.0 * sphere);
      VectorXd load = VectorXd::Zero(far_.size());
      load(free_at(i, j)) = images(n);
      const VectorXd moved = (*response_)(load) + images(n) * far_;
      for (Eigen::Index m = 0; m < count; ++m) {
        const auto [k, l] = nodes[static_cast<std::size_t>(m)];
        sinking(m, n) = moved(free_at(k, l));
      }
    }
    return images.dot(contact_forces(sinking, profile));
  }

 private:
  [[nodiscard]] bool within(int i, int j, int l) const {
    return i < cells_ && j < cells_ && l < cells_;
  }
  [[nodiscard]] Eigen::Index place(int i, int j, int l, int axis) const {
    return 3 * ((Eigen::Index{l} * cells_ + j) * cells_ + i) + axis;
  }
  [[nodiscard]] Eigen::Index free_at(int i, int j) const {  ///< z at the surface
    return number_[static_cast<std::size_t>(place(i, j, 0, 2))];
  }

  /// Numbers the free coordinates of a quarter; nodes in its symmetry planes stay in them.
  void number() {
    number_.assign(static_cast<std::size_t>(3 * cells_ * cells_ * cells_), -1);
    for (int l = 0; l < cells_; ++l) {
      for (int j = 0; j < cells_; ++j) {
        for (int i = 0; i < cells_; ++i) {
          for (int axis = 0; axis < 3; ++axis) {
            const bool held = (axis == 0 && i == 0) || (axis == 1 && j == 0);
            if (!held) { number_[static_cast<std::size_t>(place(i, j, l, axis))] = free_count_++; }
          }
        }
      }
    }
  }

  template <class Each> void for_each_node(Each&& each) const {
    for (int node = 0; node < shape_.node_count(); ++node) {
      const auto [i, j, l] = shape_.place(node);
      each(node, i - cells_, j - cells_, l);
    }
  }

  [[nodiscard]] Eigen::SparseMatrix<double> all_from_free() const {
    std::vector<Eigen::Triplet<double>> entries;
    for_each_node([&](int node, int i, int j, int l) {
      if (!within(std::abs(i), std::abs(j), l)) { return; }
      for (int axis = 0; axis < 3; ++axis) {
        const auto n = number_[static_cast<std::size_t>(place(std::abs(i), std::abs(j), l, axis))];
        const bool mirrored = (axis == 0 && i < 0) || (axis == 1 && j < 0);
        if (n >= 0) { entries.emplace_back(3 * node + axis, n, mirrored ? -1.0 : 1.0); }
      }
    });
    Eigen::SparseMatrix<double> all(3 * Eigen::Index{shape_.node_count()}, free_count_);
    all.setFromTriplets(entries.begin(), entries.end());
    return all;
  }

  [[nodiscard]] VectorXd far_field() const {
    VectorXd field = VectorXd::Zero(3 * Eigen::Index{shape_.node_count()});
    for_each_node([&](int node, int i, int j, int l) {
      if (within(std::abs(i), std::abs(j), l)) { return; }
      field.segment<3>(3 * Eigen::Index{node}) = point_load(spacing_ * Vector3d(i, j, l));
    });
    return field;
  }

  /// Nodes touch where they push, and none is inside the sphere.
  static VectorXd contact_forces(const MatrixXd& sinking, const VectorXd& profile) {
    std::vector<Eigen::Index> touching;
    for (Eigen::Index n = 0; n < profile.size(); ++n) {
      if (profile(n) > 0.0) { touching.push_back(n); }
    }
    VectorXd forces;
    for (bool changed = true; changed;) {
      forces = VectorXd::Zero(profile.size());
      const MatrixXd among = sinking(touching, touching);
      const VectorXd wanted = profile(touching);
      const VectorXd found = among.partialPivLu().solve(wanted);
      forces(touching) = found;
      std::vector<Eigen::Index> next;
      const VectorXd moved = sinking * forces;
      for (Eigen::Index n = 0; n < profile.size(); ++n) {
        const bool touched = std::ranges::binary_search(touching, n);
        if (touched ? forces(n) > 0.0 : moved(n) < profile(n)) { next.push_back(n); }
      }
      changed = next != touching;
      touching = std::move(next);
    }
    return forces;
  }

  int cells_;
  double spacing_;
  LatticeShape shape_;
  std::vector<Eigen::Index> number_{};
  Eigen::Index free_count_ = 0;
  std::optional<reference::StaticResponse> response_{};
  VectorXd far_{};  ///< under one newton, by the faces alone
};

void measure_hertz(const CaseContext& context, Outcome& outcome) {
  Table& table = outcome.table(
      "grids", "Force on the sphere",
      "At an indentation of 0.2 mm: R = 20 mm, a = 2 mm, E = 10 kPa, Poisson's ratio 1/4.",
      {"spacing (mm)", "nodes across the contact", "force (mN)", "error (%)"});
  std::vector<double> spacings;
  std::vector<double> forces;
  for (const int cells : context.quick ? std::array{8, 12, 18} : std::array{12, 18, 27}) {
    spacings.push_back(reach / cells);
    forces.push_back(HalfSpace(cells).force(indentation()));
    table.rows.push_back({1e3 * reach / cells, 2.0 * contact * cells / reach, 1e3 * forces.back(),
                          100.0 * (forces.back() / hertz_force() - 1.0)});
  }
  const auto [order, index] = grid_convergence(spacings, forces);
  constexpr double faces =
      0.4 / 36.0;  // second moment of Hertz's pressure over the square of the reach
  outcome.judge_at_most(
      "force of the finest grid against Hertz, relative", std::abs(forces[2] / hertz_force() - 1.0),
      index + faces,
      "theory: the grid convergence index of three grids, and 0.4 (a / reach)^2 for the faces");
  outcome.report("order of convergence", order);
  outcome.judge_at_most("grid convergence index", index, 0.05, "wanted: a claim worth making");
}

// Layers beneath a cylindrical skin: volumes, path of a needle, motion of the surface.

constexpr double radius = 0.1;      // of the skin, about an axis along y [m]
constexpr double half = 0.04;       // of the block's edges along x and y [m]
constexpr double depth = 0.04;      // of the block beneath the highest line of the skin [m]
constexpr double thickness = 0.01;  // of the outer layer [m]
constexpr int facets = 100;         // across the skin

/// Area between the arc of a circle about (0, R) and z = R, for |x| <= half.
double area_under_arc(double arc) {
  return half * std::sqrt(arc * arc - half * half) + arc * arc * std::asin(half / arc);
}

/// Volumes of the outer layer and of the tissue below it [m^3].
std::array<double, 2> volumes() {
  const double outer = area_under_arc(radius) - area_under_arc(radius - thickness);
  const double all = area_under_arc(radius) - 2.0 * half * (radius - depth);
  return {2.0 * half * outer, 2.0 * half * (all - outer)};
}

Scene cylinder(double spacing, const std::array<double, 2>& densities) {
  Scene scene;
  const int nodes = static_cast<int>(std::lround(2.0 * half / spacing)) + 1;
  scene.tissue.source = Source::layers;
  scene.tissue.block = {.nodes = {nodes, nodes}, .spacing = spacing};
  scene.tissue.layers = {{"outer", "outer", thickness}, {"inner", "inner", depth - thickness}};
  scene.materials = {
      {.name = "outer", .youngs_modulus = 2e4, .density = densities[0], .cutting_force = 1.0},
      {.name = "inner", .youngs_modulus = 5e3, .density = densities[1], .cutting_force = 0.5}};
  const auto arc = [](double x, double /*y*/) {
    return radius - std::sqrt(radius * radius - x * x);
  };
  scene.tissue.skin =
      std::make_shared<const Skin>(patch_surface({1.25 * half, 1.25 * half}, facets, arc), true);
  return scene;
}

void measure_volumes(Outcome& outcome) {
  Table& table = outcome.table("volumes", "Volumes of two layers", "",
                               {"spacing (mm)", "nodes", "outer (cm^3)", "error (%)",
                                "inner (cm^3)", "error (%)", "of their limit (1)"});
  const std::array<double, 2> exact = volumes();
  Largest worst;
  for (const double spacing : {0.004, 0.002, 0.00125}) {
    const SpringNetwork even = build_network(cylinder(spacing, {1.0, 1.0}));
    const SpringNetwork dense_outside = build_network(cylinder(spacing, {1001.0, 1.0}));
    const double outer = (dense_outside.mass.sum() - even.mass.sum()) / 1000.0;
    const std::array<double, 2> found{outer, even.mass.sum() - outer};
    const double limit = 0.5 * spacing * 4.0 * half * half;
    Largest error(std::abs(found[0] - exact[0]));
    error.add(std::abs(found[1] - exact[1]));
    const double share = error.value() / limit;
    worst.add(share);
    table.rows.push_back({1e3 * spacing, even.node_count(), 1e6 * found[0],
                          100.0 * (found[0] / exact[0] - 1.0), 1e6 * found[1],
                          100.0 * (found[1] / exact[1] - 1.0), share});
  }
  outcome.judge_at_most("error of the layers' volumes, of h/2 times the block's section",
                        worst.value(), 1.0,
                        "theory: a column of cells begins within h/2 of the skin above its middle");
}

/// Depth at which a line through the axis' plane enters the cylinder of a radius.
double meets(const Vector3d& origin, const Vector3d& n, double of_radius) {
  const Eigen::Vector2d from(origin.x(), origin.z() - radius);
  const Eigen::Vector2d way(n.x(), n.z());
  const double half_b = from.dot(way) / way.squaredNorm();
  const double c = (from.squaredNorm() - of_radius * of_radius) / way.squaredNorm();
  return -half_b - std::sqrt(half_b * half_b - c);
}

void measure_line(Outcome& outcome) {
  Scene scene = cylinder(0.004, {1000.0, 1000.0});
  const double facet = 2.5 * half / facets;
  Largest worst;
  for (const double entry : {-0.024, -0.01, 0.0, 0.017}) {
    for (const double lean : {-0.3, 0.0, 0.4}) {
      const Vector3d origin(entry, 0.003, 0.0);
      const Vector3d n = Vector3d(lean, 0.1, 1.0).normalized();
      const double skin = meets(origin, n, radius);
      const auto line =
          intervals_along(scene, origin, n, skin + 1e-3);  // as nodes may begin below the skin
      const double expected = meets(origin, n, radius - thickness) - skin;
      worst.add(line.size() < 2 ? 1.0 : std::abs(line[0].end - line[0].begin - expected));
    }
  }
  // A chord lies within the sagitta of its arc; the steepest of these lines crosses at cos = 0.6.
  outcome.judge_at_most(
      "way of a needle through the outer layer", worst.value(),
      2.0 * facet * facet / (8.0 * radius) / 0.6 + 2e-9,
      "theory: the sagitta of a face at either end, along the line; a search to 1e-9 m", "m");
}

void measure_surface(Outcome& outcome) {
  const Scene scene = cylinder(0.004, {1000.0, 1000.0});
  const SpringNetwork network = build_network(scene);
  const NodeVectors& points = scene.tissue.skin->surface().vertex;
  const auto embedded = embed(points, *tissue_grid(scene));
  const Vector3d shift(1e-3, -2e-3, 5e-3);
  const NodeVectors moved =
      carried(points, embedded, network.rest_position, network.rest_position.colwise() + shift);
  Largest worst;
  long above = 0;
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    const bool over_block = std::max(std::abs(points(0, p)), std::abs(points(1, p))) <= half;
    if (!over_block) { continue; }
    ++above;
    worst.add((moved.col(p) - points.col(p) - shift).cwiseAbs().maxCoeff());
  }
  outcome.judge_at_most("skin over the block against a movement of the whole block",
                        above > 0 ? worst.value() : 1.0, 1e-15,
                        "theory: weights sum to one; what rounding leaves of 5e-3 m", "m");
}

void measure_skin(const CaseContext& /*context*/, Outcome& outcome) {
  measure_volumes(outcome);
  measure_line(outcome);
  measure_surface(outcome);
}

}  // namespace

std::vector<Case> tissue_cases() {
  return {
      {"tissue/surfaces", "model",
       "Voxels of a sphere, a torus, a letter C and a thin plate come to their volumes at "
       "first order, the same every time",
       measure_surfaces, 5.0},
      {"tissue/cube", "model",
       "A voxelised cube gives way under a push as the lattice of its size does", measure_cube,
       1.0},
      {"tissue/image", "model",
       "A phantom image becomes the nodes and springs that its brightness says, and an inclusion "
       "has its volume",
       measure_image, 1.0},
      {"tissue/skin", "model",
       "Layers beneath a curved skin have their volumes at first order and their thickness to "
       "the skin's facets, and the skin goes with them",
       measure_skin, 1.0},
      {"tissue/hertz", "model",
       "A sphere pressed into a block of voxels meets the force of Hertz's solution for "
       "Poisson's ratio 1/4",
       measure_hertz, 30.0}};
}

}  // namespace palpate
