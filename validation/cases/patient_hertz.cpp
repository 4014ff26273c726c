// SPDX-License-Identifier: MIT
/// A rigid ball pressed into voxels of one material, against Hertz.
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/LU>

#include "model/dynamics/mesh_tissue.hpp"
#include "model/dynamics/network_builder.hpp"
#include "model/dynamics/problem.hpp"
#include "reference/solids.hpp"
#include "reference/static_response.hpp"
#include "validation/cases/patient_tissue.hpp"

namespace palpate {

namespace {

using Eigen::Vector3d;

constexpr double youngs_modulus = 1e4;  // [Pa]
constexpr double poisson = 0.25;        // of a lattice of springs
constexpr double contact = 0.006;       // radius of the contact by Hertz [m]
constexpr double ball = 0.06;           // radius of the ball [m]
constexpr double depth = contact * contact / ball;
constexpr double reach = 3.0 * contact;  // from the axis to the sides and to the bottom [m]

/// F = 4/3 E / (1 - nu^2) sqrt(R) d^(3/2) [N].
double hertz_force() {
  return 4.0 / 3.0 * youngs_modulus / (1.0 - poisson * poisson) * std::sqrt(ball) * std::pow(depth, 1.5);
}

/// Displacement of an elastic half-space under a force of 1 N on its surface at the origin (Boussinesq) [m].
Vector3d boussinesq(const Vector3d& at) {
  const double shear = youngs_modulus / (2.0 * (1.0 + poisson));
  const double scale = 1.0 / (4.0 * std::numbers::pi * shear);
  const double r = std::hypot(at.x(), at.y());
  const double rho = at.norm();
  const double along = at.z() * at.z() / (rho * rho * rho) + 2.0 * (1.0 - poisson) / rho;
  const double out = r * at.z() / (rho * rho * rho) - (1.0 - 2.0 * poisson) * r / (rho * (rho + at.z()));
  const double per_radius = r > 0.0 ? out / r : 0.0;
  return scale * Vector3d(per_radius * at.x(), per_radius * at.y(), along);
}

/// Nodes under the ball, and how far each gives way for a newton on every other; sides and bottom move as a half-space's
/// would under the sum of the forces.
struct Skin {
  std::vector<double> gap{};    ///< how far the ball would reach below each node [m]
  Eigen::MatrixXd compliance{};  ///< [m/N]
};

bool on_rim(const Vector3d& at) {
  constexpr double slack = 1e-9;
  return std::abs(at.x()) > reach - slack || std::abs(at.y()) > reach - slack || at.z() > reach - slack;
}

Skin skin_of(const SpringNetwork& network) {
  const NetworkProblem problem(network);
  Eigen::SparseMatrix<double> stiffness;
  Eigen::SparseMatrix<double> damping;
  const Eigen::VectorXd rest = problem.initial_position();
  problem.jacobian(rest, Eigen::VectorXd::Zero(problem.dof()), stiffness, damping);
  std::vector<Eigen::Index> place(static_cast<std::size_t>(problem.dof()), -1);
  Eigen::VectorXd rim = Eigen::VectorXd::Zero(problem.dof());
  Eigen::Index free = 0;
  std::vector<Eigen::Index> beneath;
  Skin skin;
  for (int node = 0; node < static_cast<int>(network.node_count()); ++node) {
    const Vector3d at = network.rest_position.col(node);
    if (on_rim(at)) {
      rim.segment<3>(3 * node) = boussinesq(at);
      continue;
    }
    const double away = std::hypot(at.x(), at.y());
    if (at.z() < 1e-9 && away <= 1.5 * contact) {
      beneath.push_back(free + 2);
      skin.gap.push_back(depth - away * away / (2.0 * ball));
    }
    for (int n = 0; n < 3; ++n) { place[static_cast<std::size_t>(3 * node + n)] = free++; }
  }
  const Eigen::VectorXd pull = stiffness * rim;
  std::vector<Eigen::Triplet<double>> kept;
  Eigen::VectorXd push = Eigen::VectorXd::Zero(free);
  for (Eigen::Index column = 0; column < stiffness.outerSize(); ++column) {
    const Eigen::Index to = place[static_cast<std::size_t>(column)];
    if (to < 0) { continue; }
    push(to) = -pull(column);
    for (Eigen::SparseMatrix<double>::InnerIterator entry(stiffness, column); entry; ++entry) {
      const Eigen::Index from = place[static_cast<std::size_t>(entry.row())];
      if (from >= 0) { kept.emplace_back(static_cast<int>(from), static_cast<int>(to), entry.value()); }
    }
  }
  Eigen::SparseMatrix<double> inner(free, free);
  inner.setFromTriplets(kept.begin(), kept.end());
  const reference::StaticResponse response(std::move(inner));
  const Eigen::VectorXd of_rim = response(push);
  skin.compliance.resize(static_cast<Eigen::Index>(beneath.size()), static_cast<Eigen::Index>(beneath.size()));
  for (std::size_t n = 0; n < beneath.size(); ++n) {
    Eigen::VectorXd one = Eigen::VectorXd::Zero(free);
    one(beneath[n]) = 1.0;
    const Eigen::VectorXd moved = response(one);
    for (std::size_t m = 0; m < beneath.size(); ++m) {
      skin.compliance(static_cast<Eigen::Index>(m), static_cast<Eigen::Index>(n)) = moved(beneath[m]) + of_rim(beneath[m]);
    }
  }
  return skin;
}

/// Forces that push only, on nodes that lie on the ball; elsewhere nodes lie below it. Their sum [N].
double contact_force(const Skin& skin) {
  std::vector<Eigen::Index> active;
  for (std::size_t n = 0; n < skin.gap.size(); ++n) {
    if (skin.gap[n] > 0.0) { active.push_back(static_cast<Eigen::Index>(n)); }
  }
  for (int round = 0; round < 100; ++round) {
    Eigen::VectorXd gap(static_cast<Eigen::Index>(active.size()));
    for (std::size_t n = 0; n < active.size(); ++n) {
      gap(static_cast<Eigen::Index>(n)) = skin.gap[static_cast<std::size_t>(active[n])];
    }
    const Eigen::MatrixXd part = skin.compliance(active, active);
    const Eigen::VectorXd force = part.partialPivLu().solve(gap);
    Eigen::VectorXd all = Eigen::VectorXd::Zero(skin.compliance.rows());
    for (std::size_t n = 0; n < active.size(); ++n) { all(active[n]) = force(static_cast<Eigen::Index>(n)); }
    const Eigen::VectorXd moved = skin.compliance * all;
    std::vector<Eigen::Index> next;
    for (Eigen::Index n = 0; n < all.size(); ++n) {
      const bool reached = all(n) > 0.0 || (all(n) == 0.0 && moved(n) < skin.gap[static_cast<std::size_t>(n)]);
      if (reached) { next.push_back(n); }
    }
    if (next == active) { return force.sum(); }
    active = std::move(next);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

double force_with(int voxels_per_contact) {
  const double h = contact / voxels_per_contact;
  const MeshBody body{.name = "block",
                      .surface = reference::box_surface({-reach, -reach, 0.0}, {reach, reach, reach}),
                      .material = "soft"};
  std::vector<Violation> broken;
  const std::vector<Material> materials{{.name = "soft", .youngs_modulus = youngs_modulus}};
  return contact_force(skin_of(mesh_tissue({body}, {.voxel = h}, materials, broken).network));
}

void measure_hertz(const CaseContext& /*context*/, Outcome& outcome) {
  constexpr std::array rungs{1, 2, 3};
  std::array<double, 3> error{};
  Table table{.id = "refinement",
              .title = "Refinement",
              .caption = "Force of a ball of 60 mm pressed 0.6 mm deep, sides and bottom at three contact radii moving as a "
                         "half-space's.",
              .columns = {"voxel, of the contact's radius (1)", "force (N)", "of Hertz, less one (%)"}};
  for (std::size_t n = 0; n < rungs.size(); ++n) {
    const double force = force_with(rungs[n]);
    error[n] = force / hertz_force() - 1.0;
    table.rows.push_back({1.0 / rungs[n], force, 100.0 * error[n]});
  }
  outcome.tables.push_back(std::move(table));
  // First order is taken for the index: the rim of the contact is told to a voxel.
  const double gci = 1.25 * std::abs(error[2] - error[1]) / (1.5 - 1.0);
  outcome.judge({.name = "grid convergence index of the finest", .value = gci});
  outcome.judge({.name = "error of the finest, of the one before",
                 .value = std::abs(error[2] / error[1]),
                 .upper = 1.0,
                 .bound_from = "theory: refinement converges"});
  // The next term of the far field of a contact of radius a is (a / reach)^2 of the first; at the axis it moves the skin by
  // that share of what a half-space's rim moves it, itself a / reach of the depth.
  const double rim = std::pow(contact / reach, 3);
  outcome.judge({.name = "force against Hertz, E and nu = 1/4",
                 .value = error[2],
                 .lower = -(gci + rim),
                 .upper = gci + rim,
                 .bound_from = "theory: grid convergence index, and (a/reach)^3 of the far field beyond its first term"});
}

}  // namespace

Case hertz_case() {
  return {.name = "tissue/hertz",
          .suite = "model",
          .claim = "A ball pressed into voxels is pushed back as Hertz says for nu = 1/4, nearer with each refinement",
          .measure = measure_hertz,
          .quick = false,
          .weight = 30.0};
}

}  // namespace palpate
