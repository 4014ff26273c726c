// SPDX-License-Identifier: MIT
#include "reports/force_lines.hpp"

#include <Eigen/Eigenvalues>

namespace palpate {

namespace {

using Tensors = Eigen::Matrix<double, 9, Eigen::Dynamic>;

/// Direction and size of the eigenvalue furthest from zero.
Eigen::Vector4f principal(const Eigen::Matrix3d& tensor) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(tensor);
  const Eigen::Vector3d& forces = solver.eigenvalues();
  const int at = std::abs(forces(0)) > std::abs(forces(2)) ? 0 : 2;  // ascending
  Eigen::Vector4d line;
  line << solver.eigenvectors().col(at), forces(at);
  return line.allFinite() ? Eigen::Vector4f(line.cast<float>()) : Eigen::Vector4f::Zero();
}

}  // namespace

ForceLines force_lines(const SpringNetwork& network, const SpringLaw& law, const NodeVectors& position) {
  ForceLines result;
  Tensors tensors = Tensors::Zero(9, position.cols());
  for (const Spring& spring : network.springs) {
    const Eigen::Vector3d d = position.col(spring.b) - position.col(spring.a);
    const double length = d.norm();
    if (!(length >= zero_length)) { continue; }
    const Eigen::Vector3d u = d / length;
    const Eigen::Vector3d on_a = spring_force<double>(law, spring.stiffness, 0.0, spring.rest_length, d, length, 0.0);
    const Eigen::Matrix3d pull = 0.5 * on_a * u.transpose();
    tensors.col(spring.a) += pull.reshaped();
    tensors.col(spring.b) += pull.reshaped();
    if (network.is_fixed(spring.a)) { result.held += on_a; }
    if (network.is_fixed(spring.b)) { result.held -= on_a; }
  }
  result.line = Eigen::Matrix4Xf::Zero(4, position.cols());
  for (Eigen::Index node = 0; node < position.cols(); ++node) {
    if (tensors.col(node).isZero(0.0)) { continue; }
    result.line.col(node) = principal(tensors.col(node).reshaped(3, 3));
  }
  return result;
}

}  // namespace palpate
