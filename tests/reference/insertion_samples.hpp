// SPDX-License-Identifier: MIT
#pragma once
// Scenes of a needle with closed forms or small enough to be quick.

#include <string>
#include <vector>

#include "model/dynamics/network_builder.hpp"
#include "reference/insertion.hpp"
#include "tests/reference/sample_problems.hpp"

namespace sample {

/// A chain of nodes below the entry, the last one fixed. Its stiffness is stiffness / springs.
struct Chain {
  int springs = 5;
  double spacing = 0.01;     ///< [m]
  double stiffness = 200.0;  ///< [N/m] of each spring
  double viscosity = 1.0;    ///< [N s/m] of each spring
  double mass = 1e-3;        ///< [kg] of each node

  [[nodiscard]] palpate::SpringNetwork network() const {
    palpate::SpringNetwork made;
    made.rest_position.setZero(3, springs + 1);
    made.mass = Eigen::VectorXd::Constant(springs + 1, mass);
    made.fixed.assign(static_cast<std::size_t>(springs) + 1, 0);
    made.fixed.back() = 1;
    for (int i = 0; i <= springs; ++i) { made.rest_position(2, i) = i * spacing; }
    for (int i = 0; i < springs; ++i) {
      made.springs.push_back({i, i + 1, stiffness, viscosity, spacing});
    }
    return made;
  }
};

struct Stratum {
  double thickness = 0.0;      ///< [m]
  double cutting_force = 0.0;  ///< [N]
  double friction = 0.0;       ///< [N/m]
  palpate::TissueRole role = palpate::TissueRole::tissue;
};

inline const std::vector<Stratum> two_layers{{0.015, 0.06, 1.0}, {0.025, 0.12, 2.0}};
inline const std::vector<Stratum> three_layers{
    {0.012, 0.2, 10.0}, {0.01, 0.5, 15.0}, {0.1, 0.1, 5.0}};

/// A needle into a network with these layers.
inline palpate::Scene needle_scene(const palpate::SpringNetwork& network,
                                   const std::vector<Stratum>& strata,
                                   const palpate::Drive& drive) {
  palpate::Scene scene;
  scene.tissue.source = palpate::Source::network;
  scene.tissue.network = network;
  for (std::size_t n = 0; n < strata.size(); ++n) {
    const std::string name = "layer " + std::to_string(n);
    scene.materials.push_back({.name = name,
                               .youngs_modulus = 1e4,
                               .damping_ratio = 0.3,
                               .cutting_force = strata[n].cutting_force,
                               .friction = strata[n].friction,
                               .role = strata[n].role});
    scene.tissue.layers.push_back({name, name, strata[n].thickness});
  }
  scene.needle = palpate::Needle{};
  scene.drive = drive;
  return scene;
}

/// The same layers as a block of elastic solid, fixed at its bottom.
inline palpate::Scene block_scene(int across, const std::vector<Stratum>& strata,
                                  const palpate::Drive& drive) {
  palpate::Scene scene = needle_scene({}, strata, drive);
  scene.tissue.source = palpate::Source::layers;
  scene.tissue.block = {.nodes = {across, across}, .spacing = 0.005};
  return scene;
}

inline constexpr palpate::reference::InsertionOptions with_energy{
    .account = palpate::reference::InsertionOptions::Account::energy};

inline palpate::reference::Insertion solve(
    const palpate::Scene& scene, double end, int count, double relative = 1e-9,
    const palpate::reference::InsertionOptions& options = {}) {
  return palpate::reference::solve_insertion(scene, palpate::build_network(scene),
                                             instants(end, count), {.relative = relative}, options);
}

inline const palpate::reference::InsertionEvent* first_of(
    const palpate::reference::Insertion& run, palpate::reference::InsertionEvent::Kind kind) {
  for (const auto& event : run.events) {
    if (event.kind == kind) { return &event; }
  }
  return nullptr;
}

/// Stored and lost energy over what the hand gave [J].
inline double imbalance(const palpate::reference::Insertion& run) {
  const auto& first = run.instants.front().energy;
  const auto& last = run.instants.back().energy;
  return last.stored - first.stored + last.dampers + last.friction + last.cutting + last.impacts -
         first.impacts - (last.hand - first.hand);
}

}  // namespace sample
