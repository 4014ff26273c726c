// SPDX-License-Identifier: MIT
/// The lattice at rest is a cubic elastic solid: its assembled stiffness under uniform traction and
/// under affine boundary displacement, against the homogenised moduli.

#include <Eigen/Cholesky>
#include <cmath>
#include <functional>

#include "model/dynamics/network_builder.hpp"
#include "validation/cases/network_parts.hpp"
#include "validation/cases/network_support.hpp"

namespace palpate::networks {

namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct CubicModuli {
  double c11 = 0.0;  ///< [Pa]
  double c12 = 0.0;
  double c44 = 0.0;

  [[nodiscard]] double youngs() const { return (c11 - c12) * (c11 + 2.0 * c12) / (c11 + c12); }
  [[nodiscard]] double poisson() const { return c12 / (c11 + c12); }
};

/// How many axes a spring of a lattice spans: 1 edge, 2 face diagonal, 3 body diagonal.
int kind_of(const SpringNetwork& network, const Spring& spring, double spacing) {
  const Eigen::Vector3d d =
      network.rest_position.col(spring.b) - network.rest_position.col(spring.a);
  return static_cast<int>((d.array().abs() > 0.5 * spacing).count());
}

CubicModuli formula(const BondStiffness& k, double spacing) {
  const double shear = (k.face_diagonal + 4.0 / 3.0 * k.body_diagonal) / spacing;
  return {(k.edge + 2.0 * k.face_diagonal + 4.0 / 3.0 * k.body_diagonal) / spacing, shear, shear};
}

/// K u = f with some coordinates prescribed; `displacement` holds those and receives the rest.
void solve_static(const MatrixXd& stiffness, const VectorXd& force, const std::vector<bool>& held,
                  VectorXd& displacement) {
  std::vector<Index> free;
  std::vector<Index> fixed;
  for (Index i = 0; i < displacement.size(); ++i) {
    (held[static_cast<std::size_t>(i)] ? fixed : free).push_back(i);
  }
  const MatrixXd among_free = stiffness(free, free);
  const VectorXd right = force(free) - stiffness(free, fixed) * displacement(fixed);
  const Eigen::LDLT<MatrixXd> factor(among_free);
  VectorXd solution = factor.solve(right);
  solution += factor.solve(right - among_free * solution);
  displacement(free) = solution;
}

struct Measured {
  double youngs = 0.0;
  double poisson = 0.0;
  double not_affine = 0.0;  ///< largest distance from a homogeneous strain over the largest motion
  CubicModuli moduli{};
  VectorXd traction_displacement{};
};

/// Uniform traction along z on rollers; nodal shares of a face are 1, 1/2 and 1/4.
void pull_on_rollers(const Block& block, const MatrixXd& stiffness, const NodeVectors& rest,
                     Measured& measured) {
  const LatticeShape shape = block.shape();
  constexpr double traction = 1.0;  // [Pa]
  VectorXd force = VectorXd::Zero(stiffness.rows());
  std::vector<bool> held(static_cast<std::size_t>(stiffness.rows()), false);
  for (int l = 0; l < shape.nodes[2]; ++l) {
    for (int j = 0; j < shape.nodes[1]; ++j) {
      for (int i = 0; i < shape.nodes[0]; ++i) {
        const auto first = static_cast<std::size_t>(3 * shape.index(i, j, l));
        held[first] = i == 0;
        held[first + 1] = j == 0;
        held[first + 2] = l == 0;
        const bool edge_x = i == 0 || i + 1 == shape.nodes[0];
        const bool edge_y = j == 0 || j + 1 == shape.nodes[1];
        if (l + 1 != shape.nodes[2]) { continue; }
        force(static_cast<Index>(first + 2)) =
            traction * shape.spacing * shape.spacing * (edge_x ? 0.5 : 1.0) * (edge_y ? 0.5 : 1.0);
      }
    }
  }
  VectorXd u = VectorXd::Zero(stiffness.rows());
  solve_static(stiffness, force, held, u);
  // The far corner tells the homogeneous strain; every other node is held to it.
  const Eigen::Vector3d extent = rest.rightCols<1>() - rest.col(0);
  const Eigen::Vector3d strain = u.tail<3>().cwiseQuotient(extent);
  measured.youngs = traction / strain.z();
  measured.poisson = -0.5 * (strain.x() + strain.y()) / strain.z();
  NodeVectors affine = strain.asDiagonal() * (rest.colwise() - rest.col(0));
  const double away = largest_of(u - affine.reshaped());
  measured.not_affine = away / largest_of(u);
  measured.traction_displacement = u;
}

/// Mean stress of a body whose boundary moves by x -> strain x: sum of x (outer) reaction / volume.
Matrix3d mean_stress(const Block& block, const MatrixXd& stiffness, const NodeVectors& rest,
                     const Matrix3d& strain) {
  const LatticeShape shape = block.shape();
  const NodeVectors target = strain * rest;
  VectorXd u = target.reshaped();
  std::vector<bool> held(static_cast<std::size_t>(u.size()), true);
  for (int l = 1; l + 1 < shape.nodes[2]; ++l) {
    for (int j = 1; j + 1 < shape.nodes[1]; ++j) {
      for (int i = 1; i + 1 < shape.nodes[0]; ++i) {
        for (int axis = 0; axis < 3; ++axis) {
          held[static_cast<std::size_t>(3 * shape.index(i, j, l) + axis)] = false;
        }
      }
    }
  }
  solve_static(stiffness, VectorXd::Zero(u.size()), held, u);
  const VectorXd reaction = stiffness * u;
  const double volume = std::pow(shape.spacing, 3) * (shape.nodes[0] - 1) * (shape.nodes[1] - 1) *
                        (shape.nodes[2] - 1);
  return rest * reaction.reshaped(3, rest.cols()).transpose() / volume;
}

Measured measure_moduli(const Block& block, const SpringNetwork& network) {
  const NetworkProblem problem(network);
  const MatrixXd stiffness = stiffness_of(problem);
  Measured measured;
  pull_on_rollers(block, stiffness, network.rest_position, measured);
  Matrix3d strain = Matrix3d::Zero();
  strain(0, 0) = 1.0;
  const Matrix3d stretched = mean_stress(block, stiffness, network.rest_position, strain);
  strain(0, 0) = 0.0;
  strain(0, 1) = 1.0;
  const Matrix3d sheared = mean_stress(block, stiffness, network.rest_position, strain);
  measured.moduli = {stretched(0, 0), stretched(1, 1), sheared(0, 1)};
  return measured;
}

void judge_error(Outcome& outcome, const std::string& name, double error, double tolerance,
                 const std::string& why) {
  outcome.judge({.name = name, .value = std::abs(error), .upper = tolerance, .bound_from = why});
}

/// Rounding of one solve with a condition number below 1e4, refined once.
constexpr double rounding = 1e-12;

void patch(const CaseContext& context, int connectivity, Outcome& outcome, Table& table,
           Figure& figure) {
  const std::string tag = std::to_string(connectivity);
  const Block block{.nodes = {5, 4, 6}, .connectivity = connectivity};
  const SpringNetwork network = candidate(context, block_network(block));
  const BondStiffness bonds = bond_stiffness(block.youngs_modulus, block.spacing, connectivity);
  const CubicModuli expected = formula(bonds, block.spacing);
  const Measured measured = measure_moduli(block, network);
  const double scale = block.youngs_modulus;
  const std::string theory = "homogenised lattice; rounding of a refined solve";
  const auto judge = [&](const std::string& name, double error) {
    judge_error(outcome, name + "_" + tag, error, rounding, theory);
  };
  judge("youngs_error", measured.youngs / scale - 1.0);
  judge("poisson_error", measured.poisson - (connectivity == 6 ? 0.0 : 0.25));
  judge("c11_error", (measured.moduli.c11 - expected.c11) / scale);
  judge("c12_error", (measured.moduli.c12 - expected.c12) / scale);
  judge("c44_error", (measured.moduli.c44 - expected.c44) / scale);
  judge("not_affine", measured.not_affine);
  table.rows.push_back({tag, measured.youngs, measured.poisson, measured.moduli.c11,
                        measured.moduli.c12, measured.moduli.c44, expected.c11, expected.c12,
                        expected.c44});
  Series nodes{.label = tag + " neighbours", .style = Series::Style::points};
  for (Index i = 0; i < network.node_count(); ++i) {
    nodes.x.push_back(1e3 * network.rest_position(2, i));
    nodes.y.push_back(1e6 * measured.traction_displacement(3 * i + 2));
  }
  figure.series.push_back(std::move(nodes));
}

/// Edges, face and body diagonals scaled apart, so that no term of a formula hides behind another.
void anisotropic(const CaseContext& context, Outcome& outcome) {
  const Block block{.nodes = {4, 5, 4}};
  SpringNetwork network = block_network(block);
  constexpr std::array factor{1.7, 0.6, 2.3};
  network.springs.change_each([&](Spring& s) {
    s.stiffness *= factor[static_cast<std::size_t>(kind_of(network, s, block.spacing) - 1)];
  });
  BondStiffness bonds = bond_stiffness(block.youngs_modulus, block.spacing, 26);
  bonds = {bonds.edge * factor[0], bonds.face_diagonal * factor[1],
           bonds.body_diagonal * factor[2]};
  const CubicModuli expected = formula(bonds, block.spacing);
  const Measured measured = measure_moduli(block, candidate(context, network));
  const auto judge = [&](const std::string& name, double error) {
    judge_error(outcome, "anisotropic_" + name, error, rounding,
                "homogenised cubic lattice; rounding of a refined solve");
  };
  judge("c11_error", measured.moduli.c11 / expected.c11 - 1.0);
  judge("c12_error", measured.moduli.c12 / expected.c12 - 1.0);
  judge("c44_error", measured.moduli.c44 / expected.c44 - 1.0);
  judge("youngs_error", measured.youngs / expected.youngs() - 1.0);
  judge("poisson_error", measured.poisson - expected.poisson());
}

void masses(const CaseContext& context, Outcome& outcome) {
  const Block block{.nodes = {5, 4, 6}};
  const SpringNetwork network = candidate(context, block_network(block));
  const double volume = 4.0 * 3.0 * 5.0 * std::pow(block.spacing, 3);
  judge_error(outcome, "mass_error", network.mass.sum() / (block.density * volume) - 1.0,
              60.0 * 8.0 * epsilon, "60 cells of eight shares each, one rounding each");
  const BondStiffness k = bond_stiffness(1.0, 1.0, 26);
  judge_error(outcome, "isotropy_error", k.edge - k.face_diagonal - 8.0 / 3.0 * k.body_diagonal,
              4.0 * epsilon, "isotropic iff k1 = k2 + 8/3 k3");
  judge_error(outcome, "bond_error", k.face_diagonal - 1.0 / 3.75, 4.0 * epsilon,
              "k2 = E a / 3.75");
}

void measure_patch_test(const CaseContext& context, Outcome& outcome) {
  Table table{.id = "moduli",
              .title = "Homogenised moduli",
              .caption =
                  "Moduli measured on a block of 5 x 4 x 6 nodes under uniform traction on "
                  "rollers and under affine boundary displacement, beside their formulas.",
              .columns = {"neighbours", "E (Pa)", "Poisson's ratio", "C11 (Pa)", "C12 (Pa)",
                          "C44 (Pa)", "C11 formula (Pa)", "C12 formula (Pa)", "C44 formula (Pa)"}};
  Figure figure{.id = "traction",
                .title = "Displacement under uniform traction",
                .caption =
                    "Every node of a block pulled by 1 Pa lies on the straight line of a "
                    "homogeneous solid, whatever its neighbours.",
                .x = {.label = "distance from the roller (mm)"},
                .y = {.label = "displacement along the pull (µm)"}};
  for (const int connectivity : {6, 18, 26}) {
    patch(context, connectivity, outcome, table, figure);
  }
  const Block block;
  figure.series.push_back(line("t z / E", {0.0, 1e3 * 5.0 * block.spacing},
                               {0.0, 1e6 * 5.0 * block.spacing / block.youngs_modulus},
                               Series::Style::dashed));
  outcome.tables.push_back(std::move(table));
  outcome.figures.push_back(std::move(figure));
  anisotropic(context, outcome);
  masses(context, outcome);
}

}  // namespace

std::vector<Case> elasticity_cases() {
  return {{.name = "network/patch-test",
           .suite = "accuracy",
           .claim = "A cell-built lattice under uniform traction has the Young's modulus it was "
                    "given, Poisson's ratio 1/4 (0 and no shear stiffness with 6 neighbours), and "
                    "its homogenised moduli.",
           .measure = measure_patch_test,
           .weight = 0.3}};
}

}  // namespace palpate::networks
