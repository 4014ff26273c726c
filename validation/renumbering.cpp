// SPDX-License-Identifier: MIT

#include "validation/renumbering.hpp"

#include <numeric>

#include "model/problem/problem.hpp"
#include "validation/random.hpp"

namespace palpate {

namespace {

/// Matrices without columns stay empty.
void move_columns(const NodeVectors& from, const std::vector<int>& node_of, NodeVectors& to) {
  for (Eigen::Index i = 0; i < from.cols(); ++i) {
    to.col(node_of[static_cast<std::size_t>(i)]) = from.col(i);
  }
}

}  // namespace

std::vector<int> renumber(SpringNetwork& network, Scene& scene, std::uint64_t seed) {
  const SpringNetwork first = network;
  Random random(seed);
  std::vector<int> node_of(static_cast<std::size_t>(first.node_count()));
  std::iota(node_of.begin(), node_of.end(), 0);
  random.shuffle(node_of);
  const auto to = [&](int node) { return node_of[static_cast<std::size_t>(node)]; };
  move_columns(first.rest_position, node_of, network.rest_position);
  move_columns(first.initial_displacement, node_of, network.initial_displacement);
  move_columns(first.initial_velocity, node_of, network.initial_velocity);
  for (int i = 0; i < first.node_count(); ++i) {
    network.mass(to(i)) = first.mass(i);
    network.fixed[static_cast<std::size_t>(to(i))] = first.fixed[static_cast<std::size_t>(i)];
  }
  network.springs.change_each([&](Spring& s) {
    s.a = to(s.a);
    s.b = to(s.b);
    if (random(0.0, 1.0) < 0.5) { std::swap(s.a, s.b); }
  });
  network.springs.edit([&](std::vector<Spring>& all) { random.shuffle(all); });
  for (Load& load : scene.loads) {
    for (int& node : load.nodes) { node = to(node); }
  }
  return node_of;
}

OtherOrder::OtherOrder(std::uint64_t seed, SpringNetwork& network, Scene& scene) {
  if (seed == 0 || network.node_count() == 0) { return; }
  first_ = network;
  node_of_ = renumber(network, scene, seed);
}

void OtherOrder::undo(const SpringNetwork& network, Eigen::MatrixXd& coordinates) const {
  if (node_of_.empty() || coordinates.size() == 0) { return; }
  const NetworkProblem before(first_);
  const NetworkProblem after(network);
  const Eigen::MatrixXd found = coordinates;
  for (const int node : before.free_nodes()) {
    const int there = node_of_[static_cast<std::size_t>(node)];
    coordinates.middleRows<3>(before.coordinate(node)) =
        found.middleRows<3>(after.coordinate(there));
  }
}

}  // namespace palpate
