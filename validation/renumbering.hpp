// SPDX-License-Identifier: MIT
#pragma once
/// The same network with its nodes and springs in an order of chance: another order of summation,
/// and nothing else.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "model/problem/scene.hpp"
#include "model/problem/spring_network.hpp"

namespace palpate {

/// Renames nodes, shuffles springs and turns each round by chance; loads of the scene follow their
/// nodes. Returns where every node went.
std::vector<int> renumber(SpringNetwork& network, Scene& scene, std::uint64_t seed);

/// A network in another order for as long as it moves.
class OtherOrder {
 public:
  /// Seed 0, or a network without nodes: leaves everything as it is.
  OtherOrder(std::uint64_t seed, SpringNetwork& network, Scene& scene);
  /// Coordinates of the free nodes (dof x times) of that network, in the order that it had; what is
  /// empty stays so.
  void undo(const SpringNetwork& network, Eigen::MatrixXd& coordinates) const;

 private:
  SpringNetwork first_{};
  std::vector<int> node_of_{};  ///< empty: the order is the first one
};

}  // namespace palpate
