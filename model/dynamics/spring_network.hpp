// SPDX-License-Identifier: MIT
#pragma once
/// Tissue as point masses joined by spring-dampers (model/EQUATIONS.md, "Network").
/// Built once (lattice.hpp, or read from files) and never changed afterwards, so that
/// simulations and references can share it.

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "model/dynamics/spring_list.hpp"

namespace palpate {

using NodeVectors = Eigen::Matrix<double, 3, Eigen::Dynamic>;  ///< one column per node

struct SpringNetwork {
  NodeVectors rest_position{};          ///< X   [m]
  NodeVectors initial_displacement{};   ///< x(0) - X [m]; no columns: all zero
  NodeVectors initial_velocity{};       ///< x'(0) [m/s]; no columns: all zero
  Eigen::VectorXd mass{};               ///< [kg]
  std::vector<std::uint8_t> fixed{};    ///< 1: the node never moves
  SpringList springs{};

  [[nodiscard]] Eigen::Index node_count() const { return rest_position.cols(); }
  [[nodiscard]] bool is_fixed(int node) const { return fixed[static_cast<std::size_t>(node)] != 0; }
  [[nodiscard]] Eigen::Vector3d initial_place(int node) const {  ///< x(0) of one node [m]
    if (initial_displacement.cols() == 0) { return rest_position.col(node); }
    return rest_position.col(node) + initial_displacement.col(node);
  }
  [[nodiscard]] NodeVectors initial_position() const {
    if (initial_displacement.cols() == 0) { return rest_position; }
    return rest_position + initial_displacement;
  }
};

}  // namespace palpate
