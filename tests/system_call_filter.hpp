// SPDX-License-Identifier: MIT
#pragma once
/// Test that code makes no system call: it runs in a child process that is killed by its first
/// system call. Uncontended locks make no call, so they are counted separately. Include it in one
/// source file of a test and link the library of dlsym. It does not work with sanitizers.

#include <cstddef>
#include <cstdlib>
#include <dlfcn.h>
#include <fcntl.h>
#include <iterator>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <pthread.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

namespace check {

/// Number of locks taken by the calling thread.
inline thread_local volatile long locks = 0;

/// Forbids all system calls of this thread except exit. Returns false if the system does not
/// support such filters.
inline bool forbid_system_calls() {
  sock_filter program[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_exit_group, 1, 0),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  };
  const sock_fprog filter{static_cast<unsigned short>(std::size(program)), program};
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) == 0;
}

enum class Verdict { silent, called, refused, diverged };

/// Runs `prepare()` in a child with all system calls allowed, then `body(prepared)` without any.
/// Threads started by `prepare()` may still make calls. `body` returns true on success.
template <class Prepare, class Body> Verdict without_system_calls(Prepare prepare, Body body) {
  const pid_t child = fork();
  if (child == 0) {
    auto prepared = prepare();
    if (!forbid_system_calls()) { _exit(2); }
    syscall(SYS_exit_group, body(prepared) ? 0 : 3);
  }
  int status = 0;
  waitpid(child, &status, 0);
  if (WIFSIGNALED(status)) { return Verdict::called; }
  return WEXITSTATUS(status) == 0   ? Verdict::silent
         : WEXITSTATUS(status) == 2 ? Verdict::refused
                                    : Verdict::diverged;
}

template <class Body> Verdict without_system_calls(Body body) {
  return without_system_calls([] { return 0; }, [&](int) { return body(); });
}

}  // namespace check

extern "C" int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  using Lock = int (*)(pthread_mutex_t*);
  static const Lock next = reinterpret_cast<Lock>(dlsym(RTLD_NEXT, "pthread_mutex_lock"));
  check::locks = check::locks + 1;
  return next(mutex);
}
