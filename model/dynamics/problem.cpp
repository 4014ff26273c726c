// SPDX-License-Identifier: MIT
#include "model/dynamics/problem.hpp"

#include <cmath>
#include <numbers>

#include "model/dynamics/network_builder.hpp"

namespace palpate {

double load_factor(const Load& load, double t, double gate) noexcept {
  if (gate < load.start || gate >= load.end) { return 0.0; }
  if (load.profile == Profile::constant) { return 1.0; }
  const double phase = (t - load.start) / (load.end - load.start);
  return load.profile == Profile::ramp ? phase : std::sin(std::numbers::pi * phase);
}

std::unique_ptr<Problem> make_problem(const Scene& scene) {
  if (scene.tissue.source == Source::oscillator) {
    return std::make_unique<OscillatorProblem>(scene.tissue.oscillator);
  }
  SpringNetwork network = build_network(scene);
  std::vector<Load> loads = resolve_loads(scene, network);
  return std::make_unique<NetworkProblem>(std::move(network), std::move(loads),
                                          scene.tissue.gravity, scene.simulation.printed);
}

}  // namespace palpate
