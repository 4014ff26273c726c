// SPDX-License-Identifier: MIT

#include "validation/roll_out.hpp"

#include <cmath>

#include "device/falcon/emulator.hpp"
#include "model/problem/input_error.hpp"
#include "model/tissue/network_builder.hpp"
#include "tests/check.hpp"
#include "tests/validation/insertion_scenes.hpp"
#include "validation/claims/tool_fixture.hpp"
#include "validation/subject/falcon_loop.hpp"
#include "validation/subject/grip_replay.hpp"

namespace PALPATE_FILE {

using namespace palpate;

Trace run_of(const Scene& scene, int keyframes) {
  ModelSubject subject{Simulation(scene)};
  return roll_out(subject, scene, {.keyframes = keyframes});
}

TEST("node positions are kept at ticks with events and at the largest force, in order of time") {
  const Trace run = run_of(insertion_scene(0.6), 20);
  const auto& force = run.find("tool.force_n")->values;
  const auto most = static_cast<std::size_t>(std::ranges::max_element(force) - force.begin());
  const auto& event = run.text_columns[1].values;
  std::vector<double> expected;
  for (std::size_t row = 0; row < event.size(); ++row) {
    if (!event[row].empty() || row == most) { expected.push_back(run.time[row]); }
  }
  CHECK(expected.size() >= 3);
  CHECK(run.keyframes.time == expected);
  Simulation again(insertion_scene(0.6));
  std::size_t found = 0;
  while (again.ticks() < again.tick_count()) {
    again.tick();
    const auto at = std::ranges::find(run.keyframes.time, again.time());
    if (at == run.keyframes.time.end()) { continue; }
    ++found;
    CHECK(run.keyframes.position[static_cast<std::size_t>(at - run.keyframes.time.begin())] ==
          again.node_positions());
  }
  CHECK(found + (run.keyframes.time.front() == 0.0 ? 1 : 0) == run.keyframes.time.size());
}

TEST("a network whose nodes are numbered in another order has the same forces") {
  Scene scene;
  scene.tissue.lattice = {.nodes = {4, 4, 4}, .spacing = 0.01, .material = "gel"};
  scene.materials = {{.name = "gel", .youngs_modulus = 1e4, .poissons_ratio = 0.45}};
  scene.tissue.fixed = std::vector<Face>{};
  const SpringNetwork given = build_network(scene);
  const NetworkProblem first(given);
  SpringNetwork network = given;
  const std::vector<int> node_of = renumber(network, scene, 5);
  const NetworkProblem other(network);
  Eigen::VectorXd q = first.initial_position();
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    q(i) += 1e-3 * std::cos(7.0 * static_cast<double>(i));
  }
  Eigen::VectorXd there(q.size());
  for (int n = 0; n < 64; ++n) {
    there.segment<3>(3 * node_of[static_cast<std::size_t>(n)]) = q.segment<3>(3 * n);
  }
  Eigen::VectorXd f(q.size());
  Eigen::VectorXd g(q.size());
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(q.size());
  first.force(0.0, 0.0, q, still, f);
  other.force(0.0, 0.0, there, still, g);
  for (int n = 0; n < 64; ++n) {
    CHECK_NEAR(g.segment<3>(3 * node_of[static_cast<std::size_t>(n)]), f.segment<3>(3 * n),
               1e-12 * f.cwiseAbs().maxCoeff());
  }
}

TEST("no more events are kept than requested, and none without a tool") {
  CHECK(run_of(insertion_scene(0.6), 1).keyframes.time.size() == 2);
  CHECK(run_of(insertion_scene(0.6), 0).keyframes.time.empty());
  Scene bare = insertion_scene(0.6);
  bare.needle.reset();
  bare.drive.reset();
  CHECK(run_of(bare, 5).keyframes.time.empty());
}

Scene held_scene() {
  Scene scene = tools::seven_soft_layers(0.006, 4);
  scene.drive = Drive{.kind = Drive::Kind::falcon, .from = -0.002, .speed = 0.03};
  scene.falcon = FalconDrive{.hand = FalconDrive::Hand::firm, .seed = 5};
  scene.simulation = {.duration = 1.2, .step = 1e-3};
  return scene;
}

