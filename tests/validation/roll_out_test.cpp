// SPDX-License-Identifier: MIT

#include "validation/roll_out.hpp"

#include "tests/check.hpp"
#include "tests/model/sample_scenes.hpp"

using namespace palpate;

namespace {

Scene insertion() {
  Scene scene = layered_scene();
  scene.simulation = {.duration = 0.6, .step = 1e-3};
  return scene;
}

}  // namespace

TEST("nodes are kept at ticks with events and at the largest force, in order of time") {
  Simulation simulation(insertion());
  const Run run = roll_out(simulation, {.events = 20});
  const auto& force = run.trace.find("tool.force_n")->values;
  const auto most = static_cast<std::size_t>(std::ranges::max_element(force) - force.begin());
  const auto& event = run.trace.text_columns[1].values;
  std::vector<double> expected;
  for (std::size_t row = 0; row < event.size(); ++row) {
    if (!event[row].empty() || row == most) { expected.push_back(run.trace.time[row]); }
  }
  CHECK(expected.size() >= 3);
  CHECK(run.moments.time == expected);
}

TEST("what is kept is where the nodes were then") {
  Simulation simulation(insertion());
  const Run run = roll_out(simulation, {.events = 20});
  Simulation again(insertion());
  std::size_t found = 0;
  while (again.ticks() < again.tick_count()) {
    again.tick();
    const auto at = std::ranges::find(run.moments.time, again.time());
    if (at == run.moments.time.end()) { continue; }
    ++found;
    CHECK(run.moments.positions[static_cast<std::size_t>(at - run.moments.time.begin())] ==
          again.node_positions());
  }
  CHECK(found + (run.moments.time.front() == 0.0 ? 1 : 0) == run.moments.time.size());
}

TEST("no more events are kept than wanted, none without wish, and none without a tool") {
  Simulation one(insertion());
  CHECK(roll_out(one, {.events = 1}).moments.time.size() == 2);
  Simulation none(insertion());
  CHECK(roll_out(none, {}).moments.time.empty());
  Scene bare = insertion();
  bare.needle.reset();
  bare.drive.reset();
  Simulation without_tool(bare);
  CHECK(roll_out(without_tool, {.events = 5}).moments.time.empty());
}
