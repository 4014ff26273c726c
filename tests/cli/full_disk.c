/* SPDX-License-Identifier: MIT */
/* Preloaded library that simulates a full disk: call number FULL_DISK_CALL, of those that write to a regular file or that create
   or rename a file, fails with ENOSPC. With FULL_DISK_STAYS the calls after it fail too, and the first write is cut short as a kernel does it.
   The failed call is noted in the file FULL_DISK_NOTE. Programs that the process starts are not affected. */

#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

static long failing_call;
static int stays;
static char note_path[4096];
static atomic_long calls;

__attribute__((constructor)) static void read_environment(void) {
  const char* call = getenv("FULL_DISK_CALL");
  const char* note = getenv("FULL_DISK_NOTE");
  failing_call = call != NULL ? atol(call) : 0;
  stays = getenv("FULL_DISK_STAYS") != NULL;
  if (note != NULL) { snprintf(note_path, sizeof note_path, "%s", note); }
  unsetenv("LD_PRELOAD");
}

static void note(const char* function, const char* path) {
  char text[4352];
  const int size = snprintf(text, sizeof text, "%s %s\n", function, path);
  const long file = syscall(SYS_openat, AT_FDCWD, note_path, O_WRONLY | O_CREAT | O_APPEND, 0644);
  if (file >= 0) {
    (void)!syscall(SYS_write, file, text, (size_t)size);
    syscall(SYS_close, file);
  }
}

/* Returns 1 if this call fails, 2 if it is the first one. */
static int fails(const char* function, const char* path) {
  if (failing_call <= 0) { return 0; }
  const long number = atomic_fetch_add(&calls, 1) + 1;
  if (number < failing_call || (number > failing_call && !stays)) { return 0; }
  if (number == failing_call) { note(function, path); }
  errno = ENOSPC;
  return number == failing_call ? 2 : 1;
}

static int fails_on(const char* function, int file) {
  struct stat found;
  if (fstat(file, &found) != 0 || !S_ISREG(found.st_mode)) { return 0; }
  char link[64];
  char path[4096];
  snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  const ssize_t size = readlink(link, path, sizeof path - 1);
  path[size > 0 ? size : 0] = '\0';
  if (strncmp(path, "/memfd:", 7) == 0) { return 0; }
  return fails(function, path);
}

#define NEXT(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

ssize_t write(int file, const void* bytes, size_t size) {
  const int failed = fails_on("write", file);
  if (failed == 2 && stays && size > 1) { return syscall(SYS_write, file, bytes, size / 2); }
  return failed ? -1 : syscall(SYS_write, file, bytes, size);
}
ssize_t writev(int file, const struct iovec* parts, int count) {
  return fails_on("writev", file) ? -1 : syscall(SYS_writev, file, parts, count);
}
ssize_t pwrite(int file, const void* bytes, size_t size, off_t at) {
  return fails_on("pwrite", file) ? -1 : syscall(SYS_pwrite64, file, bytes, size, at);
}
size_t fwrite(const void* bytes, size_t size, size_t count, FILE* file) {
  return fails_on("fwrite", fileno(file)) ? 0 : NEXT(fwrite)(bytes, size, count, file);
}
int fsync(int file) { return fails_on("fsync", file) ? -1 : (int)syscall(SYS_fsync, file); }
int fdatasync(int file) { return fails_on("fdatasync", file) ? -1 : (int)syscall(SYS_fdatasync, file); }
int ftruncate(int file, off_t size) {
  return fails_on("ftruncate", file) ? -1 : (int)syscall(SYS_ftruncate, file, size);
}
int rename(const char* from, const char* to) { return fails("rename", to) ? -1 : NEXT(rename)(from, to); }
int mkdir(const char* path, mode_t mode) {
  struct stat found;
  if (stat(path, &found) == 0) { return NEXT(mkdir)(path, mode); }
  return fails("mkdir", path) ? -1 : NEXT(mkdir)(path, mode);
}
char* mkdtemp(char* path) { return fails("mkdtemp", path) ? NULL : NEXT(mkdtemp)(path); }
static int creates(const char* mode) { return strchr(mode, 'w') != NULL || strchr(mode, 'a') != NULL; }
static int is_device(const char* path) { return strncmp(path, "/dev/", 5) == 0; }
FILE* fopen(const char* path, const char* mode) {
  if (creates(mode) && !is_device(path) && fails("fopen", path)) { return NULL; }
  return NEXT(fopen)(path, mode);
}
int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(more, mode_t) : 0;
  va_end(more);
  if ((flags & O_CREAT) != 0 && !is_device(path) && fails("open", path)) { return -1; }
  return (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode);
}
/* The same functions under the names that a program with large files uses. */
ssize_t pwrite64(int, const void*, size_t, off64_t) __attribute__((alias("pwrite")));
int ftruncate64(int, off64_t) __attribute__((alias("ftruncate")));
FILE* fopen64(const char*, const char*) __attribute__((alias("fopen")));
int open64(const char*, int, ...) __attribute__((alias("open")));
