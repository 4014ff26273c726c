// SPDX-License-Identifier: MIT
#include "validation/certificate/provocation.hpp"

#include <algorithm>
#include <array>
#include <map>

#include "model/dynamics/network_builder.hpp"
#include "validation/certificate/timed_passes.hpp"

namespace palpate::certificate {

namespace {

using Make = std::function<std::unique_ptr<SceneLoop>()>;

/// Ticks of a provocation that looks at the beginning of a scene alone.
constexpr std::size_t beginning = 200;

class Provoker {
 public:
  Provoker(const Scene& scene, const ProvocationPlan& plan) : scene_(scene), plan_(plan) {}

  ComputeBudget run() {
    whole_ = time({.make = loop_with({})}, "the scene as fast as it goes");
    budget_.diverged_at = whole_.diverged_at;
    budget_.largest_speed = whole_.largest_speed;
    if (whole_.passes > 0) {
      add_scene();
      add_beginning("nothing skipped", "everything awake: what the scene does not need is computed too",
                    loop_with({.skip = false}));
      add_denormals();
      if (scene_.syringe || (scene_.drive && scene_.drive->kind == Drive::Kind::falcon)) { add_faults(); }
      add_cold_caches();
    }
    std::ranges::stable_sort(budget_.provocations, std::ranges::greater{}, &Provocation::processor);
    return std::move(budget_);
  }

 private:
  Make loop_with(const SceneLoopOptions& options) const {
    return [this, options] { return std::make_unique<SceneLoop>(scene_, plan_.rate, options); };
  }
  TimedPasses time(const PassSetting& setting, const std::string& stage) const {
    if (plan_.tell) { plan_.tell(stage); }
    return time_passes(setting, plan_);
  }
  void add(const std::string& name, const std::string& what, const TimedPasses& passes, std::size_t tick,
           std::size_t tried) {
    const TimedTick& worst = passes.ticks[tick];
    budget_.provocations.push_back({.name = name,
                                    .what = what,
                                    .scene_time = static_cast<double>(tick) / plan_.rate,
                                    .processor = worst.processor,
                                    .wall = worst.wall,
                                    .repetitions = passes.passes,
                                    .ticks = static_cast<long>(tried)});
  }
  void add_scene() {
    add("first tick", "the first after a start", whole_, 0, 1);
    add("costliest tick", "any tick of the scene", whole_, whole_.costliest(0, whole_.ticks.size()),
        whole_.ticks.size());
    const HappeningNames names(scene_);
    std::map<std::string, std::vector<std::size_t>> ticks;
    for (const Happened& each : whole_.happenings) { ticks[names.of(each.happening)].push_back(each.tick); }
    for (const auto& [name, all] : ticks) {
      add(name, "as the scene has it", whole_, whole_.costliest(all), all.size());
    }
  }
  void add_beginning(const std::string& name, const std::string& what, const Make& make) {
    const TimedPasses passes = time({.make = make, .most_ticks = beginning}, name);
    if (passes.passes == 0) { return; }
    add(name, what, passes, passes.costliest(0, passes.ticks.size()), passes.ticks.size());
  }
  /// Velocities that no longer have all their digits, as where a motion dies away.
  void add_denormals() {
    constexpr double denormal = 1e-310;
    const std::string name = "denormal numbers";
    const std::string what = "all velocities or displacements 1e-310 at the start";
    if (scene_.tissue.source == Source::oscillator) {
      Scene still = scene_;
      still.tissue.oscillator.displacement = denormal;
      still.tissue.oscillator.velocity = denormal;
      still.tissue.oscillator.drive_amplitude = 0.0;
      add_beginning(name, what, [&] { return std::make_unique<SceneLoop>(still, plan_.rate); });
      return;
    }
    SpringNetwork network = build_network(scene_);
    network.initial_velocity = NodeVectors::Zero(3, network.node_count());
    for (int node = 0; node < network.node_count(); ++node) {
      if (!network.is_fixed(node)) { network.initial_velocity.col(node).setConstant(denormal); }
    }
    add_beginning(name, what, loop_with({.network = &network}));
  }
  void add_faults() {
    const TimedPasses passes = time({.make = loop_with({.faults = true})}, "faults on the lines");
    if (passes.passes == 0) { return; }
    add("faults on the lines", "bytes lost, doubled and changed on every line of the scene, power lost once",
        passes, passes.costliest(0, passes.ticks.size()), passes.ticks.size());
  }
  /// Before its most telling ticks every cache is filled with something else.
  void add_cold_caches() {
    std::vector<std::size_t> chosen{0, whole_.costliest(0, whole_.ticks.size())};
    for (const Happened& each : whole_.happenings) { chosen.push_back(each.tick); }
    for (std::size_t n = 1; n < spread; ++n) { chosen.push_back(n * whole_.ticks.size() / spread); }
    std::ranges::sort(chosen);
    chosen.erase(std::ranges::unique(chosen).begin(), chosen.end());
    std::vector<double> other(2 * plan_.cache_bytes / sizeof(double), 1.0);
    const auto walk = [&](std::size_t tick) {
      if (!std::ranges::binary_search(chosen, tick)) { return; }
      for (double& number : other) { number += 1.0; }
    };
    const TimedPasses passes = time({.make = loop_with({}), .before = walk}, "cold caches");
    if (passes.passes == 0) { return; }
    add("cold caches", "a walk through twice the largest cache before first, costliest and eventful ticks",
        passes, passes.costliest(chosen), chosen.size());
  }

  static constexpr std::size_t spread = 16;  ///< further ticks, evenly over the scene
  const Scene& scene_;
  const ProvocationPlan& plan_;
  TimedPasses whole_{};
  ComputeBudget budget_{};
};

}  // namespace

ComputeBudget provoke(const Scene& scene, const ProvocationPlan& plan) { return Provoker(scene, plan).run(); }

}  // namespace palpate::certificate
