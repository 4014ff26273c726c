// SPDX-License-Identifier: MIT

#include "validation/certificate/worst_case_probe.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "model/problem/tool.hpp"
#include "model/reduction/mode_basis.hpp"
#include "model/stepping/step_plan.hpp"
#include "model/tissue/network_builder.hpp"
#include "validation/bench/timing.hpp"
#include "validation/number_text.hpp"

namespace palpate::certificate {

namespace {

/// Run up to a given tick, with an observer at the grip of the device, not at the encoder counts.
class ObservedRun {
 public:
  explicit ObservedRun(const Scene& scene) : loop_(scene, rate_of(scene)) {
    observer_.observe(0.0, place(), Eigen::Vector3d::Zero());
  }
  StepStatus tick() {
    const StepStatus status = loop_.tick();
    observe();
    return status;
  }
  /// Only as the last tick of a run.
  void miss_tick() {
    (void)loop_.falcon()->missed_device_tick();
    observe();
  }
  [[nodiscard]] bool over() const { return loop_.over(); }
  [[nodiscard]] Eigen::Vector3d place() {
    return loop_.falcon()->falcon().body().plant().position();
  }
  [[nodiscard]] const Eigen::Vector3d& force() { return loop_.falcon()->force_sent(); }
  [[nodiscard]] double energy() const { return observer_.energy(); }
  [[nodiscard]] double time() { return loop_.falcon()->falcon().time(); }
  [[nodiscard]] double tool_velocity() { return loop_.subject().tool_motion().velocity; }

 private:
  void observe() { observer_.observe(time(), place(), force()); }