struct Held {
  Trace run{};
  FalconFacts facts{};
};

Held hold(const Scene& scene, const FalconLoopOptions& options = {}) {
  ModelSubject subject{Simulation(scene)};
  Held held;
  held.run = roll_out(subject, scene, {}, {.device = options, .falcon = &held.facts});
  return held;
}

TEST("the tool follows the hand through the layers, and their force acts on the hand") {
  const Held held = hold(held_scene());
  CHECK(!held.run.diverged);
  CHECK(held.facts.lost_resistance_at.has_value());
  CHECK(held.facts.ticks == 1200);
  CHECK(held.facts.unanswered == 0);
  CHECK(held.facts.largest_requested > 1.0);
  // The motors lag by half a millisecond and words are integers: the force does not exceed the
  // command by more than two words per motor, 0.0026 N each, in the weakest direction.
  CHECK(held.facts.largest_delivered <= held.facts.largest_requested + 0.02);
}

void check_equal(const Trace& first, const Trace& second) {
  REQUIRE(first.columns.size() == second.columns.size());
  for (std::size_t n = 0; n < first.columns.size(); ++n) {
    CHECK(first.columns[n].values == second.columns[n].values);
  }
}

TEST("two runs are the same to the bit") {
  Scene scene = held_scene();
  scene.simulation.duration = 0.5;  // some layers deep
  check_equal(hold(scene).run, hold(scene).run);
}

TEST("a recorded grip is exact at its rows, linear between them, and rests before and after") {
  Scene scene;
  scene.simulation.step = 1e-3;
  scene.drive = Drive{.kind = Drive::Kind::recorded};
  scene.drive->grip = std::make_shared<const std::vector<GripSample>>(
      std::vector<GripSample>{{0.001, 1.0, 10.0}, {0.002, 2.0, 20.0}, {0.006, 6.0, -4.0}});
  GripReplay replay(scene);
  CHECK(replay.at(0.0005)->position == 1.0);
  CHECK(replay.at(0.0005)->velocity == 0.0);
  CHECK(replay.at(0.001)->position == 1.0);
  CHECK(replay.at(0.001)->velocity == 10.0);
  CHECK(replay.at(2e-3 * (1.0 + 1e-15))->velocity == 20.0);
  // Rounding of one interpolation of numbers up to 20.
  CHECK_NEAR(replay.at(0.005)->position, 5.0, 1e-13);
  CHECK_NEAR(replay.at(0.005)->velocity, 2.0, 1e-13);
  CHECK(replay.at(0.006)->velocity == -4.0);
  CHECK(replay.at(0.007)->position == 6.0);
  CHECK(replay.at(0.007)->velocity == 0.0);
  CHECK(!GripReplay(Scene{}).at(0.0).has_value());
}

/// First tick at which a column exceeds a force [N].
std::ptrdiff_t first_force(const Trace& run, const char* column, double above) {
  const std::vector<double>& force = run.find(column)->values;
  const auto found = std::ranges::find_if(force, [above](double f) { return f > above; });
  REQUIRE(found != force.end());
  return found - force.begin();
}

TEST("one tick of delay more shows in the force on the hand") {
  Scene scene = held_scene();
  scene.falcon->quantised = false;
  scene.simulation.duration = 0.3;
  const auto first = [&](int extra) {
    return first_force(hold(scene, {.extra_delay = extra}).run, "device.requested_n", 0.0);
  };
  CHECK(first(1) == first(0) + 1);
  CHECK(first(3) == first(0) + 3);
}

TEST("a quicker hand overshoots less, and a tissue slower than the loop has ticks in between") {
  Scene scene = held_scene();
  scene.falcon->reaction_delay = 0.0;
  const double quick = hold(scene).facts.overshoot;
  scene.falcon->reaction_delay = 0.15;
  // The intent continues at 30 mm/s for 0.15 s; deeper layers may absorb part of it.
  CHECK(hold(scene).facts.overshoot > quick + 0.5 * 0.03 * 0.15);
  scene = held_scene();
  scene.falcon->rate = 2000.0;
  scene.simulation.duration = 0.5;
  CHECK(hold(scene).facts.ticks == 1000);
  scene.falcon->between = FalconDrive::Between::extrapolate;
  CHECK(!hold(scene).run.diverged);
}

