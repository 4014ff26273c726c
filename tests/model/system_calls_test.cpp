// SPDX-License-Identifier: MIT
/// A tick asks nothing of the operating system: it runs in a child process that is killed by its
/// first system call. Uncontended locks make no call, so those are counted.
#include <cstddef>
#include <cstdlib>
#include <dlfcn.h>
#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <mutex>
#include <pthread.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "model/stepping/simulation.hpp"
#include "tests/check.hpp"
#include "tests/model/moving_scene.hpp"
#include "tests/model/tool_scenes.hpp"

namespace {
volatile long locks = 0;
}

extern "C" int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  using Lock = int (*)(pthread_mutex_t*);
  static const Lock next = reinterpret_cast<Lock>(dlsym(RTLD_NEXT, "pthread_mutex_lock"));
  locks = locks + 1;
  return next(mutex);
}

namespace {

using namespace palpate;

/// From here on only leaving is allowed. False where the system refuses such filters.
bool forbid_system_calls() {
  sock_filter program[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_exit, 1, 0),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  };
  const sock_fprog filter{static_cast<unsigned short>(std::size(program)), program};
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) == 0;
}

enum class Verdict { silent, called, refused, diverged };

/// Runs `body` in a child without system calls; it returns whether all went well.
template <class Body>
Verdict without_system_calls(Body body) {
  const pid_t child = fork();
  if (child == 0) {
    if (!forbid_system_calls()) { _exit(2); }
    syscall(SYS_exit, body() ? 0 : 3);
  }
  int status = 0;
  waitpid(child, &status, 0);
  if (WIFSIGNALED(status)) { return Verdict::called; }
  return WEXITSTATUS(status) == 0   ? Verdict::silent
         : WEXITSTATUS(status) == 2 ? Verdict::refused
                                    : Verdict::diverged;
}

bool thousand_ticks(Simulation& simulation, std::vector<double>& row) {
  bool fine = true;
  for (int n = 0; n < 1000; ++n) {
    fine = simulation.tick() == StepStatus::ok && fine;
    simulation.sample(row);
  }
  return fine;
}

TEST("the filter lets computation through and stops the smallest call") {
  const Verdict quiet = without_system_calls([] { return true; });
  if (quiet == Verdict::refused) {
    std::printf("  not run: this system refuses seccomp filters\n");
    std::exit(77);
  }
  CHECK(quiet == Verdict::silent);
  CHECK(without_system_calls([] { return syscall(SYS_getpid) > 0; }) == Verdict::called);
  CHECK(without_system_calls([] { return write(1, "", 0) == 0; }) == Verdict::called);
}

TEST("a thousand sampled ticks of any scheme make no system call") {
  for (const IntegratorInfo* scheme : integrators()) {
    for (const Precision precision : {Precision::double_precision, Precision::single_precision}) {
      Simulation simulation(moving_scene(scheme->name, precision));
      std::vector<double> row(simulation.columns().size());
      CHECK(without_system_calls([&] { return thousand_ticks(simulation, row); }) ==
            Verdict::silent);
    }
  }
}

TEST("the counter sees a lock that nobody else holds") {
  const long before = locks;
  static std::mutex mutex;
  mutex.lock();
  mutex.unlock();
  CHECK(locks == before + 1);
}

TEST("a thousand sampled ticks of any scheme take no lock") {
  for (const IntegratorInfo* scheme : integrators()) {
    Simulation simulation(moving_scene(scheme->name));
    std::vector<double> row(simulation.columns().size());
    const long before = locks;
    CHECK(thousand_ticks(simulation, row));
    CHECK(locks == before);
  }
}

TEST("a thousand sampled ticks of an insertion make no system call and take no lock") {
  for (const char* scheme : {"velocity-verlet", "implicit-euler"}) {
    Scene scene = layered_scene();
    scene.syringe = Syringe{};
    scene.simulation = {.duration = 2.0, .step = 1e-3, .integrator = scheme};
    Simulation simulation(scene);
    std::vector<double> row(simulation.columns().size());
    CHECK(without_system_calls([&] { return thousand_ticks(simulation, row); }) == Verdict::silent);
    const long before = locks;
    CHECK(thousand_ticks(simulation, row));
    CHECK(locks == before);
  }
}

}  // namespace