  SceneLoop loop_;
  device::PassivityObserver observer_{};
};

struct Worst {
  long tick = -1;
  double given = 0.0;  ///< predicted energy [J]
  double speed = 0.0;  ///< [m/s]
};

/// Finds the tick with the largest work error if the force of the previous tick acts over the grip
/// displacement of this tick.
Worst worst_tick(const Scene& scene, double period, const std::atomic<bool>* stop) {
  Worst worst;
  ObservedRun run(scene);
  Eigen::Vector3d place = run.place();
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (long n = 0; !run.over() && !(stop != nullptr && stop->load()); ++n) {
    if (run.tick() == StepStatus::diverged) { break; }
    const Eigen::Vector3d way = run.place() - place;
    const double given = (force - run.force()).dot(way);
    worst.speed = std::max({worst.speed, way.norm() / period, std::abs(run.tool_velocity())});
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
  if (worst.tick < 0) { return result; }  // no force changed against the motion
  ObservedRun kept(scene);
  ObservedRun missed(scene);
  for (long n = 0; n < worst.tick; ++n) {
    (void)kept.tick();
    (void)missed.tick();
  }
  (void)kept.tick();
  missed.miss_tick();
  result.measured = kept.energy() - missed.energy();
  result.measured_at = kept.time();
  return result;
}

namespace {

using bench::Clock;
using bench::seconds_on;

bool is_stopped(const ProbePlan& plan) {
  return plan.stop != nullptr && plan.stop->load(std::memory_order_relaxed);
}

TimedTick time_tick(SceneLoop& loop, StepStatus& status) {
  const double wall = seconds_on(Clock::wall);
  const double processor = seconds_on(Clock::processor);
  status = loop.tick();
  const double processor_after = seconds_on(Clock::processor);
  return {.processor = processor_after - processor, .wall = seconds_on(Clock::wall) - wall};
}

/// Runs one pass from the start; it has fewer ticks if it was stopped or diverged.
TimedPasses one_pass(const PassSetting& setting, const ProbePlan& plan) {
  const std::unique_ptr<SceneLoop> loop = setting.make();
  TimedPasses pass;
  auto count = static_cast<std::size_t>(loop->tick_count());
  if (setting.most_ticks > 0) { count = std::min(count, setting.most_ticks); }
  pass.ticks.reserve(count);
  while (pass.ticks.size() < count && !is_stopped(plan)) {
    if (setting.before) { setting.before(pass.ticks.size()); }
    StepStatus status = StepStatus::ok;
    pass.ticks.push_back(time_tick(*loop, status));
    if (status == StepStatus::diverged) {
      pass.diverged_at = loop->subject().time();
      return pass;
    }
    for (const ToolHappening& each : loop->happenings()) {
      pass.happenings.push_back({pass.ticks.size() - 1, each});
    }
    pass.largest_speed =
        std::max(pass.largest_speed, std::abs(loop->subject().tool_motion().velocity));
  }
  pass.passes = pass.ticks.size() == count ? 1 : 0;
  return pass;
}

/// Smallest ratio of the times of a tick in successive passes at which the time is accepted as its
/// cost. On a virtual machine the thread clock also counts time taken by the hypervisor.
constexpr double same = 0.95;

void keep_least(TimedPasses& least, TimedPasses pass) {
  if (least.passes == 0) {
    least = std::move(pass);
    return;
  }
  ++least.passes;
  for (std::size_t k = 0; k < least.ticks.size(); ++k) {
    least.ticks[k].processor = std::min(least.ticks[k].processor, pass.ticks[k].processor);
    least.ticks[k].wall = std::min(least.ticks[k].wall, pass.ticks[k].wall);
  }
}

}  // namespace

double TimedPasses::worst() const { return ticks[costliest()].processor; }

std::size_t TimedPasses::costliest() const {
  const auto worst = std::ranges::max_element(ticks, {}, &TimedTick::processor);
  return static_cast<std::size_t>(worst - ticks.begin());
}

std::size_t TimedPasses::costliest(const std::vector<std::size_t>& of) const {
  return *std::ranges::max_element(of, {}, [this](std::size_t n) { return ticks[n].processor; });
}

TimedPasses time_passes(const PassSetting& setting, const ProbePlan& plan) {
  const double begin = seconds_on(Clock::wall);
  TimedPasses least;
  bool settled = false;
  for (int n = 0; n < plan.most_repetitions; ++n) {
    if (settled && n >= plan.least_repetitions && seconds_on(Clock::wall) - begin > plan.enough) {
      break;
    }
    TimedPasses pass = one_pass(setting, plan);
    if (pass.diverged_at) { return pass; }
    if (pass.passes == 0) { break; }
    const double before = least.passes > 0 ? least.worst() : 0.0;
    keep_least(least, std::move(pass));
    settled = least.worst() >= same * before;
  }
  return least;
}

namespace {

using Make = std::function<std::unique_ptr<SceneLoop>()>;

/// Ticks of a probe that runs only the beginning of a scene.
constexpr std::size_t beginning = 200;

class Prober {
 public:
  Prober(const Scene& scene, const ProbePlan& plan) : scene_(scene), plan_(plan) {}

  ComputeBudget run() {
    whole_ = time_passes({.make = loop_with({})}, plan_);
    budget_.diverged_at = whole_.diverged_at;
    budget_.largest_speed = whole_.largest_speed;
    if (whole_.passes > 0) {
      budget_.happenings = whole_.happenings;
      budget_.absent = absent_events(scene_, whole_.happenings);
      add_scene();
      if (!plan_.subject) {  // what only the model can be asked for
        add_awake();
        add_denormals();
      }
      if (scene_.syringe || (scene_.drive && scene_.drive->kind == Drive::Kind::falcon)) {
        add("faults on the lines",
            "bytes lost, doubled and changed on every line of the scene, power lost once",
            time_passes({.make = loop_with({.faults = true})}, plan_));
      }
      add_cold_caches();
    }
    std::ranges::stable_sort(budget_.probes, std::ranges::greater{}, &WorstCaseProbe::processor);
    return std::move(budget_);
  }

 private:
  Make loop_with(SceneLoopOptions options) const {
    options.subject = plan_.subject;
    return [this, options] { return std::make_unique<SceneLoop>(scene_, plan_.rate, options); };
  }
  void add(const std::string& name, const std::string& what, const TimedPasses& passes) {
    if (passes.passes == 0) { return; }
    add(name, what, passes, passes.costliest(), passes.ticks.size());
  }
  void add(const std::string& name, const std::string& what, const TimedPasses& passes,
           std::size_t tick, std::size_t tried) {
    const TimedTick& worst = passes.ticks[tick];
    budget_.probes.push_back({.name = name,
                              .what = what,
                              .scene_time = static_cast<double>(tick) / plan_.rate,
                              .processor = worst.processor,
                              .wall = worst.wall,
                              .repetitions = passes.passes,
                              .ticks = static_cast<long>(tried)});
  }
  void add_scene() {
    add("first tick", "the first after a start", whole_, 0, 1);
    add("costliest tick", "any tick of the scene", whole_);
    const HappeningNames names(scene_);
    std::map<std::string, std::vector<std::size_t>> ticks;
    for (const Happened& each : whole_.happenings) {
      ticks[names.of(each.happening)].push_back(each.tick);
    }
    for (const auto& [name, all] : ticks) {
      add(name, "as the scene has it", whole_, whole_.costliest(all), all.size());
    }
  }
  void add_beginning(const std::string& name, const std::string& what, const Make& make) {
    add(name, what, time_passes({.make = make, .most_ticks = beginning}, plan_));
  }
  /// Runs with every node awake, which a disturbance could do. No other part that a scene skips can
  /// become necessary in its run.
  void add_awake() {
    if (!(scene_.simulation.sleep_force > 0.0)) { return; }
    Scene awake = scene_;
    awake.simulation.sleep_force = 0.0;
    awake.simulation.threads = 1;  // as while nodes may sleep
    add_beginning("everything awake", "all nodes, without simulation.sleep_force",
                  [&] { return std::make_unique<SceneLoop>(awake, plan_.rate); });
  }
  /// Runs with denormal velocities, as at the end of a decaying motion, of all nodes that are
  /// integrated.
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
    const auto far = plan_steps(scene_, *make_problem(scene_)).far;
    for (int node = 0; node < network.node_count(); ++node) {
      if (network.is_fixed(node) || (far && !far->near.holds(node))) { continue; }
      network.initial_velocity.col(node).setConstant(denormal);
    }
    add_beginning(name, what, loop_with({.network = &network}));
  }
  /// Evicts all caches before the selected ticks.
  void add_cold_caches() {
    std::vector<std::size_t> chosen{0, whole_.costliest()};
    for (const Happened& each : whole_.happenings) { chosen.push_back(each.tick); }
    for (std::size_t n = 1; n < spread; ++n) { chosen.push_back(n * whole_.ticks.size() / spread); }
    std::ranges::sort(chosen);
    chosen.erase(std::ranges::unique(chosen).begin(), chosen.end());
    std::vector<double> other(2 * plan_.cache_bytes / sizeof(double), 1.0);
    const auto walk = [&](std::size_t tick) {
      if (!std::ranges::binary_search(chosen, tick)) { return; }
      for (double& number : other) { number += 1.0; }
    };
    const TimedPasses passes = time_passes({.make = loop_with({}), .before = walk}, plan_);
    if (passes.passes == 0) { return; }
    add("cold caches",
        "a walk through twice the largest cache before first, costliest and eventful ticks", passes,
        passes.costliest(chosen), chosen.size());
  }

  static constexpr std::size_t spread = 16;  ///< further ticks, evenly over the scene
  const Scene& scene_;
  const ProbePlan& plan_;
  TimedPasses whole_{};
  ComputeBudget budget_{};
};

}  // namespace

std::vector<std::string> absent_events(const Scene& scene,
                                       const std::vector<Happened>& happenings) {
  if (!scene.needle && !scene.probe) { return {}; }
  const auto occurs = [&](ToolEvent event) {
    return std::ranges::any_of(happenings,
                               [&](const Happened& each) { return each.happening.event == event; });
  };
  const Drive drive = scene.drive.value_or(Drive{});
  std::vector<std::string> absent;
  if (!occurs(ToolEvent::contact)) { absent.emplace_back("contact"); }
  if (drive.kind != Drive::Kind::trajectory) {
    const double withdrawal =
        drive.kind == Drive::Kind::force ? drive.withdraw_force : drive.withdraw_speed;
    if (withdrawal > 0.0 && !occurs(ToolEvent::withdrawn)) { absent.emplace_back("withdrawal"); }
    return absent;
  }
  if (!drive.depth) { return absent; }
  const double duration = scene.simulation.duration;
  const Trajectory motion(drive, duration);
  const double end = duration * (1.0 + 1e-9);  // times are sums
  const bool arrives = std::ranges::any_of(motion.vertices(), [&](const Trajectory::Vertex& at) {
    return at.place >= *drive.depth && at.time <= end;
  });
  if (!arrives) {
    absent.push_back("end of the advance at " + plain_number(*drive.depth, 6) + " m");
  }
  if (drive.withdraw_speed > 0.0 && (!arrives || motion.vertices().back().time > end)) {
    absent.emplace_back("end of the withdrawal");
  }
  return absent;
}

ComputeBudget run_probes(const Scene& scene, const ProbePlan& plan) {
  return Prober(scene, plan).run();
}

}  // namespace palpate::certificate
