// SPDX-License-Identifier: MIT

#include "validation/roll_out.hpp"

#include "tests/check.hpp"
#include "tests/validation/insertion_scenes.hpp"

namespace {

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

TEST("no more events are kept than requested, and none without a tool") {
  CHECK(run_of(insertion_scene(0.6), 1).keyframes.time.size() == 2);
  CHECK(run_of(insertion_scene(0.6), 0).keyframes.time.empty());
  Scene bare = insertion_scene(0.6);
  bare.needle.reset();
  bare.drive.reset();
  CHECK(run_of(bare, 5).keyframes.time.empty());
}

}  // namespace
