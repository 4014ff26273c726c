// SPDX-License-Identifier: MIT

#include "validation/certificate/scene_loop.hpp"

#include <random>
#include <thread>

#include "tests/check.hpp"
#include "tests/validation/insertion_scenes.hpp"
#include "validation/certificate/certificate.hpp"
#include "validation/certificate/paced_loop.hpp"
#include "validation/certificate/worst_case_probe.hpp"
#include "validation/roll_out.hpp"

namespace PALPATE_FILE {

using namespace palpate::certificate;
using namespace palpate;

TEST("a loop has the state of a run after the same ticks, and the same events") {
  const Scene scene = insertion_scene(0.4, 1e-3, 0.04);
  ModelSubject subject{Simulation(scene)};
  const Trace run = roll_out(subject, scene);
  SceneLoop loop(scene, 1000.0);
  std::size_t events = 0;
  while (!loop.over()) {
    CHECK(loop.tick() == StepStatus::ok);
    events += loop.happenings().size();
  }
  Eigen::VectorXd a(subject.dof()), b(a.size());
  subject.coordinates(a);
  loop.subject().coordinates(b);
  CHECK(a == b);
  CHECK(events == run.events.size());
  CHECK(events >= 2);
}

TEST("a hand on a slower tissue has device ticks in between, and the same end as a run") {
  for (const double step : {1e-3, 4e-3}) {
    const Scene scene = hand_scene(0.2, step);
    ModelSubject subject{Simulation(scene)};
    FalconFacts facts;
    (void)roll_out(subject, scene, {}, {.falcon = &facts});
    SceneLoop loop(scene, 1000.0);
    CHECK(loop.tick_count() == 200);
    long ticks = 0;
    for (; !loop.over(); ++ticks) { (void)loop.tick(); }
    CHECK(ticks == 200);
    CHECK(loop.falcon()->facts().ticks == facts.ticks);
    CHECK_NEAR(loop.falcon()->facts().least_energy, facts.least_energy, 0.0);
    CHECK_NEAR(loop.subject().tool_motion().place, subject.tool_motion().place, 0.0);
  }
}

TEST("without a device nothing is computed between two steps") {
  SceneLoop loop(insertion_scene(0.4, 1e-3, 0.04), 5000.0);
  for (int n = 0; n < 10; ++n) { (void)loop.tick(); }
  CHECK(loop.subject().ticks() == 2);
  CHECK(loop.tick_count() == 2000);
}

TEST("a syringe sends 120 frames a second, and the reader finds all that are not damaged") {
  Scene scene = insertion_scene(0.4, 1e-3, 0.04);
  scene.syringe = Syringe{};
  for (const bool faults : {false, true}) {
    SceneLoop loop(scene, 1000.0, {.faults = faults});
    while (!loop.over()) { (void)loop.tick(); }
    const auto counts = loop.frames();
    CHECK(counts.frames == (faults ? 25 : 49));  // at 0, 1/120, ... 48/120 s, or every other one
    if (faults) { CHECK(counts.bad_frames >= 23); }
    if (!faults) { CHECK(counts.bad_frames == 0); }
  }
}

TEST("a step is a whole number of periods, a haptic loop keeps its rate, events have layer names") {
  const Scene scene = insertion_scene(0.4, 1e-3, 0.04);
  CHECK(why_not_at(scene, 1000.0).empty());
  CHECK(why_not_at(scene, 3000.0).empty());
  CHECK_CONTAINS(why_not_at(scene, 500.0), "a rate of 1000 Hz or a whole multiple");
  CHECK(!why_not_at(scene, 1500.0).empty());
  CHECK_CONTAINS(why_not_at(hand_scene(0.2, 1e-3), 2000.0), "falcon.rate");
  CHECK_NEAR(rate_of(scene), 1000.0, 1e-9);
  CHECK_NEAR(rate_of(hand_scene(0.2, 4e-3)), 1000.0, 0.0);
  const HappeningNames names(scene);
  CHECK(names.of({.event = ToolEvent::puncture, .interval = 0}) == "puncture: skin");
}

const WorstCaseProbe* named(const ComputeBudget& budget, std::string_view name) {
  const auto found = std::ranges::find(budget.probes, name, &WorstCaseProbe::name);
  return found == budget.probes.end() ? nullptr : &*found;
}

TEST("every event of a scene, its first tick and all special ones have a probe, costliest first") {
  const ComputeBudget budget =
      run_probes(syringe_scene(), {.cache_bytes = 1U << 20U, .enough = 0.0});
  for (const char* name : {"first tick", "costliest tick", "contact: skin", "puncture: skin",
                           "puncture: ligament", "loss-of-resistance: epidural space",
                           "denormal numbers", "cold caches", "faults on the lines"}) {
    const WorstCaseProbe* found = named(budget, name);
    if (found == nullptr) { std::printf("  missing: %s\n", name); }
    REQUIRE(found != nullptr);
    CHECK(found->processor > 0.0);
    CHECK(found->repetitions >= 3);
  }
  CHECK(std::ranges::is_sorted(budget.probes, std::ranges::greater{}, &WorstCaseProbe::processor));
  CHECK(!budget.worst_instructions);
  CHECK(!budget.diverged_at);
  CHECK_NEAR(budget.largest_speed, 0.05, 1e-9);
}

TEST("nodes that sleep are awake in one probe, and a scene where none sleeps has no such probe") {
  Scene scene = insertion_scene(0.05);
  const auto probe = [&] {
    const ComputeBudget budget =
        run_probes(scene, {.cache_bytes = 1U << 20U, .most_repetitions = 1, .enough = 0.0});
    const WorstCaseProbe* found = named(budget, "everything awake");
    return found != nullptr && found->processor > 0.0;
  };
  CHECK(!probe());
  scene.simulation.sleep_force = 1e-3;
  CHECK(probe());
}

TEST(
    "events of the whole scene are kept, and those that it declares and does not reach are named") {
  using Names = std::vector<std::string>;
  const auto absent = [](const Scene& scene) {
    const ComputeBudget budget =
        run_probes(scene, {.cache_bytes = 1U << 20U, .most_repetitions = 1, .enough = 0.0});
    const bool touches = std::ranges::find(budget.absent, "contact") == budget.absent.end();
    CHECK(budget.happenings.empty() != touches);
    return budget.absent;
  };
  Scene scene = insertion_scene(0.05);  // 20 mm/s, without an end
  CHECK(absent(scene) == Names{});
  Scene away = scene;
  away.drive->from = -0.01;  // 1 mm of 10 mm
  CHECK(absent(away) == Names{"contact"});
  scene.drive->depth = 0.001;
  CHECK(absent(scene) == Names{});
  scene.drive->depth = 0.002;
  CHECK(absent(scene) == Names{"end of the advance at 0.002 m"});
  scene.drive->withdraw_speed = 0.1;
  CHECK(absent(scene) == (Names{"end of the advance at 0.002 m", "end of the withdrawal"}));
  scene.drive->depth = 0.0005;
  scene.drive->hold = 0.03;  // at 0.025 s; back after 0.06 s
  CHECK(absent(scene) == Names{"end of the withdrawal"});
  scene.drive->hold = 0.01;
  CHECK(absent(scene) == Names{});
  // A hand decides itself how far it comes; its withdrawal must be seen.
  Scene hand = hand_scene(0.05, 1e-3);
  hand.drive->depth = 0.05;
  CHECK(absent(hand) == Names{});
  hand.drive->withdraw_speed = 0.1;
  CHECK(absent(hand) == Names{"withdrawal"});
  Scene oscillator;
  oscillator.tissue.source = Source::oscillator;
  CHECK(absent_events(oscillator, {}).empty());
}

TEST("the costliest tick is found among all and among a few") {
  const Scene scene = syringe_scene();
  const TimedPasses passes = time_passes(
      {.make = [&] { return std::make_unique<SceneLoop>(scene, 1000.0); }, .most_ticks = 20},
      {.most_repetitions = 5});
  CHECK(passes.passes >= 3);
  CHECK(passes.ticks.size() == 20);
  for (const TimedTick& tick : passes.ticks) {
    CHECK(tick.processor > 0.0);
    CHECK(tick.wall > 0.0);
  }
  TimedPasses changed = passes;
  changed.ticks[7].processor = 1.0;
  CHECK(changed.costliest() == 7);
  CHECK(changed.costliest({3, 7, 9}) == 7);
  CHECK(changed.costliest({3, 9}) != 7);
}

TEST("the time of a divergence is reported; after it, and after Ctrl-C, there is no probe") {
  Scene scene = syringe_scene();
  scene.simulation = {.duration = 20.0, .step = 0.02, .substeps = 1, .integrator = "euler-cromer"};
  const ComputeBudget budget = run_probes(scene, {.rate = 50.0, .enough = 0.0});
  CHECK(budget.diverged_at.has_value());
  CHECK(budget.probes.empty());
  const std::atomic<bool> stop{true};
  CHECK(run_probes(syringe_scene(), {.stop = &stop}).probes.empty());
}

TEST("the ticks of an oscillator have probes too") {
  Scene scene;
  scene.tissue.source = Source::oscillator;
  scene.simulation = {.duration = 1.0, .step = 1e-2};
  const ComputeBudget budget =
      run_probes(scene, {.rate = 100.0, .cache_bytes = 1U << 20U, .enough = 0.0});
  CHECK(named(budget, "denormal numbers") != nullptr);
  CHECK(named(budget, "first tick") != nullptr);
}

/// Hand that presses a needle against layers without puncturing them.
Scene pressing(double coupling) {
  Scene scene = hand_scene(0.3, 1e-3);
  for (Material& each : scene.materials) { each.cutting_force = 50.0; }
  scene.drive->depth = 0.004;
  scene.falcon = FalconDrive{.coupling_stiffness = coupling, .quantised = false, .friction = false};
  return scene;
}

TEST("the bound of a missed tick is half of K (v T)^2, and a smooth motion stays within it") {
  const MissedTick half = bounded_missed_tick(2000.0, 0.1, 1e-3);
  CHECK_NEAR(half.bound, 1e-5, 1e-20);  // (1e-4 m)^2 of 2000 N/m, halved
  CHECK_NEAR(half.sampled_bound, 2e-5, 1e-20);
  const MissedTick missed = measure_missed_tick(pressing(2000.0), nullptr);
  REQUIRE(missed.measured.has_value());
  CHECK(*missed.measured > 0.0);
  CHECK(*missed.measured <= missed.sampled_bound);
  CHECK_NEAR(missed.stiffness, 2000.0, 0.0);
  CHECK(missed.speed > 0.01);
  CHECK_NEAR(missed.bound, 0.5 * 2000.0 * std::pow(1e-3 * missed.speed, 2), 1e-15);
  CHECK(measure_missed_tick(pressing(2000.0), nullptr).measured == missed.measured);
}

LatencyHistogram histogram_of(int count, double first, double step) {
  LatencyHistogram histogram;
  for (int n = 0; n < count; ++n) { histogram.add(first + step * n); }
  return histogram;
}

TEST("a percentile is the end of the bin of its ordered sample") {
  const LatencyHistogram histogram = histogram_of(1000, 0.5e-6, 1e-6);  // one in each of 1000 bins
  CHECK_NEAR(*histogram.percentile(0.5), 500e-6, 1e-15);  // the 500th value, in [499, 500) us
  CHECK_NEAR(*histogram.percentile(0.99), 990e-6, 1e-15);
  CHECK_NEAR(*histogram.percentile(0.999), 999e-6, 1e-15);
  CHECK_NEAR(histogram.minimum(), 0.5e-6, 1e-20);
  CHECK_NEAR(histogram.maximum(), 999.5e-6, 1e-18);
  CHECK(histogram.used_bins() == 1000);
}

TEST("a percentile exists if a sample lies above it, and is never beyond the maximum") {
  const LatencyHistogram equal = histogram_of(1000, 100.2e-6, 0.0);
  CHECK(equal.percentile(0.999).has_value());
  CHECK(!equal.percentile(0.9999).has_value());
  CHECK(!LatencyHistogram().percentile(0.5).has_value());
  CHECK_NEAR(*equal.percentile(0.5), 100.2e-6, 1e-15);
  const LatencyHistogram beyond = histogram_of(10, 0.2, 0.1);  // beyond all bins
  CHECK(beyond.counts().back() == 10);
  CHECK_NEAR(*beyond.percentile(0.5), 1.1, 1e-12);
  // NaN is counted as the longest latency, and a negative one, of a clock read twice, as shortest.
  LatencyHistogram unusual;
  unusual.add(std::nan(""));
  unusual.add(-1e-9);
  CHECK(unusual.counts().back() == 1);
  CHECK(unusual.counts().front() == 1);
  CHECK(unusual.count() == 2);
}

TEST("a response is wake-up and computation; the longest is kept with its scene time and event") {
  LoopRecord record(1e-3);
  record.add({.due = 5.0, .begin = 5.0002, .end = 5.0005},
             {.scene_time = 1.5, .happening = ToolHappening{.event = ToolEvent::puncture}});
  record.add({.due = 6.0, .begin = 6.0, .end = 6.0001}, {});
  CHECK_NEAR(record.worst_wakeup.seconds, 2e-4, 1e-12);
  CHECK_NEAR(record.worst_compute.seconds, 3e-4, 1e-12);
  CHECK_NEAR(record.worst_response.seconds, 5e-4, 1e-12);
  CHECK_NEAR(record.worst_response.moment.scene_time, 1.5, 0.0);
  REQUIRE(record.worst_compute.moment.happening.has_value());
  CHECK(record.worst_compute.moment.happening->event == ToolEvent::puncture);
  CHECK(record.misses.count() == 0);
  record.add({.due = 0.0, .begin = 0.0, .end = 1e-3}, {});  // exactly the deadline
  CHECK(record.misses.count() == 0);
  record.add({.due = 0.0, .begin = 0.0, .end = std::nan("")}, {});
  CHECK(record.misses.count() == 1);
}

TEST("the largest ticks are kept, whatever their order") {
  std::vector<LargeTick> all;
  for (long n = 0; n < 5000; ++n) { all.push_back({1e-6 * static_cast<double>(n), n}); }
  std::ranges::shuffle(all, std::mt19937(3));
  LargestTicks largest(100);
  for (const LargeTick& each : all) { largest.add(each); }
  const std::vector<LargeTick> kept = largest.sorted();
  REQUIRE(kept.size() == 100);
  for (long n = 0; n < 100; ++n) { CHECK(kept[static_cast<std::size_t>(n)].tick == 4999 - n); }
}

TEST("every load but idle works until it is destroyed, and other names are no loads") {
  const std::vector<int> processors = device::allowed_processors();
  for (const char* name : {"cpu", "cache", "memory"}) {
    BackgroundLoad load(name, {processors.back()}, 1U << 20U);
    while (load.rounds() < 2) { std::this_thread::yield(); }  // CTest ends a load that never works
    CHECK(load.threads() == 1);
    CHECK(load.rounds() >= 2);
  }
  CHECK(BackgroundLoad("idle", processors, 1U << 20U).threads() == 0);
  CHECK(is_own_load("idle"));
  CHECK(is_own_load("memory"));
  CHECK(!is_own_load("gpu"));
  CHECK(!is_own_load(""));
}

/// Loop in virtual time.
struct Paced {
  explicit Paced(double period) : record(period), loop{.period = period, .clock = &time} {}
  template <class Work> LoopEnd run(long ticks, Work work) { return loop.run(ticks, record, work); }

