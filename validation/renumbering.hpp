// SPDX-License-Identifier: MIT
#pragma once
/// Random permutation of the nodes and springs of a network, which changes only the order of
/// summation.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "model/problem/scene.hpp"
#include "model/problem/spring_network.hpp"

namespace palpate {

/// Permutes nodes, shuffles springs and swaps their ends at random; loads of the scene follow their
/// nodes. Returns the new index of every node.
std::vector<int> renumber(SpringNetwork& network, Scene& scene, std::uint64_t seed);

/// Permutes a network on construction and converts results back to the original order.
class OtherOrder {
 public:
  /// Does nothing if the seed is 0 or the network has no nodes.
  OtherOrder(std::uint64_t seed, SpringNetwork& network, Scene& scene);
  /// Converts coordinates of the free nodes (dof x times) of `network` to the original order. Empty
  /// matrices stay empty.
  void undo(const SpringNetwork& network, Eigen::MatrixXd& coordinates) const;

 private:
  SpringNetwork first_{};
  std::vector<int> node_of_{};  ///< new index of each node; empty: original order
};

}  // namespace palpate
