// SPDX-License-Identifier: MIT

#include "reports/live/live_loop.hpp"

#include <chrono>
#include <cmath>

#include "fixtures/io/csv_file.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/trace_file.hpp"
#include "tests/check.hpp"
#include "tests/validation/insertion_scenes.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using namespace palpate::live;

Scene scene_of_live(double duration) {
  Scene scene = hand_scene(duration, 1e-3);
  scene.drive->kind = Drive::Kind::recorded;
  scene.drive->depth = 0.01;
  return scene;
}

struct Rig {
  explicit Rig(double duration, const LiveOptions& options = {})
      : scene(scene_of_live(duration)),
        subject(Simulation(scene)),
        loop(std::make_unique<LiveLoop>(scene, subject, options)) {
    loop->begin(subject);
  }
  Trace run(const SampleOptions& samples = {}) {
    device::VirtualClock time;
    device::DeadlineClock clock(scene.simulation.step, time);
    return roll_out(subject, scene, samples, {.clock = &clock, .hook = loop.get()});
  }
  Scene scene;
  ModelSubject subject;
  std::unique_ptr<LiveLoop> loop;
};

TEST("a grip reaches its target at the speed of the drive, without overshoot") {
  Grip grip;
  grip.place_at(0.0);
  grip.set_speed(0.01);
  grip.drive_to(0.02);
  double fastest = 0.0;
  double furthest = 0.0;
  for (int n = 0; n < 3000; ++n) {
    const ToolInput input = grip.advance(1e-3);
    fastest = std::max(fastest, input.velocity);
    furthest = std::max(furthest, input.position);
  }
  CHECK_NEAR(grip.position(), 0.02, 1e-9);
  CHECK(furthest <= 0.02 + 1e-12);  // rounding: a critically damped spring does not overshoot
  CHECK_NEAR(fastest, 0.01, 1e-4);  // the intent moves in steps of a tick
}

TEST("commands take effect at the border of a tick: a paused run stands still") {
  Rig rig(0.2);
  struct Pause final : TickHook {
    LiveLoop* loop = nullptr;
    long held = 0;
    TickOrder before_tick(Subject& subject) noexcept override {
      if (subject.ticks() == 50 && held == 0) { loop->commands.push({Command::Kind::pause}); }
      if (held == 30) { loop->commands.push({Command::Kind::start}); }
      return loop->before_tick(subject);
    }
    void after_tick(Subject& subject, const certificate::TickTimes& times,
                    bool stepped) noexcept override {
      held += stepped ? 0 : 1;
      loop->after_tick(subject, times, stepped);
    }
  } pause;
  pause.loop = rig.loop.get();
  const Trace trace = roll_out(rig.subject, rig.scene, {}, {.hook = &pause});
  CHECK(pause.held == 30);
  CHECK(trace.ticks == 200);
  CHECK(rig.loop->state().ticks == 200.0);
  CHECK(rig.loop->state().periods == 230.0);
}

TEST("a reset ends the run, and the next one begins at the start with the same bits") {
  Rig rig(0.1, {.drives = true});
  const Trace first = rig.run();
  rig.loop->commands.push({Command::Kind::reset});
  rig.loop->wait_for_reset(rig.subject, false, std::atomic<bool>{false});
  CHECK(rig.loop->wants_reset());
  rig.subject = ModelSubject(Simulation(rig.scene));
  rig.loop->begin(rig.subject);
  const Trace second = rig.run();
  REQUIRE(first.columns.size() == second.columns.size());
  for (std::size_t n = 0; n < first.columns.size(); ++n) {
    CHECK(first.columns[n].values == second.columns[n].values);
  }
  CHECK(rig.loop->state().run == 1.0);
}

TEST("the factor of a material and the speed are limited, and a number that is none is ignored") {
  Rig rig(0.05);
  rig.loop->commands.push({Command::Kind::stiffness, 1e9, 1});
  rig.loop->commands.push({Command::Kind::stiffness, -1.0, 2});
  rig.loop->commands.push({Command::Kind::stiffness, std::nan(""), 3});
  rig.loop->commands.push({Command::Kind::stiffness, 2.0, most_materials});
  rig.loop->commands.push({Command::Kind::speed, 1e9});
  (void)rig.run();
  CHECK(rig.loop->stiffness()[1] == 20.0);
  CHECK(rig.loop->stiffness()[2] == 0.05);
  CHECK(rig.loop->stiffness()[3] == 1.0);
  CHECK(rig.loop->state().speed == 0.25);
}

TEST("snapshots are whole, and one changed number is noticed") {
  Rig rig(0.05, {.drives = true});
  (void)rig.run();
  REQUIRE(rig.loop->snapshots.update());
  Snapshot copy = rig.loop->snapshots.front();
  CHECK(copy.whole());
  copy.position(1, 2) = std::nextafter(copy.position(1, 2), 1.0);
  CHECK(!copy.whole());
  copy = rig.loop->snapshots.front();
  copy.state.missed += 1.0;
  CHECK(!copy.whole());
}

