// SPDX-License-Identifier: MIT
#include "model/stepping/far_shapes.hpp"

#include <algorithm>
#include <random>

#include <Eigen/Eigenvalues>

#include "model/stepping/far_springs.hpp"

namespace palpate {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Loads on coarse coordinates [N], one column each.
MatrixXd loads_of(const std::vector<Push>& pushes, const GradedLattice& graded) {
  MatrixXd loads = MatrixXd::Zero(graded.dof(), static_cast<Index>(pushes.size()));
  for (std::size_t n = 0; n < pushes.size(); ++n) {
    for (const NeedlePath::Support& support : pushes[n].on) {
      const Index at = graded.coordinate(support.node);
      if (at >= 0) { loads.col(static_cast<Index>(n)).segment<3>(at) += support.weight * pushes[n].direction; }
    }
  }
  return loads;
}

MatrixXd random_matrix(Index rows, Index columns) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  return MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); });
}

/// Adds `more`, as far as it is not in the columns of `basis` yet and there is room for, orthogonal by mass; returns
/// what was added.
MatrixXd add_orthogonal(const VectorXd& mass, MatrixXd more, Index most, MatrixXd& basis) {
  const Index before = basis.cols();
  for (Index n = 0; n < more.cols() && basis.cols() < most; ++n) {
    VectorXd column = more.col(n);
    const double size = std::sqrt(column.dot(mass.cwiseProduct(column)));
    if (!(size > 0.0)) { continue; }
    column /= size;
    for (int twice = 0; twice < 2; ++twice) {
      column -= (basis * (basis.transpose() * mass.cwiseProduct(column))).eval();
    }
    const double left = std::sqrt(column.dot(mass.cwiseProduct(column)));
    if (left < 1e-6) { continue; }
    basis.conservativeResize(Eigen::NoChange, basis.cols() + 1);
    basis.rightCols<1>() = column / left;
  }
  return basis.rightCols(basis.cols() - before);
}

/// Responses at rest to pushes, then to the inertia of these responses, and so on, until there are enough.
MatrixXd responses(const std::vector<Push>& pushes, const GradedLattice& graded, Index most) {
  const GradedLattice::Statics statics(graded);
  const VectorXd mass = graded.mass();
  MatrixXd basis(graded.dof(), 0);
  for (MatrixXd loads = loads_of(pushes, graded); loads.cols() > 0 && basis.cols() < most;) {
    const Index left = most - basis.cols();
    if (left < loads.cols()) { loads = (loads * random_matrix(loads.cols(), left)).eval(); }
    loads = mass.asDiagonal() * add_orthogonal(mass, statics.respond(loads), most, basis);
  }
  return basis;
}

/// Directions in which a Gram matrix is rounding are left out.
constexpr double least_share = 1e-11;

/// Columns c with c^T a c = 1 each, and 0 between two.
MatrixXd independent(const MatrixXd& a) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> modes(a);
  const double least = least_share * modes.eigenvalues().maxCoeff();
  const Index left_out = (modes.eigenvalues().array() <= least).count();
  const Index kept = a.rows() - left_out;
  return modes.eigenvectors().rightCols(kept) *
         modes.eigenvalues().tail(kept).cwiseSqrt().cwiseInverse().asDiagonal();
}

/// Which columns far nodes have, and in them what `response` (coarse coordinates in columns) moves them by.
FarShapes far_part(const NetworkProblem& problem, const NearNodes& near, const GradedLattice& graded,
                   const MatrixXd& response) {
  FarShapes shapes;
  shapes.column.assign(static_cast<std::size_t>(problem.network().node_count()), -1);
  std::ptrdiff_t columns = 0;
  for (const int node : problem.free_nodes()) {
    if (near.holds(node)) { continue; }
    shapes.column[static_cast<std::size_t>(node)] = columns;
    columns += 3;
  }
  shapes.phi = MatrixXd::Zero(response.rows(), columns);
  for (const int node : problem.free_nodes()) {
    if (!shapes.holds(node)) { continue; }
    const GradedLattice::Place place = graded.place_of(node);
    for (std::size_t c = 0; c < place.weight.size(); ++c) {
      if (place.coordinate[c] < 0) { continue; }
      shapes.phi.middleCols<3>(shapes.column[static_cast<std::size_t>(node)]) +=
          place.weight[c] * response.middleCols<3>(place.coordinate[c]);
    }
  }
  // Loads differ by orders of magnitude in what they move.
  for (Index n = 0; n < shapes.modes(); ++n) {
    const double size = shapes.phi.row(n).norm();
    if (size > 0.0) { shapes.phi.row(n) /= size; }
  }
  return shapes;
}

/// Each with the mass of a mean node, and none between two.
void share_out_mass(const SpringNetwork& network, FarShapes& shapes) {
  VectorXd mass(shapes.phi.cols());
  for (int node = 0; node < network.node_count(); ++node) {
    if (!shapes.holds(node)) { continue; }
    mass.segment<3>(shapes.column[static_cast<std::size_t>(node)]).setConstant(network.mass(node));
  }
  MatrixXd gram = MatrixXd::Zero(shapes.modes(), shapes.modes());
  gram.selfadjointView<Eigen::Lower>().rankUpdate(shapes.phi * mass.cwiseSqrt().asDiagonal());
  const MatrixXd basis = independent(gram.selfadjointView<Eigen::Lower>());
  shapes.mass = mass.mean();
  shapes.phi = (std::sqrt(shapes.mass) * basis.transpose() * shapes.phi).eval();
}

}  // namespace

FarShapes far_shapes(const NetworkProblem& problem, const LatticeShape& shape, const FarFieldSetting& setting) {
  const GradedLattice graded(problem, shape, setting.near.box);
  const MatrixXd response = responses(setting.pushes, graded, setting.modes).transpose();
  FarShapes shapes = far_part(problem, setting.near, graded, response);
  share_out_mass(problem.network(), shapes);
  if (shapes.modes() == 0) { return shapes; }  // what is pushed does not reach it
  GramSum stiffness(shapes.modes());
  visit_far_springs(problem.network(), shapes, [&](const Spring& spring, const Vector3d&, const VectorXd& grows) {
    stiffness.add(grows, spring.stiffness);
  });
  const Eigen::SelfAdjointEigenSolver<MatrixXd> own(stiffness.take());
  shapes.phi = (own.eigenvectors().transpose() * shapes.phi).eval();
  return shapes;
}

}  // namespace palpate
