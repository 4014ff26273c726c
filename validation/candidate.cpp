// SPDX-License-Identifier: MIT
#include "validation/candidate.hpp"

#include <chrono>
#include <optional>

#include "model/dynamics/network_builder.hpp"
#include "model/stepping/simulation.hpp"
#include "validation/case.hpp"
#include "validation/renumbering.hpp"

namespace palpate {

namespace {

/// Columns are appended to buffers that are sized once.
class Sampler {
 public:
  Sampler(Simulation& simulation, const Wanted& wanted, Motion& motion)
      : simulation_(simulation), wanted_(wanted), motion_(motion) {
    const Eigen::Index samples = simulation.tick_count() / wanted.every + 2;
    motion.position.resize(simulation.problem().dof(), samples);
    if (wanted.velocity) { motion.velocity.resize(simulation.problem().dof(), samples); }
  }
  void take() {
    const auto column = static_cast<Eigen::Index>(motion_.time.size());
    motion_.time.push_back(simulation_.time());
    simulation_.coordinates(motion_.position.col(column));
    if (wanted_.velocity) { simulation_.velocities(motion_.velocity.col(column)); }
    if (wanted_.energy) { motion_.energy.push_back(simulation_.energy()); }
  }
  void finish() {
    const auto samples = static_cast<Eigen::Index>(motion_.time.size());
    motion_.position.conservativeResize(Eigen::NoChange, samples);
    if (wanted_.velocity) { motion_.velocity.conservativeResize(Eigen::NoChange, samples); }
  }

 private:
  Simulation& simulation_;
  const Wanted& wanted_;
  Motion& motion_;
};

}  // namespace

Motion simulate(const CaseContext& context, Scene scene, const SpringNetwork* network,
                const Wanted& wanted) {
  SpringNetwork own = network != nullptr ? *network
                      : scene.tissue.source == Source::oscillator ? SpringNetwork{}
                                                                  : build_network(scene);
  const Mutation* mutation = context.mutation;
  if (mutation != nullptr && mutation->model) { mutation->model(scene, own); }
  if (mutation != nullptr && mutation->step_twice) {
    scene.simulation.step *= 2.0;
    scene.simulation.duration *= 2.0;
  }
  const OtherOrder order(context.order, own, scene);
  std::optional<Simulation> simulation;
  if (scene.tissue.source == Source::oscillator && network == nullptr) {
    simulation.emplace(scene, context.skip);
  } else {
    simulation.emplace(scene, own, context.skip);
  }
  Motion motion;
  motion.substeps = simulation->plan().substeps;
  motion.h = simulation->plan().h;
  Sampler sampler(*simulation, wanted, motion);
  sampler.take();
  const long ticks = simulation->tick_count();
  for (long n = 1; n <= ticks; ++n) {
    const auto begin = std::chrono::steady_clock::now();
    const StepStatus status = simulation->tick();
    motion.seconds +=
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    motion.steps += simulation->plan().substeps;
    if (status == StepStatus::diverged) {
      motion.diverged = true;
      motion.diverged_at = simulation->time();
      break;
    }
    if (n % wanted.every == 0 || n == ticks) { sampler.take(); }
  }
  sampler.finish();
  order.undo(own, motion.position);
  order.undo(own, motion.velocity);
  if (mutation != nullptr && mutation->step_twice) {
    for (double& t : motion.time) { t *= 0.5; }
  }
  if (mutation != nullptr && mutation->motion) { mutation->motion(motion); }
  return motion;
}

Scene scene_of(const std::string& integrator, double step, double duration, int substeps) {
  Scene scene;
  scene.simulation.integrator = integrator;
  scene.simulation.step = step;
  scene.simulation.duration = duration;
  scene.simulation.substeps = substeps;
  scene.tissue.source = Source::network;
  return scene;
}

}  // namespace palpate