  device::VirtualClock time{};
  LoopRecord record;
  PacedLoop loop;
};

TEST("every release is served once, in order, and at its time, not before it on the real clock") {
  Paced paced(0.25);
  long calls = 0;
  CHECK(paced.run(50, [&](Moment&) { return ++calls > 0; }) == LoopEnd::done);
  CHECK(calls == 50);
  CHECK(paced.record.ticks() == 50);
  CHECK(paced.time.now() == 49 * 0.25);
  CHECK(paced.record.wakeup.minimum() == 0.0);
  CHECK(paced.record.wakeup.maximum() == 0.0);
  PacedLoop real{.period = 2e-3};
  LoopRecord record(2e-3);
  real.run(10, record, [](Moment&) { return true; });
  CHECK(record.wakeup.minimum() >= 0.0);
}

TEST("one long tick also delays the following ticks, and all of them are late") {
  Paced paced(0.25);
  paced.run(20, [&](Moment&) {
    if (paced.record.ticks() == 5) { paced.time.advance(0.875); }
    return true;
  });
  const LoopRecord& record = paced.record;
  CHECK(record.misses.count() == 3);  // answers after 0.875, 0.625 and 0.375 s; then 0.125 s
  CHECK(record.misses.longest_run() == 3);
  CHECK(record.misses.longest_recovery() == 0.875);  // until a tick was done in time
  CHECK(record.worst_compute.tick == 5);
  CHECK(record.worst_response.tick == 5);
  CHECK(record.worst_wakeup.tick == 6);
  CHECK(record.worst_wakeup.seconds == 0.625);
}

TEST("the last work and Ctrl-C end the loop after their tick") {
  Paced paced(1e-3);
  CHECK(paced.run(100, [&](Moment&) { return paced.record.ticks() < 6; }) == LoopEnd::over);
  CHECK(paced.record.ticks() == 7);
  std::atomic<bool> stop{false};
  paced.loop.stop = &stop;
  CHECK(paced.run(100, [&](Moment&) {
    stop = paced.record.ticks() == 9;
    return true;
  }) == LoopEnd::stopped);
  CHECK(paced.record.ticks() == 10);
}

TEST("a loop that is two seconds late ends as hopeless") {
  Paced paced(0.125);
  CHECK(paced.run(1000, [&](Moment&) {
    paced.time.advance(0.625);
    return true;
  }) == LoopEnd::hopeless);
  CHECK(paced.record.ticks() == 4);  // each half a second later than the last; the limit is 2 s
}

}  // namespace PALPATE_FILE
