// SPDX-License-Identifier: MIT
#include "model/dynamics/box_bonds.hpp"

#include <algorithm>

#include "model/dynamics/lattice.hpp"
#include "model/dynamics/network_builder.hpp"
#include "tests/check.hpp"

namespace {

using namespace palpate;
using Eigen::Vector3d;

/// Isotropy with nu = 1/4 and E = 1: C11 = 1.2 and C12 = 0.4.
Eigen::Matrix3d isotropic() { return Eigen::Matrix3d::Constant(0.4) + 0.8 * Eigen::Matrix3d::Identity(); }

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
  for (const Vector3d& size : {Vector3d(1.0, 1.0, 1.0), Vector3d(0.94, 0.94, 0.9), Vector3d(1.0, 1.0, 1.5),
                               Vector3d(1.0, 1.3, 1.6), Vector3d(0.7, 1.1, 0.8)}) {
    const BoxBonds bonds = box_bonds(1e-3 * size, 26);
    CHECK_NEAR(bonds.elasticity, isotropic(), 1e-12);
    CHECK_NEAR(bonds.youngs_moduli(), Vector3d(Vector3d::Ones()), 1e-12);
    CHECK(*std::ranges::min_element(bonds.stiffness) >= 0.0);
  }
}

TEST("flat and long boxes have no negative constant and say what they miss") {
  for (const Vector3d& size : {Vector3d(0.47, 0.47, 0.9), Vector3d(0.47, 0.47, 4.0), Vector3d(4.0, 4.0, 0.9)}) {
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

TEST("a column of boxes under load shortens as E says") {
  // Checked through the constants alone: C of the bonds, summed here from lengths and directions.
  const Vector3d size(0.9e-3, 1.1e-3, 1.4e-3);
  const BoxBonds bonds = box_bonds(size, 26);
  Eigen::Matrix3d c = Eigen::Matrix3d::Zero();
  const auto directions = bond_directions(26);
  for (std::size_t d = 0; d < directions.size(); ++d) {
    const Vector3d bond = size.cwiseProduct(Vector3d(directions[d][0], directions[d][1], directions[d][2]));
    const Vector3d square = bond.normalized().cwiseAbs2();
    c += bonds.stiffness[d] * bond.squaredNorm() / size.prod() * square * square.transpose();
  }
  CHECK_NEAR(c, isotropic(), 1e-12);
}

}  // namespace
