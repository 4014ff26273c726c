// SPDX-License-Identifier: MIT

#include "model/tissue/lattice.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "model/tissue/network_builder.hpp"
#include "tests/check.hpp"

namespace PALPATE_FILE {

using namespace palpate;

LatticeShape cube(int n, int connectivity) { return {{n, n, n}, 0.01, connectivity}; }

/// Bonds of an n^3 lattice by counting ordered pairs of neighbours.
double bonds(int n, int connectivity) {
  const double inside = n - 1.0;
  const double along = 3.0 * inside * n * n;
  const double face = 6.0 * inside * inside * n;
  const double body = 4.0 * inside * inside * inside;
  return along + (connectivity >= 18 ? face : 0.0) + (connectivity == 26 ? body : 0.0);
}

TEST("a lattice has as many springs as it has neighbour pairs") {
  for (const int connectivity : {6, 18, 26}) {
    for (const int n : {2, 3, 5, 10, 20}) {
      const auto count = uniform_lattice(cube(n, connectivity), 1.0, 0.0, 1.0).springs.size();
      CHECK_NEAR(static_cast<double>(count), bonds(n, connectivity), 0.0);
    }
  }
}

TEST("no spring occurs twice, joins a node with itself, or is longer than a cell's diagonal") {
  const SpringNetwork network = uniform_lattice({{4, 3, 5}, 0.01, 26}, 1.0, 0.0, 1.0);
  std::set<std::pair<int, int>> seen;
  for (const Spring& s : network.springs) {
    CHECK(s.a != s.b);
    CHECK(seen.insert(std::minmax(s.a, s.b)).second);
    CHECK(s.rest_length <= 0.01 * std::sqrt(3.0) * (1.0 + 1e-12));
    const double distance =
        (network.rest_position.col(s.b) - network.rest_position.col(s.a)).norm();
    CHECK_NEAR(s.rest_length, distance, 1e-17);
  }
}

TEST("x and y are centred on zero, z runs inwards, and x counts fastest") {
  const LatticeShape shape{{3, 5, 2}, 0.01, 26};
  const SpringNetwork network = uniform_lattice(shape, 1.0, 0.0, 1.0);
  CHECK_NEAR(network.rest_position.col(shape.index(2, 0, 1)), Eigen::Vector3d(0.01, -0.02, 0.01),
             1e-17);
  CHECK(shape.index(1, 0, 0) == 1);
  CHECK(shape.index(0, 1, 0) == 3);
  CHECK(shape.index(0, 0, 1) == 15);
}

CellMaterial soft(int, int, int) { return {3.75e3, 1000.0, 0.0, {}}; }

double stiffness_between(const SpringNetwork& network, int a, int b) {
  for (const Spring& s : network.springs) {
    if (std::minmax(s.a, s.b) == std::minmax(a, b)) { return s.stiffness; }
  }
  return std::nan("");
}

TEST("each cell gives a quarter edge, half a face diagonal and a body diagonal") {
  const LatticeShape shape = cube(4, 26);
  const SpringNetwork network = cell_lattice(shape, soft);
  const double k2 = 3.75e3 * 0.01 / 3.75;  // PHYSICS section 5: k2 = E a / 3.75
  const auto k = [&](std::array<int, 3> a, std::array<int, 3> b) {
    return stiffness_between(network, shape.index(a[0], a[1], a[2]), shape.index(b[0], b[1], b[2]));
  };
  CHECK_NEAR(k({1, 1, 1}, {2, 1, 1}), 2.0 * k2, 1e-12);    // inside: four cells
  CHECK_NEAR(k({1, 1, 0}, {2, 1, 0}), 1.0 * k2, 1e-12);    // on a face: two
  CHECK_NEAR(k({1, 0, 0}, {2, 0, 0}), 0.5 * k2, 1e-12);    // on an edge: one
  CHECK_NEAR(k({1, 1, 1}, {2, 2, 1}), k2, 1e-12);          // inside: two cells
  CHECK_NEAR(k({1, 1, 0}, {2, 2, 0}), 0.5 * k2, 1e-12);    // on a face: one
  CHECK_NEAR(k({1, 1, 1}, {2, 2, 2}), 0.375 * k2, 1e-12);  // always one cell
}

TEST("the stiffness of all springs adds up to that of the cells") {
  for (const int connectivity : {6, 18, 26}) {
    const SpringNetwork network = cell_lattice({{4, 5, 6}, 0.01, connectivity}, soft);
    const BondStiffness bond = bond_stiffness(3.75e3, 0.01, connectivity);
    const double cell = 12 * bond.edge / 4 + 12 * bond.face_diagonal / 2 + 4 * bond.body_diagonal;
    double sum = 0.0;
    for (const Spring& s : network.springs) { sum += s.stiffness; }
    CHECK_NEAR(sum, cell * 3 * 4 * 5, 1e-9);
  }
}

TEST("the damping ratio of a mixed cell is the mean over its volume") {
  MaterialMean mean;
  CellMaterial soft;
  soft.damping_ratio = 0.4;
  CellMaterial stiff;
  stiff.damping_ratio = 0.2;
  mean.add(0.25, soft);
  mean.add(0.5, stiff);
  CHECK_NEAR(mean.mean().damping_ratio, (0.25 * 0.4 + 0.5 * 0.2) / 0.75, 1e-15);  // rounding
}

TEST("node masses add up to density times volume, corners carrying an eighth of a cell") {
  const SpringNetwork network = cell_lattice({{4, 5, 6}, 0.01, 26}, soft);
  CHECK_NEAR(network.mass.sum(), 1000.0 * 60e-6, 1e-15);
  CHECK_NEAR(network.mass(0), 1e-3 / 8.0, 1e-18);
  CHECK_NEAR(network.mass.maxCoeff(), 1e-3, 1e-18);
}

TEST("bond stiffnesses satisfy the isotropy condition and give Young's modulus E") {
  for (const int connectivity : {18, 26}) {
    const double a = 0.004;
    const BondStiffness k = bond_stiffness(5e3, a, connectivity);
    CHECK_NEAR(k.edge, k.face_diagonal + 8.0 / 3.0 * k.body_diagonal, 1e-12);
    CHECK_NEAR(2.5 * (k.face_diagonal + 4.0 / 3.0 * k.body_diagonal) / a, 5e3, 1e-9);
  }
}

TEST("a damping ratio is of each spring against its reduced mass, and a given viscosity wins") {
  CellMaterial material{3.75e3, 1000.0, 0.3, {}};
  const auto same = [&](int, int, int) { return material; };
  const SpringNetwork network = cell_lattice(cube(3, 26), same);
  for (const Spring& s : network.springs) {
    const double reduced = 1.0 / (1.0 / network.mass(s.a) + 1.0 / network.mass(s.b));
    CHECK_NEAR(s.viscosity, 0.3 * 2.0 * std::sqrt(s.stiffness * reduced), 1e-14);
  }
  material.viscosity = 0.02;
  for (const Spring& s : cell_lattice(cube(3, 26), same).springs) {
    CHECK_NEAR(s.viscosity, 0.02, 1e-16);
  }
}

using Eigen::Vector3d;

/// Isotropy with nu = 1/4 and E = 1: C11 = 1.2 and C12 = 0.4.
Eigen::Matrix3d isotropic() {
  return Eigen::Matrix3d::Constant(0.4) + 0.8 * Eigen::Matrix3d::Identity();
}

TEST("a cube's bonds are those of a lattice, to the last bit") {
  for (const int connectivity : {6, 18, 26}) {
    const BondStiffness cube = bond_stiffness(1.0, 0.00125, connectivity);
    const BoxBonds box = box_bonds(Vector3d::Constant(0.00125), connectivity);
    CHECK_NEAR(box.stiffness[0], cube.edge, 0.0);
    CHECK_NEAR(box.stiffness[3], cube.face_diagonal, 0.0);
    CHECK_NEAR(box.stiffness[12], cube.body_diagonal, 0.0);
  }
}

TEST("boxes that are nearly cubes are isotropic, with constants that pull") {
  for (const Vector3d& size :
       {Vector3d(1.0, 1.0, 1.0), Vector3d(0.94, 0.94, 0.9), Vector3d(1.0, 1.0, 1.5),
        Vector3d(1.0, 1.3, 1.6), Vector3d(0.7, 1.1, 0.8)}) {
    const BoxBonds bonds = box_bonds(1e-3 * size, 26);
    CHECK_NEAR(bonds.elasticity, isotropic(), 1e-12);
    CHECK_NEAR(bonds.youngs_moduli(), Vector3d(Vector3d::Ones()), 1e-12);
    CHECK(*std::ranges::min_element(bonds.stiffness) >= 0.0);
  }
}

TEST("flat and long boxes have no negative constant and report their own elasticity") {
  for (const Vector3d& size :
       {Vector3d(0.47, 0.47, 0.9), Vector3d(0.47, 0.47, 4.0), Vector3d(4.0, 4.0, 0.9)}) {
    const BoxBonds bonds = box_bonds(1e-3 * size, 26);
    CHECK(*std::ranges::min_element(bonds.stiffness) >= 0.0);
    CHECK(*std::ranges::max_element(bonds.stiffness) > 0.0);
    CHECK((bonds.elasticity - isotropic()).norm() > 1e-3);
    CHECK((bonds.youngs_moduli() - Vector3d::Ones()).cwiseAbs().maxCoeff() < 0.5);
  }
}

TEST("six neighbours carry E along each axis and nothing across") {
  const BoxBonds bonds = box_bonds({0.001, 0.002, 0.003}, 6);
  CHECK_NEAR(bonds.stiffness[0], 0.002 * 0.003 / 0.001, 1e-15);  // E A / L
  CHECK_NEAR(bonds.stiffness[2], 0.001 * 0.002 / 0.003, 1e-15);
  CHECK_NEAR(bonds.youngs_moduli(), Vector3d(Vector3d::Ones()), 1e-12);
  CHECK_NEAR(bonds.elasticity(0, 1), 0.0, 0.0);
}

TEST("a column of boxes under load shortens according to E") {
  // Computed from the constants alone: C of the bonds, summed here from lengths and directions.
  const Vector3d size(0.9e-3, 1.1e-3, 1.4e-3);
  const BoxBonds bonds = box_bonds(size, 26);
  Eigen::Matrix3d c = Eigen::Matrix3d::Zero();
  const auto directions = bond_directions(26);
  for (std::size_t d = 0; d < directions.size(); ++d) {
    const Vector3d bond =
        size.cwiseProduct(Vector3d(directions[d][0], directions[d][1], directions[d][2]));
    const Vector3d square = bond.normalized().cwiseAbs2();
    c += bonds.stiffness[d] * bond.squaredNorm() / size.prod() * square * square.transpose();
  }
  CHECK_NEAR(c, isotropic(), 1e-12);
}

}  // namespace PALPATE_FILE
