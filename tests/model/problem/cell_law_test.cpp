// SPDX-License-Identifier: MIT

#include "model/problem/cell_law.hpp"

#include <Eigen/SparseCore>
#include <cmath>
#include <random>

#include "model/kernels/list_network.hpp"
#include "model/problem/problem.hpp"
#include "model/stepping/simulation.hpp"
#include "model/tissue/lattice.hpp"
#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double modulus = 1e4;
constexpr double h = 0.01;

CellMaterial tissue(double nu) {
  CellMaterial material{.youngs_modulus = modulus, .density = 1000.0};
  material.poissons_ratio = nu;
  material.retardation_time = 0.01;
  return material;
}

/// A lattice of 4 x 4 x 4 nodes, none of them fixed.
SpringNetwork block(double nu) {
  return cell_lattice({{4, 4, 4}, h, 26}, [&](int, int, int) { return tissue(nu); });
}

/// Positions of all nodes under x = F X.
VectorXd deformed(const SpringNetwork& network, const Matrix3d& f) {
  VectorXd q(3 * network.node_count());
  for (Eigen::Index n = 0; n < network.node_count(); ++n) {
    q.segment<3>(3 * n) = f * network.rest_position.col(n);
  }
  return q;
}

VectorXd shaken(VectorXd q, double by, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> some(-by, by);
  for (double& x : q) { x += some(random); }
  return q;
}

TEST("energy and nodal forces are those of E and nu for every affine strain (patch test)") {
  for (const double nu : {0.25, 0.3, 0.45, 0.49}) {
    const NetworkProblem problem(block(nu));
    const double mu = modulus / (2.0 * (1.0 + nu));
    const double lambda = 2.0 * mu * nu / (1.0 - 2.0 * nu);
    JacobianMatrix stiffness;
    JacobianMatrix damping;
    const VectorXd rest = problem.initial_position();
    problem.jacobian(rest, VectorXd::Zero(rest.size()), stiffness, damping);
    for (int entry = 0; entry < 9; ++entry) {
      Matrix3d gradient = Matrix3d::Zero();
      gradient(entry / 3, entry % 3) = 1.0;
      gradient(0, 0) += 0.3;
      const VectorXd u = deformed(problem.network(), gradient);
      const Matrix3d strain = 0.5 * (gradient + gradient.transpose());
      const double density =
          0.5 * lambda * strain.trace() * strain.trace() + mu * strain.squaredNorm();
      const double volume = std::pow(3.0 * h, 3);
      const VectorXd force = stiffness * u;
      CHECK_NEAR(0.5 * u.dot(force) / (density * volume), 1.0, 1e-10);
      // A Kelvin-Voigt solid: C = tau K for springs and cells.
      CHECK_NEAR(0.5 * u.dot(damping * u) / (density * volume), 0.01, 1e-12);
      const double scale = force.cwiseAbs().maxCoeff();
      for (int n = 0; n < 64; ++n) {  // the 8 nodes inside carry no force
        const LatticeShape shape{{4, 4, 4}, h, 26};
        const auto place = shape.place(n);
        const bool inside = std::ranges::all_of(place, [](int i) { return i == 1 || i == 2; });
        if (inside) { CHECK(force.segment<3>(3 * n).norm() <= 1e-10 * scale); }
      }
    }
  }
}

TEST("nu = 1/4 needs no cell, and cells keep springs that have nu = 1/4") {
  CHECK(block(0.25).cells.empty());
  const SpringNetwork stiff = block(0.45);
  CHECK(stiff.cells.size() == 27);
  // E_s = 5/2 mu = 1.25 E / (1 + nu)
  CHECK_NEAR(stiff.springs[0].stiffness, block(0.25).springs[0].stiffness * 1.25 / 1.45, 1e-12);
}

/// A strongly deformed block with corners that are collapsed and inside out.
struct Crushed {
  NetworkProblem problem{block(0.45)};
  VectorXd q =
      shaken(deformed(problem.network(), Vector3d(0.9, 1.1, 0.35).asDiagonal()), 0.25 * h, 7);
  VectorXd v = shaken(VectorXd::Zero(q.size()), 0.1, 8);
};

TEST("forces are the negative gradient of the energy, also where corners collapse") {
  const Crushed crushed;
  double least = 1.0;
  for (const VolumeCell& cell : crushed.problem.network().cells) {
    Corners<double> x{};
    for (std::size_t n = 0; n < 8; ++n) {
      const auto at = 3 * cell.nodes[n];
      x[n] = {crushed.q(at), crushed.q(at + 1), crushed.q(at + 2)};
    }
    least = std::min(least, smallest_corner(x, cell.volume));
  }
  CHECK(least < 0.0);  // some corner is inside out
  const VectorXd still = VectorXd::Zero(crushed.q.size());
  VectorXd f(still.size());
  crushed.problem.force(0.0, 0.0, crushed.q, still, f);
  const double step = 1e-6 * h;
  for (Eigen::Index i = 0; i < f.size(); i += 5) {
    VectorXd there = crushed.q;
    there(i) += step;
    const double up = crushed.problem.energy(there, still);
    there(i) -= 2.0 * step;
    const double down = crushed.problem.energy(there, still);
    CHECK_NEAR(f(i), -(up - down) / (2.0 * step), 1e-5 * f.cwiseAbs().maxCoeff());
  }
}

