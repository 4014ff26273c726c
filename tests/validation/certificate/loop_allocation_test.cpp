// SPDX-License-Identifier: MIT
// Test that the certified loop of `palpate certify` neither allocates nor causes page faults after
// its start.

#include "tests/allocation_count.hpp"
#include "tests/check.hpp"
#include "tests/validation/insertion_scenes.hpp"
#include "validation/certificate/paced_loop.hpp"
#include "validation/certificate/scene_loop.hpp"

namespace PALPATE_FILE {

using namespace palpate::certificate;
using namespace palpate;

struct Found {
  long allocations = 0, faults = 0, ticks = 0;
};

/// Runs the scene at 2 kHz of virtual time, after one pass at full speed that loads code and tables
/// into memory. Counts the allocations and page faults of the second pass.
Found run(const Scene& scene, bool allocating) {
  constexpr double rate = 2000.0;
  {
    SceneLoop before(scene, rate);
    while (!before.over()) { (void)before.tick(); }
  }
  SceneLoop loop(scene, rate);
  LoopRecord record(1.0 / rate);
  device::VirtualClock time;
  PacedLoop paced{.period = 1.0 / rate, .clock = &time};
  const long allocations = check::allocations;
  paced.run(loop.tick_count(), record, [&](Moment& moment) {
    (void)loop.tick();
    moment = loop.moment();
    double* volatile leak = allocating && record.ticks() == 3 ? new double(1.0) : nullptr;
    delete leak;
    return !loop.over();
  });
  return {.allocations = check::allocations - allocations,
          .faults = paced.counts.minor_faults + paced.counts.major_faults,
          .ticks = record.ticks()};
}

Scene in_hand() {
  Scene scene = hand_scene(0.3, 5e-4, 0.05);
  scene.falcon = FalconDrive{.rate = 2000.0};
  return scene;
}

TEST("insertions with syringe and link, and through a Falcon, neither allocate nor fault") {
  device::touch_stack();
  const device::LockedMemory locked;
  if (!locked.refusal().empty()) {
    std::printf("  memory is not locked: %s\n", locked.refusal().c_str());
  }
  for (const Scene& scene : {syringe_scene(5e-4), in_hand()}) {
    Found found = run(scene, false);
    CHECK(found.ticks == 600);
    CHECK(found.allocations == 0);
    // Without locked memory the system may remove pages at any time. With it, the kernel still
    // moves pages (compaction, balancing between nodes), and the next access is a minor fault. A
    // fault of the loop itself occurs in every run, a moved page does not.
    if (locked.refusal().empty()) {
      for (int repeat = 0; found.faults > 0 && repeat < 4; ++repeat) { found = run(scene, false); }
      CHECK(found.faults == 0);
    }
  }
}

TEST("one allocation in one tick is counted, and so is one page that was never touched") {
  CHECK(run(syringe_scene(5e-4), true).allocations == 1);
  LoopRecord record(1.0);
  PacedLoop paced{.period = 1e-3};
  std::vector<char> memory;
  memory.reserve(std::size_t{1} << 22U);  // from the system, untouched
  volatile char* const place = memory.data() + (std::size_t{1} << 21U);
  paced.run(5, record, [&](Moment&) {
    if (record.ticks() == 2) { *place = 1; }
    return true;
  });
  CHECK(paced.counts.minor_faults >= 1);
}

}  // namespace PALPATE_FILE