TEST("snapshots read while the loop runs are never torn") {
  Rig rig(2.0, {.drives = true});
  std::atomic<bool> over{false};
  long torn = 0;
  long read = 0;
  std::thread reader([&] {
    while (!over || rig.loop->snapshots.update()) {
      if (!rig.loop->snapshots.update()) { continue; }
      torn += rig.loop->snapshots.front().whole() ? 0 : 1;
      ++read;
    }
  });
  (void)rig.run();
  over = true;
  reader.join();
  CHECK(read > 0);
  CHECK(torn == 0);
}

TEST("a recorded run is replayed to the bit from its file") {
  const io::ScratchFolder scratch;
  Rig rig(0.8, {.drives = true});
  Trace live;
  {
    RowWriter writer(*rig.loop, scratch / "trace.csv");
    live = rig.run();
    CHECK(writer.finish());
    CHECK(writer.rows() == 801);
  }
  CHECK(rig.loop->state().lost_rows == 0.0);
  const Trace rows = io::read_trace(scratch / "trace.csv");
  const Column* position = rows.find("grip.position_m");
  const Column* velocity = rows.find("grip.velocity_m_per_s");
  REQUIRE(position != nullptr);
  REQUIRE(velocity != nullptr);
  std::vector<GripSample> grip;
  for (std::size_t n = 0; n < rows.time.size(); ++n) {
    grip.push_back({rows.time[n], position->values[n], velocity->values[n]});
  }
  Scene scene = rig.scene;
  scene.drive->grip = std::make_shared<const std::vector<GripSample>>(grip);
  ModelSubject again{Simulation(scene)};
  const Trace replayed = roll_out(again, scene);
  const Column* force = live.find("tool.force_n");
  REQUIRE(force != nullptr);
  CHECK(*std::ranges::max_element(force->values) > 0.1);  // the tool touched the tissue
  for (const Column& column : live.columns) {
    CHECK(replayed.find(column.name)->values == column.values);
    CHECK(rows.find(column.name)->values == column.values);
  }
}

/// Hook that moves a slider at a tick and waits at the next borders until the loop has taken it.
struct Slide final : TickHook {
  explicit Slide(LiveLoop& of) : loop(of) {}
  TickOrder before_tick(Subject& subject) noexcept override {
    if (subject.ticks() == 200 || subject.ticks() == 500) {
      const double factor = subject.ticks() == 200 ? 0.4 : 2.0;
      (void)loop.commands.push({Command::Kind::stiffness, factor, 0});
      due = subject.ticks();
    }
    // Time stands still here, so that the builder is ready some ticks later.
    for (int n = 0; subject.ticks() == due + 5 && n < 60000 && loop.offered == nullptr; ++n) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    const TickOrder order = loop.before_tick(subject);
    return order;
  }
  void after_tick(Subject& subject, const certificate::TickTimes& times,
                  bool stepped) noexcept override {
    loop.after_tick(subject, times, stepped);
    if (subject.ticks() == due + 2) { pending = loop.state().changing; }
  }
  LiveLoop& loop;
  long due = -10;
  double pending = -1.0;
};

TEST(
    "a slider changes a material at a tick border, and the scene with the changes has the same "
    "bits") {
  const std::vector<std::string> names{"soft", "firm"};
  Rig rig(0.8, {.drives = true});
  Slide slide(*rig.loop);
  MaterialBuilder builder(*rig.loop, rig.subject, rig.scene, names, rig.loop->stiffness());
  const Trace live = roll_out(rig.subject, rig.scene, {}, {.hook = &slide});
  const std::vector<MaterialChange> changes = builder.finish();
  CHECK(builder.refusal().empty());
  CHECK(slide.pending == 1.0);
  REQUIRE(changes.size() == 2);
  CHECK(changes[0].tick == 205);
  CHECK(changes[0].material == 0);
  const double own = rig.scene.materials[0].youngs_modulus;
  CHECK(changes[0].youngs_modulus == 0.4 * own);
  CHECK(changes[1].tick == 505);
  CHECK(rig.loop->state().changing == 0.0);
  CHECK_NEAR(rig.loop->state().changed, 0.505, 1e-12);

  Scene scene = rig.scene;
  std::vector<GripSample> grip;
  std::vector<double> row(rig.loop->row_names().size());
  while (rig.loop->rows.read_available() >= row.size()) {
    rig.loop->rows.pop(row.data(), row.size());
    grip.push_back({row[0], row[row.size() - 2], row[row.size() - 1]});
  }
  scene.drive->grip = std::make_shared<const std::vector<GripSample>>(grip);
  scene.materials[0].changes = {{0.205, 0.4 * own}, {0.505, 2.0 * own}};
  ModelSubject again;
  again.load(scene, true);
  const Trace replayed = roll_out(again, scene);
  for (const Column& column : live.columns) {
    CHECK(replayed.find(column.name)->values == column.values);
  }
  // The same without changes is another run.
  scene.materials[0].changes.clear();
  again.load(scene, true);
  const Trace unchanged = roll_out(again, scene);
  CHECK(unchanged.find("tool.force_n")->values != live.find("tool.force_n")->values);
}