TEST("a clock changes when a tick is computed and nothing else") {
  Scene scene = held_scene();
  scene.simulation.duration = 0.2;
  ModelSubject subject{Simulation(scene)};
  device::VirtualClock time;
  device::DeadlineClock clock(1.0 / scene.falcon->rate, time);
  const Trace paced = roll_out(subject, scene, {}, {.clock = &clock});
  CHECK(clock.facts().ticks == 200);
  CHECK_NEAR(time.now(), 0.199, 1e-15);  // tick 199 is due then
  check_equal(paced, hold(scene).run);
}

TEST("a hand of a given stiffness keeps mass and damping ratio of its preset") {
  Scene scene = held_scene();
  scene.falcon->hand_stiffness = 4000.0;
  const device::HandImpedance hand = hand_of(scene).impedance;
  CHECK_NEAR(hand.stiffness, 4000.0, 0.0);
  CHECK_NEAR(hand.viscosity, 2.0 * device::firm_hand.viscosity, 1e-12);
  CHECK_NEAR(hand.mass, device::firm_hand.mass, 0.0);
}

TEST("packets of a run that are replayed to another device have the same replies to the bit") {
  Scene scene = held_scene();
  scene.simulation.duration = 0.5;  // resistance is not lost yet: the hand gets no signal
  device::falcon::WireRecording recording(4000);
  const Held held = hold(scene, {.observer = &recording});
  CHECK(!held.facts.lost_resistance_at);
  CHECK(recording.records().size() == 2000);  // two exchanges a tick
  device::falcon::PlantBody body(falcon_options(scene).body, hand_of(scene));
  device::falcon::Emulator emulator(body, {.loaded = true});
  const device::falcon::ReplayResult again = device::falcon::replay(recording, emulator);
  CHECK(again.requests == 1000);
  CHECK(again.different_replies == 0);
}

TEST("faults on the line are counted and act on the force in the loop") {
  Scene scene = held_scene();
  const auto faulty = [&](device::falcon::LinkFault fault) {
    return hold(scene, {.faults = {.seed = 3, .faults = {fault}}});
  };
  using Kind = device::falcon::LinkFault::Kind;
  const Held sound = hold(scene);
  // 16 bytes arrive with probability 0.99^16 in each direction: 72.5 % of exchanges have a reply.
  const Held lossy = faulty({.kind = Kind::drop, .probability = 0.01});
  CHECK(lossy.facts.unanswered > 200);
  CHECK(lossy.facts.unanswered < 460);
  CHECK(!lossy.run.diverged);
  // Latency delays input and output; the loop keeps its rate. With one millisecond in each
  // direction the first force is two ticks late.
  const auto first = [](const Held& held) {
    return first_force(held.run, "device.delivered_n", 0.05);
  };
  const Held late = faulty({.kind = Kind::latency, .latency = 1e-3});
  CHECK(late.facts.ticks == sound.facts.ticks);
  CHECK(late.facts.unanswered < 60);  // of 1200: a reply at a tick's border can belong to either
  CHECK(first(late) >= first(sound) + 2);
  CHECK(first(late) <= first(sound) + 4);
  // After 100 ms without link the watchdog releases the motors: no force despite a larger command.
  const Held unplugged = faulty({.kind = Kind::unplug, .start = 0.6, .end = 0.7});
  const std::size_t tick = 660;
  CHECK(sound.run.find("device.delivered_n")->values[tick] > 0.1);
  CHECK_NEAR(unplugged.run.find("device.delivered_n")->values[tick], 0.0, 1e-6);
}

