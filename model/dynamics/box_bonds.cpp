// SPDX-License-Identifier: MIT
#include "model/dynamics/box_bonds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Dense>

#include "model/dynamics/lattice.hpp"
#include "model/dynamics/network_builder.hpp"

namespace palpate {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Edges along x, y, z; diagonals of the faces xy, xz, yz; body diagonals.
constexpr int kinds = 7;
using Constants = Eigen::Matrix<double, kinds, 1>;
using Elasticity = Eigen::Matrix<double, 6, kinds>;  ///< rows xx, yy, zz, xy, xz, yz, per constant

int kind_of(const std::array<int, 3>& direction) {
  const bool x = direction[0] != 0;
  const bool y = direction[1] != 0;
  const bool z = direction[2] != 0;
  if (x && y && z) { return 6; }
  if (x && y) { return 3; }
  if (x && z) { return 4; }
  if (y && z) { return 5; }
  return x ? 0 : y ? 1 : 2;
}

/// C = sum of k L^2 n n n n over the bonds of a node, by its volume; every node has each direction once.
Elasticity elasticity_of(const Vector3d& size) {
  Elasticity c = Elasticity::Zero();
  for (const auto& direction : bond_directions(26)) {
    const Vector3d bond = size.cwiseProduct(Vector3d(direction[0], direction[1], direction[2]));
    const double scale = 1.0 / (bond.squaredNorm() * size.prod());
    const Vector3d s = bond.cwiseAbs2();
    const Eigen::Matrix<double, 6, 1> products(s.x() * s.x(), s.y() * s.y(), s.z() * s.z(), s.x() * s.y(),
                                               s.x() * s.z(), s.y() * s.z());
    c.col(kind_of(direction)) += scale * products;
  }
  return c;
}

/// C of a body of E = 1 and nu = 1/4.
Eigen::Matrix<double, 6, 1> isotropic() {
  Eigen::Matrix<double, 6, 1> c;
  c << 1.2, 1.2, 1.2, 0.4, 0.4, 0.4;
  return c;
}

/// Constants without negative ones that come nearest to `target`: of all choices of those that are not 0, the
/// best. Equals go to the choice that leaves out most.
Constants nearest(const Elasticity& c, const Eigen::Matrix<double, 6, 1>& target, int usable) {
  Constants best = Constants::Zero();
  double least = std::numeric_limits<double>::infinity();
  for (int choice = 1; choice < 1 << usable; ++choice) {
    std::vector<int> chosen;
    for (int n = 0; n < usable; ++n) {
      if ((choice >> n & 1) != 0) { chosen.push_back(n); }
    }
    const Eigen::MatrixXd part = c(Eigen::all, chosen);
    const Eigen::VectorXd k = part.completeOrthogonalDecomposition().solve(target);
    const double miss = (part * k - target).norm();
    if (k.minCoeff() < 0.0 || miss >= least - 1e-9) { continue; }
    least = miss;
    best.setZero();
    for (std::size_t n = 0; n < chosen.size(); ++n) { best(chosen[n]) = k(static_cast<Eigen::Index>(n)); }
  }
  return best;
}

/// The isotropic constants whose body diagonals carry a third of the shear, as those of a cube do, or as
/// little more as edges need that are not to pull; negative ones where there are none.
Constants isotropic_constants(const Elasticity& c) {
  const auto with = [&](double body) {
    Constants k;
    k(6) = body;
    for (int face = 0; face < 3; ++face) { k(3 + face) = (0.4 - c(3 + face, 6) * body) / c(3 + face, 3 + face); }
    for (int axis = 0; axis < 3; ++axis) { k(axis) = (1.2 - c.row(axis).tail<4>().dot(k.tail<4>())) / c(axis, axis); }
    return k;
  };
  const double most = (0.4 / c.col(6).tail<3>().array()).minCoeff();
  const Constants none = with(0.0);
  const Constants all = with(most);
  double share = 1.0 / 3.0;
  for (int axis = 0; axis < 3; ++axis) {  // each edge's constant grows evenly with the share
    if (none(axis) < 0.0) { share = std::max(share, none(axis) / (none(axis) - all(axis))); }
  }
  return with(share * most);
}

}  // namespace

Vector3d BoxBonds::youngs_moduli() const {
  const bool shear = elasticity(0, 1) + elasticity(0, 2) + elasticity(1, 2) > 0.0;
  if (!shear) { return elasticity.diagonal(); }
  return elasticity.inverse().diagonal().cwiseInverse();
}

BoxBonds box_bonds(const Vector3d& size, int connectivity) {
  const Elasticity c = elasticity_of(size);
  Constants k = Constants::Zero();
  const double longest = size.maxCoeff();
  if (longest - size.minCoeff() <= 1e-12 * longest) {
    const BondStiffness cube = bond_stiffness(1.0, size.x(), connectivity);
    k << Vector3d::Constant(cube.edge), Vector3d::Constant(cube.face_diagonal), cube.body_diagonal;
  } else if (connectivity == 6) {
    k.head<3>() = c.topLeftCorner<3, 3>().diagonal().cwiseInverse();
  } else {
    if (connectivity == 26) { k = isotropic_constants(c); }
    const bool exact = connectivity == 26 && k.minCoeff() >= 0.0;
    if (!exact) { k = nearest(c, isotropic(), connectivity == 26 ? kinds : kinds - 1); }
  }
  BoxBonds bonds;
  const auto directions = bond_directions(26);
  for (std::size_t d = 0; d < directions.size(); ++d) { bonds.stiffness[d] = k(kind_of(directions[d])); }
  const Eigen::Matrix<double, 6, 1> made = c * k;
  bonds.elasticity << made(0), made(3), made(4), made(3), made(1), made(5), made(4), made(5), made(2);
  return bonds;
}

}  // namespace palpate