TEST("the Jacobian is the derivative of the force by position and velocity") {
  const Crushed crushed;
  JacobianMatrix stiffness;
  JacobianMatrix damping;
  crushed.problem.jacobian(crushed.q, crushed.v, stiffness, damping);
  VectorXd up(crushed.q.size());
  VectorXd down = up;
  for (const bool of_position : {true, false}) {
    for (Eigen::Index i = 0; i < crushed.q.size(); i += 7) {
      const double step = of_position ? 1e-6 * h : 1e-3;
      VectorXd q = crushed.q;
      VectorXd v = crushed.v;
      VectorXd& moved = of_position ? q : v;
      moved(i) += step;
      crushed.problem.force(0.0, 0.0, q, v, up);
      moved(i) -= 2.0 * step;
      crushed.problem.force(0.0, 0.0, q, v, down);
      const VectorXd column = (of_position ? stiffness : damping).col(i);
      const VectorXd found = (down - up) / (2.0 * step);
      CHECK((column - found).cwiseAbs().maxCoeff() <= 1e-5 * column.cwiseAbs().maxCoeff());
    }
  }
}

TEST("a list network has the forces, matrices and energy of the problem") {
  const Crushed crushed;
  ListNetwork<double> list(crushed.problem, {}, 1e-3, true);
  VectorXd f(crushed.q.size());
  VectorXd expected = f;
  crushed.problem.force(0.0, 0.0, crushed.q, crushed.v, expected);
  list.force(0.0, 0.0, crushed.q, crushed.v, f);
  CHECK((f - expected).cwiseAbs().maxCoeff() <= 1e-12 * expected.cwiseAbs().maxCoeff());
  CHECK_NEAR(list.energy(crushed.q, crushed.v), crushed.problem.energy(crushed.q, crushed.v),
             1e-12);
  JacobianMatrix stiffness;
  JacobianMatrix damping;
  crushed.problem.jacobian(crushed.q, crushed.v, stiffness, damping);
  Eigen::SparseMatrix<double> a;
  list.pattern(a);
  list.jacobian(crushed.q, crushed.v, 0.5, 0.25, a);
  Eigen::SparseMatrix<double> exact = 0.5 * damping + 0.25 * stiffness;
  exact.diagonal() += crushed.problem.mass();
  const Eigen::MatrixXd apart = Eigen::MatrixXd(a) - Eigen::MatrixXd(exact);
  CHECK(apart.cwiseAbs().maxCoeff() <= 1e-12 * Eigen::MatrixXd(exact).cwiseAbs().maxCoeff());
  list.damping(crushed.q, crushed.v, f);
  CHECK((f - damping * crushed.v).cwiseAbs().maxCoeff() <= 1e-12 * f.cwiseAbs().maxCoeff());
}

TEST("a cell that is pressed to a tenth of its volume, or turned inside out, comes back") {
  for (const double pressed : {0.1, -0.2}) {
    SpringNetwork network =
        cell_lattice({{2, 2, 2}, h, 26}, [](int, int, int) { return tissue(0.45); });
    network.initial_displacement = NodeVectors::Zero(3, 8);
    for (int n = 4; n < 8; ++n) { network.initial_displacement(2, n) = -h * (1.0 - pressed); }
    for (int n = 0; n < 4; ++n) { network.fixed[static_cast<std::size_t>(n)] = 1; }
    Scene scene;
    scene.tissue.source = Source::network;
    scene.simulation.step = 1e-3;
    scene.simulation.duration = 1.0;
    scene.simulation.integrator = "implicit-euler";
    scene.simulation.substeps = 20;  // the first recoil takes a fraction of a millisecond
    Simulation run(scene, network);
    for (int n = 0; n < 1000; ++n) { CHECK(run.tick() == StepStatus::ok); }
    const NodeVectors end = run.node_positions();
    CHECK((end - network.rest_position).cwiseAbs().maxCoeff() <= 1e-6 * h);
  }
}

TEST("a lattice is checked with axes of either sign, and one corner inside out is counted") {
  for (const double sign : {1.0, -1.0}) {
    SpringNetwork network = block(0.45);
    network.rest_position.row(0) *= sign;
    NodeVectors moved = network.rest_position;
    CHECK_NEAR(check_cells(network, moved).smallest, 1.0, 1e-12);
    CHECK(check_cells(network, moved).inverted == 0);
    moved(2, 0) += 1.5 * h;  // the first node, through the cell below it
    CHECK(check_cells(network, moved).smallest < 0.0);
    CHECK(check_cells(network, moved).inverted == 1);
  }
}

TEST("the resistance to collapse begins smoothly and stays finite") {
  const CollapseSlopes none = CollapseSlopes::at(collapse_begin);
  CHECK(none.first == 0.0);
  CHECK(none.second == 0.0);
  CHECK(none.energy == 0.0);
  for (const double j : {0.2, 0.05, 0.03, 0.0, -1.0}) {
    const double d = 1e-6;
    const CollapseSlopes at = CollapseSlopes::at(j);
    const CollapseSlopes more = CollapseSlopes::at(j + d);
    const CollapseSlopes less = CollapseSlopes::at(j - d);
    CHECK_NEAR(at.first, (more.energy - less.energy) / (2.0 * d), 1e-4 * std::abs(at.first));
    CHECK_NEAR(at.second, (more.first - less.first) / (2.0 * d), 1e-3 * at.second);
    CHECK(at.first < 0.0);
  }
}

}  // namespace PALPATE_FILE
