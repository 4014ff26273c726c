// SPDX-License-Identifier: MIT
// Test that the loop of `palpate live` neither allocates, locks nor makes a system call between its
// first and its last tick, with a viewer and an operator at its ends.

#include "reports/live/live_loop.hpp"
#include "tests/allocation_count.hpp"
#include "tests/check.hpp"
#include "tests/system_call_filter.hpp"
#include "tests/validation/insertion_scenes.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using namespace palpate::live;

Scene live_scene() {
  Scene scene = syringe_scene(1e-3);
  scene.drive->kind = Drive::Kind::recorded;
  scene.drive->depth = 0.02;
  scene.simulation.duration = 0.3;
  return scene;
}

/// Counts what happens between the first and the last call of a hook, and operates it.
class Counting final : public TickHook {
 public:
  Counting(LiveLoop& loop, bool allocating) : loop_(loop), allocating_(allocating) {}

  TickOrder before_tick(Subject& subject) noexcept override {
    if (periods_++ == 0) {
      allocations_ = check::allocations;
      locks_ = check::locks;
    }
    if (periods_ == 150) { loop_.offered = next; }
    (void)loop_.commands.push({.kind = Command::Kind::hold, .value = 1e-4 * double(periods_)});
    return loop_.before_tick(subject);
  }
  void after_tick(Subject& subject, const certificate::TickTimes& times,
                  bool stepped) noexcept override {
    loop_.after_tick(subject, times, stepped);
    if (loop_.snapshots.update()) { whole_ = whole_ && loop_.snapshots.front().whole(); }
    double* volatile leak = allocating_ && periods_ == 7 ? new double(1.0) : nullptr;
    delete leak;
    allocations = check::allocations - allocations_;
    locks = check::locks - locks_;
  }
  [[nodiscard]] bool whole() const { return whole_; }

  NextSimulation* next = nullptr;  ///< offered in the middle of the run
  long allocations = -1;
  long locks = -1;

 private:
  LiveLoop& loop_;
  bool allocating_;
  bool whole_ = true;
  long periods_ = 0;
  long allocations_ = 0;
  long locks_ = 0;
};

struct Found {
  long allocations = 0, locks = 0, ticks = 0, changed = 0;
  bool whole = false;
};

Found run(bool allocating) {
  const Scene scene = live_scene();
  ModelSubject subject{Simulation(scene)};
  const auto loop = std::make_unique<LiveLoop>(scene, subject, LiveOptions{});
  loop->begin(subject);
  Counting hook(*loop, allocating);
  Scene firmer = scene;
  for (Material& material : firmer.materials) { material.youngs_modulus *= 2.0; }
  NextSimulation next{.simulation = Simulation(firmer)};
  next.simulation.prepare_to_continue(subject.simulation());
  hook.next = &next;
  device::VirtualClock time;
  device::DeadlineClock clock(scene.simulation.step, time);
  const Trace trace =
      roll_out(subject, scene, {.every = subject.tick_count()}, {.clock = &clock, .hook = &hook});
  return {hook.allocations, hook.locks, trace.ticks, next.tick, hook.whole()};
}

TEST(
    "a live loop with viewer, operator, recording and a change of materials neither allocates nor "
    "locks") {
  const Found found = run(false);
  CHECK(found.ticks == 300);
  CHECK(found.changed == 149);
  CHECK(found.allocations == 0);
  CHECK(found.locks == 0);
  CHECK(found.whole);
}

TEST("one allocation in one tick of a live loop is counted") { CHECK(run(true).allocations == 1); }

struct Prepared {
  Scene scene = live_scene();
  ModelSubject subject{Simulation(scene)};
  std::unique_ptr<LiveLoop> loop = std::make_unique<LiveLoop>(scene, subject, LiveOptions{});
  NextSimulation next{.simulation = Simulation(scene)};
};

TEST("the hook of a live loop makes no system call") {
  const auto prepare = [] {
    auto made = std::make_unique<Prepared>();
    made->loop->begin(made->subject);
    made->next.simulation.prepare_to_continue(made->subject.simulation());
    return made;
  };
  const auto ticks = [](const std::unique_ptr<Prepared>& made) {
    bool good = true;
    for (int n = 0; n < 300; ++n) {
      (void)made->loop->commands.push({.kind = Command::Kind::hold, .value = 1e-4 * n});
      if (n == 150) { made->loop->offered = &made->next; }
      const TickOrder order = made->loop->before_tick(made->subject);
      good = made->subject.step(order.input) == StepStatus::ok && good;
      made->loop->after_tick(made->subject, {}, true);
    }
    return good;
  };
  const check::Verdict verdict = check::without_system_calls(prepare, ticks);
  if (verdict == check::Verdict::refused) { check::skip("this system refuses seccomp filters"); }
  CHECK(verdict == check::Verdict::silent);
}

}  // namespace PALPATE_FILE
