// SPDX-License-Identifier: MIT
/// Layers beneath a skin that is part of a cylinder: their volumes, where a needle meets them, and what their
/// surface does when they move.
#include <array>
#include <cmath>

#include "model/dynamics/embedded_surface.hpp"
#include "model/dynamics/needle_path.hpp"
#include "model/dynamics/network_builder.hpp"
#include "model/dynamics/skin.hpp"
#include "model/dynamics/tissue_grid.hpp"
#include "reference/solids.hpp"
#include "validation/cases/patient_tissue.hpp"

namespace palpate {

namespace {

using Eigen::Vector3d;

constexpr double radius = 0.1;     // of the skin, about an axis along y [m]
constexpr double half = 0.04;      // of the block's edges along x and y [m]
constexpr double depth = 0.04;     // of the block beneath the highest line of the skin [m]
constexpr double thickness = 0.01; // of the outer layer [m]
constexpr int facets = 100;        // across the skin

/// Area between the arc of a circle about (0, R) and z = R, for |x| <= half.
double area_under_arc(double arc) {
  return half * std::sqrt(arc * arc - half * half) + arc * arc * std::asin(half / arc);
}

/// Of the outer layer and of what lies beneath it [m^3].
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
  scene.materials = {{.name = "outer", .youngs_modulus = 2e4, .density = densities[0], .cutting_force = 1.0},
                     {.name = "inner", .youngs_modulus = 5e3, .density = densities[1], .cutting_force = 0.5}};
  const auto arc = [](double x, double /*y*/) { return radius - std::sqrt(radius * radius - x * x); };
  scene.tissue.skin =
      std::make_shared<const Skin>(reference::patch_surface({1.25 * half, 1.25 * half}, facets, arc), true);
  return scene;
}

void measure_volumes(Outcome& outcome) {
  Table table{.id = "volumes",
              .title = "Volumes of two layers",
              .columns = {"spacing (mm)", "nodes", "outer (cm^3)", "error (%)", "inner (cm^3)", "error (%)",
                          "of their limit (1)"}};
  const std::array<double, 2> exact = volumes();
  double worst = 0.0;
  for (const double spacing : {0.004, 0.002, 0.00125}) {
    const SpringNetwork even = build_network(cylinder(spacing, {1.0, 1.0}));
    const SpringNetwork dense_outside = build_network(cylinder(spacing, {1001.0, 1.0}));
    const double outer = (dense_outside.mass.sum() - even.mass.sum()) / 1000.0;
    const std::array<double, 2> found{outer, even.mass.sum() - outer};
    const double limit = 0.5 * spacing * 4.0 * half * half;
    const double share = std::max(std::abs(found[0] - exact[0]), std::abs(found[1] - exact[1])) / limit;
    worst = std::max(worst, share);
    table.rows.push_back({1e3 * spacing, double(even.node_count()), 1e6 * found[0], 100.0 * (found[0] / exact[0] - 1.0),
                          1e6 * found[1], 100.0 * (found[1] / exact[1] - 1.0), share});
  }
  outcome.tables.push_back(std::move(table));
  outcome.judge({.name = "error of the layers' volumes, of h/2 times the block's section",
                 .value = worst,
                 .upper = 1.0,
                 .bound_from = "theory: a column of cells begins within h/2 of the skin above its middle"});
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
  double worst = 0.0;
  for (const double entry : {-0.024, -0.01, 0.0, 0.017}) {
    for (const double lean : {-0.3, 0.0, 0.4}) {
      const Vector3d origin(entry, 0.003, 0.0);
      const Vector3d n = Vector3d(lean, 0.1, 1.0).normalized();
      const double skin = meets(origin, n, radius);
      const auto line = intervals_along(scene, origin, n, skin + 1e-3);  // as nodes may begin below the skin
      const double expected = meets(origin, n, radius - thickness) - skin;
      worst = std::max(worst, line.size() < 2 ? 1.0 : std::abs(line[0].end - line[0].begin - expected));
    }
  }
  // A chord lies within the sagitta of its arc; the steepest of these lines crosses at cos = 0.6.
  outcome.judge({.name = "way of a needle through the outer layer",
                 .value = worst,
                 .unit = "m",
                 .upper = 2.0 * facet * facet / (8.0 * radius) / 0.6 + 2e-9,
                 .bound_from = "theory: the sagitta of a face at either end, along the line; a search to 1e-9 m"});
}

void measure_surface(Outcome& outcome) {
  const Scene scene = cylinder(0.004, {1000.0, 1000.0});
  const SpringNetwork network = build_network(scene);
  const NodeVectors& points = scene.tissue.skin->surface().vertex;
  const auto embedded = embed(points, *tissue_grid(scene));
  const Vector3d shift(1e-3, -2e-3, 5e-3);
  const NodeVectors moved = carried(points, embedded, network.rest_position, network.rest_position.colwise() + shift);
  double worst = 0.0;
  long above = 0;
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    const bool over_block = std::max(std::abs(points(0, p)), std::abs(points(1, p))) <= half;
    if (!over_block) { continue; }
    ++above;
    worst = std::max(worst, (moved.col(p) - points.col(p) - shift).cwiseAbs().maxCoeff());
  }
  outcome.judge({.name = "skin over the block against a movement of the whole block",
                 .value = above > 0 ? worst : 1.0,
                 .unit = "m",
                 .upper = 1e-15,
                 .bound_from = "theory: weights sum to one; what rounding leaves of 5e-3 m"});
}

void measure(const CaseContext& /*context*/, Outcome& outcome) {
  measure_volumes(outcome);
  measure_line(outcome);
  measure_surface(outcome);
}

}  // namespace

Case skin_case() {
  return {.name = "tissue/skin",
          .suite = "model",
          .claim = "Layers beneath a curved skin have their volumes at first order and their thickness to the skin's "
                   "facets, and the skin goes with them",
          .measure = measure,
          .quick = false};
}

}  // namespace palpate
