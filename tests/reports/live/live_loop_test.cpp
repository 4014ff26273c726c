// SPDX-License-Identifier: MIT

#include "reports/live/live_loop.hpp"

#include <cmath>

#include "fixtures/io/csv_file.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/trace_file.hpp"
#include "tests/check.hpp"
#include "tests/validation/insertion_scenes.hpp"

namespace {

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

TEST("rows that the writer does not take are counted, and the loop goes on") {
  Rig rig(30.0);
  const Trace trace = rig.run({.every = 30000});
  CHECK(trace.ticks == 30000);
  CHECK(rig.loop->state().lost_rows > 0.0);
  const double kept =
      static_cast<double>(rig.loop->rows.read_available() / rig.loop->row_names().size());
  CHECK(rig.loop->state().lost_rows + kept == 30001.0);
}

}  // namespace
