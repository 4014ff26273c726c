// SPDX-License-Identifier: MIT
#pragma once
/// Networks that no formula was made for: same seed, same network, on every machine.

#include <cmath>
#include <cstdint>

#include "model/dynamics/spring_network.hpp"
#include "validation/random.hpp"

namespace palpate {

struct RandomNetwork {
  int nodes = 12;
  int springs = 40;
  int fixed = 2;
  double decades = 2.0;    ///< of stiffness, viscosity and mass
  double stretch = 0.2;    ///< rest lengths differ from distances by up to this share
  double viscosity = 0.1;  ///< [N s/m] the largest; 0: undamped
};

/// Every node has a spring to an earlier one; ends are in random order.
inline SpringNetwork random_network(std::uint64_t seed, const RandomNetwork& wanted = {}) {
  Random random(seed);
  const auto decades = [&](double largest) {
    return largest * std::pow(10.0, -random(0.0, wanted.decades));
  };
  SpringNetwork network;
  network.rest_position =
      NodeVectors::NullaryExpr(3, wanted.nodes, [&] { return random(-0.01, 0.01); });
  network.initial_velocity =
      NodeVectors::NullaryExpr(3, wanted.nodes, [&] { return random(-0.1, 0.1); });
  network.mass = Eigen::VectorXd::NullaryExpr(wanted.nodes, [&] { return decades(1e-2); });
  network.fixed.assign(static_cast<std::size_t>(wanted.nodes), 0);
  for (int n = 0; n < wanted.fixed; ++n) { network.fixed[static_cast<std::size_t>(3 * n)] = 1; }
  for (int n = 0; n < wanted.springs; ++n) {
    const int b = n + 1 < wanted.nodes ? n + 1 : static_cast<int>(random(1.0, wanted.nodes));
    const int a = static_cast<int>(random(0.0, b));
    const double length = (network.rest_position.col(b) - network.rest_position.col(a)).norm();
    const bool turned = random(0.0, 1.0) < 0.5;
    network.springs.push_back({turned ? b : a, turned ? a : b, decades(1e3),
                               wanted.viscosity > 0.0 ? decades(wanted.viscosity) : 0.0,
                               length * (1.0 + random(-wanted.stretch, wanted.stretch))});
  }
  return network;
}

}  // namespace palpate
