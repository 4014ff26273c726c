// SPDX-License-Identifier: MIT
/// Test that a tick makes no system call and takes no lock (system_call_filter.hpp).

#include <mutex>

#include "model/stepping/simulation.hpp"
#include "tests/check.hpp"
#include "tests/model/sample_scenes.hpp"
#include "tests/system_call_filter.hpp"

namespace PALPATE_FILE {

using namespace palpate;
using check::locks;
using check::Verdict;
using check::without_system_calls;

bool thousand_ticks(Simulation& simulation, std::vector<double>& row) {
  bool fine = true;
  for (int n = 0; n < 1000; ++n) {
    fine = simulation.tick() == StepStatus::ok && fine;
    simulation.sample(row);
  }
  return fine;
}

TEST("the filter allows computation and stops the smallest system call") {
  const Verdict quiet = without_system_calls([] { return true; });
  if (quiet == Verdict::refused) { check::skip("this system refuses seccomp filters"); }
  CHECK(quiet == Verdict::silent);
  CHECK(without_system_calls([] { return syscall(SYS_getpid) > 0; }) == Verdict::called);
  CHECK(without_system_calls([] { return write(1, "", 0) == 0; }) == Verdict::called);
}

void check_silent(const Scene& scene) {
  Simulation simulation(scene);
  std::vector<double> row(simulation.columns().size());
  CHECK(without_system_calls([&] { return thousand_ticks(simulation, row); }) == Verdict::silent);
  const long before = locks;
  CHECK(thousand_ticks(simulation, row));
  CHECK(locks == before);
}

TEST("a thousand sampled ticks of any scheme make no system call and take no lock") {
  for (const IntegratorInfo* scheme : integrators()) {
    for (const Precision precision : {Precision::double_precision, Precision::single_precision}) {
      check_silent(moving_scene(scheme->name, precision));
    }
  }
}

TEST("a thousand sampled ticks of an insertion make no system call and take no lock") {
  for (const char* scheme : {"velocity-verlet", "implicit-euler"}) {
    Scene scene = layered_scene();
    scene.syringe = Syringe{};
    scene.simulation = {.duration = 2.0, .step = 1e-3, .integrator = scheme};
    check_silent(scene);
  }
}

TEST("the counter counts an uncontended lock") {
  const long before = locks;
  static std::mutex mutex;
  mutex.lock();
  mutex.unlock();
  CHECK(locks == before + 1);
}

}  // namespace PALPATE_FILE