TEST("a change that the loop did not take before its end is not in the recording") {
  Rig rig(0.05);
  MaterialBuilder builder(*rig.loop, rig.subject, rig.scene, {"soft"}, rig.loop->stiffness());
  (void)rig.run();
  rig.loop->commands.push({Command::Kind::stiffness, 3.0, 0});
  rig.loop->commands.push({Command::Kind::reset});
  rig.loop->wait_for_reset(rig.subject, false, std::atomic<bool>{false});
  CHECK(builder.finish().empty());
  CHECK(rig.loop->offered == nullptr);
  CHECK(rig.loop->stiffness()[0] == 3.0);  // what the reset loads
}

/// Hook under which every tick takes some time of a virtual clock.
struct Slow final : TickHook {
  TickOrder before_tick(Subject& subject) noexcept override {
    time.advance(seconds);
    if (loop->state().too_slow != 0.0) { return {.what = TickOrder::What::end}; }
    return loop->before_tick(subject);
  }
  void after_tick(Subject& subject, const certificate::TickTimes& times,
                  bool stepped) noexcept override {
    latest = std::max(latest, times.end - times.due);
    loop->after_tick(subject, times, stepped);
  }
  LiveLoop* loop = nullptr;
  double seconds = 0.0;
  double latest = 0.0;  ///< [s]
  device::VirtualClock time{};
};

TEST(
    "a scene that cannot keep its period runs in slow motion, and is never later than a quarter "
    "second") {
  for (const double seconds : {0.0004, 0.0025}) {
    Rig rig(4.0);
    Slow slow;
    slow.loop = rig.loop.get();
    slow.seconds = seconds;
    device::DeadlineClock clock(1e-3, slow.time);
    rig.loop->begin(rig.subject, &clock);
    const Trace trace = roll_out(rig.subject, rig.scene, {}, {.clock = &clock, .hook = &slow});
    CHECK(trace.ticks == 4000);
    const LiveState& state = rig.loop->state();
    if (seconds < 1e-3) {
      CHECK(state.left_out == 0.0);
      CHECK_NEAR(state.pace, 1.0, 1e-2);
      continue;
    }
    CHECK(slow.latest <= LiveLoop::most_late + 2.0 * seconds);
    CHECK_NEAR(state.pace, 0.4, 1e-2);                           // 1 ms in 2.5 ms
    CHECK_NEAR(state.left_out, 6.0, 2.0 * LiveLoop::most_late);  // of 10 s for 4 s
    CHECK(state.running == 1.0);
  }
}

/// Line of a device that never answers.
class SilentLine final : public device::ByteLink {
 public:
  [[nodiscard]] double now() const noexcept override { return device::monotonic_now(); }
  std::size_t read(std::span<std::uint8_t> /*into*/) noexcept override { return 0; }
  bool wait_until(double deadline_s) noexcept override {
    device::monotonic_clock().sleep_until(deadline_s);
    return false;
  }
  bool write(std::span<const std::uint8_t> /*bytes*/) noexcept override { return true; }
};

TEST("a scene that cannot keep its period is paused without force if a device holds the tool") {
  SilentLine line;
  device::falcon::GripThread grip(line, {});
  Rig rig(8.0, {.device = &grip});
  Slow slow;
  slow.loop = rig.loop.get();
  slow.seconds = 0.0025;
  device::DeadlineClock clock(1e-3, slow.time);
  rig.loop->begin(rig.subject, &clock);
  const Trace trace = roll_out(rig.subject, rig.scene, {}, {.clock = &clock, .hook = &slow});
  CHECK_NEAR(static_cast<double>(trace.ticks), 800.0, 10.0);  // two seconds of 2.5 ms
  CHECK(rig.loop->state().running == 0.0);
  CHECK(rig.loop->state().device_force == 0.0);
  rig.loop->commands.push({Command::Kind::start});
  (void)rig.loop->before_tick(rig.subject);
  CHECK(rig.loop->state().too_slow == 0.0);
  CHECK(rig.loop->state().running == 1.0);
}

TEST("rows that the writer does not take are counted, and the loop goes on") {
  Rig rig(30.0);
  const Trace trace = rig.run({.every = 30000});
  CHECK(trace.ticks == 30000);
  CHECK(rig.loop->state().lost_rows > 0.0);
  const double kept =
      static_cast<double>(rig.loop->rows.read_available() / rig.loop->row_names().size());
  CHECK(rig.loop->state().lost_rows + kept == 30001.0);
}

}  // namespace PALPATE_FILE
