// SPDX-License-Identifier: MIT
#pragma once
/// Lattices in made-up motion, for the tests of views.

#include "model/dynamics/network_builder.hpp"
#include "reports/view.hpp"

namespace palpate {

struct ViewSample {
  Scene scene{};
  std::unique_ptr<NetworkProblem> problem{};
  Trace trace{};
  Moments moments{};

  [[nodiscard]] std::optional<View> view() const { return make_view({scene, *problem, trace, moments}); }
};

/// A block that is pressed at its middle, deeper in every frame, by a load that grows.
inline ViewSample pressed_block(std::array<int, 3> nodes, int frames) {
  ViewSample sample;
  sample.scene.tissue.lattice = {
      .nodes = nodes, .spacing = 0.004, .weights = LatticeWeights::uniform, .node_mass = 1e-3};
  sample.scene.loads = {{.nodes = {0}, .force = {0.0, 0.0, 2.0}, .profile = Profile::constant}};
  const SpringNetwork network = build_network(sample.scene);
  for (int n = 0; n < frames; ++n) {
    NodeVectors position = network.rest_position;
    for (Eigen::Index node = 0; node < position.cols(); ++node) {
      if (network.is_fixed(static_cast<int>(node))) { continue; }
      const Eigen::Vector3d x = network.rest_position.col(node);
      position(2, node) += 1e-3 * n / frames * std::exp(-1e4 * x.head<2>().squaredNorm()) * std::exp(-60.0 * x.z());
      position(0, node) += 1e-4 * n / frames * std::sin(900.0 * x.y() + 31.0 * static_cast<double>(node));
    }
    sample.trace.frame_time.push_back(0.01 * n);
    sample.trace.frames.push_back(position);
    sample.trace.time.push_back(0.01 * n);
  }
  sample.problem = std::make_unique<NetworkProblem>(network, resolve_loads(sample.scene, network));
  return sample;
}

}  // namespace palpate
