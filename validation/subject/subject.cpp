// SPDX-License-Identifier: MIT
#include "validation/subject/subject.hpp"

namespace palpate {

void ModelSubject::load(const Scene& scene, const SpringNetwork& network, bool skip) {
  simulation_.reset();
  if (network.node_count() == 0) {
    simulation_.emplace(scene, skip);
  } else {
    simulation_.emplace(scene, network, skip);
  }
}

}  // namespace palpate