TEST("the loop of a device that lost its zero uses neither its position nor its motors") {
  using Kind = device::falcon::LinkFault::Kind;
  const Held sound = hold(held_scene());
  CHECK(sound.facts.unhomed == 0);
  const device::falcon::LinkFault off{.kind = Kind::power_loss, .start = 0.6, .end = 0.65};
  const Held lost = hold(held_scene(), {.faults = {.seed = 3, .faults = {off}}});
  CHECK(!lost.run.diverged);
  CHECK(lost.facts.unhomed > 500);  // of the 550 ticks after power returned
  CHECK(lost.facts.largest_requested <= sound.facts.largest_requested);
  const auto last = [](const Held& held, const char* name) {
    return held.run.find(name)->values.back();
  };
  CHECK(last(sound, "device.requested_n") > 0.0);
  CHECK(last(lost, "device.requested_n") == 0.0);
  // An additional lost reply does not return stale bytes.
  const device::falcon::LinkFault drop{.kind = Kind::drop, .probability = 0.01, .start = 0.65};
  const Held lossy = hold(held_scene(), {.faults = {.seed = 3, .faults = {off, drop}}});
  CHECK(lossy.facts.unanswered > 50);
  CHECK(lossy.facts.largest_requested <= sound.facts.largest_requested);
  CHECK(last(lossy, "device.requested_n") == 0.0);
  // Nothing moves the handle: the needle stays at its last position.
  const std::vector<double>& place = lost.run.find("tool.insertion_m")->values;
  CHECK_NEAR(place.back(), place[place.size() - 100], 1e-5);
}

TEST("a sparse trace has every row that it should, all events and the largest values") {
  const Scene scene = insertion_scene(0.6);
  const Trace whole = run_of(scene, 0);
  ModelSubject subject{Simulation(scene)};
  const Trace sparse = roll_out(subject, scene, {.every = 50, .extremes = true});
  CHECK(sparse.rows() < whole.rows() / 10);
  CHECK(sparse.events.size() == whole.events.size());
  for (std::size_t n = 0; n < sparse.events.size(); ++n) {
    CHECK(sparse.events[n].time == whole.events[n].time);
    CHECK(sparse.events[n].kind == whole.events[n].kind);
  }
  for (const char* name : {"tool.force_n", "tool.insertion_m"}) {
    CHECK(std::ranges::max(sparse.values(name)) == std::ranges::max(whole.values(name)));
  }
  std::size_t row = 0;
  for (std::size_t tick = 0; tick < whole.rows(); ++tick) {
    const bool here = row < sparse.rows() && sparse.time[row] == whole.time[tick];
    const bool due = tick % 50 == 0 || !whole.texts("tool.event")[tick].empty();
    if (due) { CHECK(here); }
    if (!here) { continue; }
    for (std::size_t n = 0; n < whole.columns.size(); ++n) {
      CHECK(sparse.columns[n].values[row] == whole.columns[n].values[tick]);
    }
    for (std::size_t n = 0; n < whole.text_columns.size(); ++n) {
      CHECK(sparse.text_columns[n].values[row] == whole.text_columns[n].values[tick]);
    }
    ++row;
  }
  CHECK(row == sparse.rows());
}

TEST("a trace that would not fit in memory is refused before its first tick, with its key") {
  Scene scene = insertion_scene(0.6);
  scene.simulation.duration = 1e6;
  CHECK_THROWS_AS(InputError, run_of(scene, 0), "simulation.duration: 1e+09 rows of");
  scene.simulation.duration = 1e5;
  ModelSubject subject{Simulation(scene)};
  CHECK_THROWS_AS(InputError, roll_out(subject, scene, {.every = 1000, .frames = 100'000'000}),
                  "output.frames: 100000000 states of");
}

TEST("a row that is not finite ends a run as diverged and is not in the trace") {
  Scene scene = insertion_scene(0.6);
  scene.syringe.emplace().thumb_flow = 1e308;  // the pressure it would reach is infinite
  const Trace trace = run_of(scene, 0);
  CHECK(trace.diverged);
  CHECK(trace.ticks < 600);
  CHECK(trace.time.size() == static_cast<std::size_t>(trace.ticks));  // the first row, not the last
  for (const Column& column : trace.columns) {
    CHECK(column.values.size() == trace.time.size());
    CHECK(std::ranges::all_of(column.values, [](double value) { return std::isfinite(value); }));
  }
}

}  // namespace PALPATE_FILE
