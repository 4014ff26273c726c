// SPDX-License-Identifier: MIT
#pragma once
/// Proof that code asks nothing of the operating system: it runs in a child process that is killed
/// by its first system call. Uncontended locks make no call, so those are counted. Include in one
/// source file of a test, linked with the library of dlsym; not with sanitizers.

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

/// Taken by the calling thread.
inline thread_local volatile long locks = 0;

/// From here on this thread may only leave. False where the system refuses such filters.
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

/// In a child: `prepare()` with all calls allowed, which may start threads that keep them, then
/// `body(prepared)` without any; it returns whether all went well.
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
