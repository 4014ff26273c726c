// SPDX-License-Identifier: MIT
#include "validation/certificate/missed_tick.hpp"

#include <algorithm>
#include <cmath>

#include "validation/falcon_loop.hpp"

namespace palpate::certificate {

namespace {

/// A run up to some tick, with an observer at the grip of the device itself, not at its counts.
class ObservedRun {
 public:
  explicit ObservedRun(const Scene& scene) : simulation_(scene), loop_(scene, simulation_) {
    observer_.observe(0.0, place(), Eigen::Vector3d::Zero());
  }
  StepStatus tick(bool missed) {
    const StepStatus status = missed ? loop_.missed_device_tick() : loop_.device_tick();
    observer_.observe(loop_.falcon().time(), place(), loop_.force_sent());
    return status;
  }
  [[nodiscard]] bool over() const { return simulation_.ticks() >= simulation_.tick_count(); }
  [[nodiscard]] Eigen::Vector3d place() const { return loop_.falcon().body().plant().position(); }
  [[nodiscard]] const Eigen::Vector3d& force() const { return loop_.force_sent(); }
  [[nodiscard]] double energy() const { return observer_.energy(); }
  [[nodiscard]] double time() const { return loop_.falcon().time(); }
  Simulation& simulation() { return simulation_; }

 private:
  Simulation simulation_;
  FalconLoop loop_;
  device::PassivityObserver observer_{};
};

struct Worst {
  long tick = -1;
  double given = 0.0;  ///< foretold from the kept run [J]
  double speed = 0.0;  ///< [m/s]
};

/// The force of the tick before instead of this one's, over the way of the grip in it.
Worst worst_tick(const Scene& scene, double period, const std::atomic<bool>* stop) {
  Worst worst;
  ObservedRun run(scene);
  Eigen::Vector3d place = run.place();
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (long n = 0; !run.over() && !(stop != nullptr && stop->load()); ++n) {
    run.simulation().forget_tool_happenings();
    if (run.tick(false) == StepStatus::diverged) { break; }
    const Eigen::Vector3d way = run.place() - place;
    const double given = (force - run.force()).dot(way);
    worst.speed =
        std::max({worst.speed, way.norm() / period, std::abs(run.simulation().tool_motion().velocity)});
    if (n > 0 && given > worst.given) {
      worst.tick = n;
      worst.given = given;
    }
    place = run.place();
    force = run.force();
  }
  return worst;
}

}  // namespace

MissedTick bounded_missed_tick(double stiffness, double speed, double period) {
  const double way = speed * period;
  const double energy = stiffness * way * way;
  return {.stiffness = stiffness, .speed = speed, .bound = 0.5 * energy, .sampled_bound = energy};
}

MissedTick measure_missed_tick(const Scene& scene, const std::atomic<bool>* stop) {
  const FalconDrive settings = scene.falcon.value_or(FalconDrive{});
  const double period = 1.0 / settings.rate;
  const Worst worst = worst_tick(scene, period, stop);
  MissedTick result = bounded_missed_tick(settings.coupling_stiffness, worst.speed, period);
  result.measured = 0.0;
  if (worst.tick < 0) { return result; }  // no force ever changed against the way of the grip
  ObservedRun kept(scene);
  ObservedRun missed(scene);
  for (long n = 0; n <= worst.tick; ++n) {
    kept.simulation().forget_tool_happenings();
    missed.simulation().forget_tool_happenings();
    (void)kept.tick(false);
    (void)missed.tick(n == worst.tick);
  }
  result.measured = kept.energy() - missed.energy();
  result.measured_at = kept.time();
  return result;
}

}  // namespace palpate::certificate
