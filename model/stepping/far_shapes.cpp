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

/// Columns are forces on the coarse coordinates [N].
MatrixXd loads_of(const GradedLattice& graded, const NetworkProblem& problem, const LatticeShape& shape,
                  const LatticeBox& box, const NeedlePath& path, int modes) {
  MatrixXd loads = MatrixXd::Zero(graded.dof(), modes);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const auto of_knots = static_cast<Index>(3 * path.knots().size());
  MatrixXd on_knots = MatrixXd::Zero(graded.dof(), of_knots);
  for (std::size_t k = 0; k < path.knots().size(); ++k) {
    for (const NeedlePath::Support& support : path.supports(path.knots()[k])) {
      const Index at = graded.coordinate(support.node);
      if (at < 0) { continue; }
      for (Index c = 0; c < 3; ++c) { on_knots(at + c, 3 * static_cast<Index>(k) + c) = support.weight; }
    }
  }
  if (modes < of_knots) {
    return on_knots * MatrixXd::NullaryExpr(of_knots, modes, [&] { return normal(random); });
  }
  loads.leftCols(of_knots) = on_knots;
  for (int node = 0; node < shape.node_count(); ++node) {
    if (problem.coordinate(node) < 0 || !box.holds(shape.place(node))) { continue; }
    for (Index c = 0; c < 3; ++c) {
      for (Index n = of_knots; n < modes; ++n) { loads(graded.coordinate(node) + c, n) = normal(random); }
    }
  }
  return loads;
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
FarShapes far_part(const NetworkProblem& problem, const LatticeShape& shape, const LatticeBox& box,
                   const GradedLattice& graded, const MatrixXd& response) {
  FarShapes shapes;
  shapes.column.assign(static_cast<std::size_t>(problem.network().node_count()), -1);
  std::ptrdiff_t columns = 0;
  for (const int node : problem.free_nodes()) {
    if (box.holds(shape.place(node))) { continue; }
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

FarShapes far_shapes(const NetworkProblem& problem, const LatticeShape& shape, const LatticeBox& box,
                     const NeedlePath& path, int modes) {
  const GradedLattice graded(problem, shape, box);
  const MatrixXd response = graded.respond(loads_of(graded, problem, shape, box, path, modes)).transpose();
  FarShapes shapes = far_part(problem, shape, box, graded, response);
  share_out_mass(problem.network(), shapes);
  GramSum stiffness(shapes.modes());
  visit_far_springs(problem.network(), shapes, [&](const Spring& spring, const Vector3d&, const VectorXd& grows) {
    stiffness.add(grows, spring.stiffness);
  });
  const Eigen::SelfAdjointEigenSolver<MatrixXd> own(stiffness.take());
  shapes.phi = (own.eigenvectors().transpose() * shapes.phi).eval();
  return shapes;
}

}  // namespace palpate
