// SPDX-License-Identifier: MIT

#include <algorithm>
#include <cmath>
#include <exception>

#include "model/tissue/network_builder.hpp"
#include "validation/subject/subject.hpp"

namespace palpate {

const Scene& ModelSubject::take_changes(const Scene& scene, bool skip) {
  skip_ = skip;
  changes_.clear();
  next_change_ = 0;
  first_.reset();
  failure_.clear();
  for (std::size_t n = 0; n < scene.materials.size(); ++n) {
    for (const ModulusChange& change : scene.materials[n].changes) {
      changes_.push_back(
          {std::lround(change.time / scene.simulation.step), n, change.youngs_modulus});
    }
  }
  if (changes_.empty()) { return scene; }
  std::ranges::stable_sort(changes_, {}, &MaterialChange::tick);
  scene_ = scene;
  for (Material& material : scene_.materials) { material.changes.clear(); }
  return scene_;
}

void ModelSubject::load(const Scene& given, const SpringNetwork& network, bool skip) {
  const Scene& scene = take_changes(given, skip);
  network.node_count() == 0 ? simulation_.emplace(scene, skip)
                            : simulation_.emplace(scene, network, skip);
}

void ModelSubject::load(const Scene& given, bool skip) {
  simulation_.emplace(take_changes(given, skip), skip);
}

bool ModelSubject::change_materials() noexcept {
  try {
    while (next_change_ < changes_.size() && changes_[next_change_].tick <= ticks()) {
      const MaterialChange& change = changes_[next_change_++];
      scene_.materials[change.material].youngs_modulus = change.youngs_modulus;
    }
    Simulation next(scene_, build_network(scene_), skip_);
    next.prepare_to_continue(*simulation_);
    exchange(next);
    if (!first_) { first_.emplace(std::move(next)); }
  } catch (const std::exception& problem) {
    failure_ = std::string("a change of a material: ") + problem.what();
  }
  return failure_.empty();
}

}  // namespace palpate
