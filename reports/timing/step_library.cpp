// SPDX-License-Identifier: MIT

#include "reports/timing/step_library.h"

#include <cstdio>
#include <exception>
#include <memory>
#include <string>

#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/scene_file.hpp"
#include "model/stepping/simulation.hpp"

struct palpate_steps {
  palpate::Simulation simulation;
  double tick_length;
  bool diverged = false;
};

namespace {

std::string bytes_of(const Eigen::VectorXd& values) {
  return {reinterpret_cast<const char*>(values.data()),
          static_cast<std::size_t>(values.size()) * sizeof(double)};
}

}  // namespace

extern "C" {

int palpate_steps_version(void) { return 1; }

palpate_steps* palpate_steps_create(const char* scene_file, char* problem,
                                    unsigned long problem_size) {
  try {
    const palpate::io::SceneFile file = palpate::io::read_scene(scene_file);
    return std::make_unique<palpate_steps>(palpate::Simulation(file.scene),
                                           file.scene.simulation.step)
        .release();
  } catch (const std::exception& error) {
    std::snprintf(problem, problem_size, "%s", error.what());
    return nullptr;
  }
}

int palpate_steps_run(palpate_steps* steps, long ticks) {
  for (long n = 0; n < ticks; ++n) {
    if (steps->simulation.tick() != palpate::StepStatus::ok) { steps->diverged = true; }
  }
  return steps->diverged ? 1 : 0;
}

void palpate_steps_digest(palpate_steps* steps, char digest[33]) {
  Eigen::VectorXd values(steps->simulation.problem().dof());
  steps->simulation.coordinates(values);
  std::string bytes = bytes_of(values);
  steps->simulation.velocities(values);
  bytes += bytes_of(values);
  std::snprintf(digest, 33, "%s", palpate::io::content_hash(bytes).c_str());
}

const char* palpate_steps_kernel(const palpate_steps* steps) {
  return steps->simulation.plan().kernel.c_str();
}

long palpate_steps_tick_count(const palpate_steps* steps) { return steps->simulation.tick_count(); }

double palpate_steps_tick_length(const palpate_steps* steps) { return steps->tick_length; }

void palpate_steps_destroy(palpate_steps* steps) { delete steps; }

}  // extern "C"
