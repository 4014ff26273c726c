// SPDX-License-Identifier: MIT

#include "reports/timing/child_process.hpp"

#include <array>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <sstream>
#include <stdexcept>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace palpate::timing {

namespace {

constexpr int look_every_ms = 50;
constexpr int looks_after_stop = 6;  // polls for clean-up, then the call returns

/// Pipe with two ends; the child receives a copy of the second.
struct Pipe {
  std::array<int, 2> ends{-1, -1};
  Pipe() {
    if (pipe2(ends.data(), O_CLOEXEC) != 0) {
      throw std::runtime_error(std::string("no pipe: ") + std::strerror(errno));
    }
  }
  ~Pipe() {
    for (const int end : ends) {
      if (end >= 0) { close(end); }
    }
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  void close_writer() {
    close(ends[1]);
    ends[1] = -1;
  }
};

/// Runs in the child. It must not allocate, since threads of the parent may have held the
/// allocator's lock.
[[noreturn]] void become(char* const* arguments, const Pipe& output, const Pipe& errors) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  dup2(output.ends[1], STDOUT_FILENO);
  dup2(errors.ends[1], STDERR_FILENO);
  execv(arguments[0], arguments);
  _exit(127);
}

/// Reads the available bytes. Returns false at the end of the pipe.
bool take(int from, std::string& text) {
  std::array<char, 4096> buffer{};
  const ssize_t count = read(from, buffer.data(), buffer.size());
  if (count > 0) { text.append(buffer.data(), static_cast<std::size_t>(count)); }
  return count > 0;
}

/// Reads until both pipes are closed.
void listen(pid_t child, const Pipe& output, const Pipe& errors, const std::atomic<bool>* stop,
            ChildEnd& end) {
  std::array<pollfd, 2> watched{{{output.ends[0], POLLIN, 0}, {errors.ends[0], POLLIN, 0}}};
  int looks = 0;
  while ((watched[0].fd >= 0 || watched[1].fd >= 0) && looks <= looks_after_stop) {
    if (stop != nullptr && stop->load()) {
      if (!end.stopped) { kill(child, SIGTERM); }
      end.stopped = true;
      ++looks;
    }
    if (poll(watched.data(), watched.size(), look_every_ms) <= 0) { continue; }
    if (watched[0].revents != 0 && !take(watched[0].fd, end.output)) { watched[0].fd = -1; }
    if (watched[1].revents != 0 && !take(watched[1].fd, end.errors)) { watched[1].fd = -1; }
  }
}

}  // namespace

std::filesystem::path find_program(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::filesystem::path file = std::filesystem::path(folder) / name;
    if (access(file.c_str(), X_OK) == 0) { return file; }
  }
  return {};
}

std::filesystem::path own_program() { return std::filesystem::read_symlink("/proc/self/exe"); }

std::string ChildEnd::last_words() const {
  std::istringstream lines(errors);
  std::string last;
  for (std::string line; std::getline(lines, line);) {
    const bool of_valgrind = line.starts_with("==");
    if (!line.empty() && !of_valgrind) { last = line; }
  }
  constexpr std::string_view ours = "palpate: ";
  return last.starts_with(ours) ? last.substr(ours.size()) : last;
}

ChildEnd run_child(const std::vector<std::string>& words, const std::atomic<bool>* stop) {
  std::vector<std::string> copies = words;
  std::vector<char*> arguments;
  for (std::string& word : copies) { arguments.push_back(word.data()); }
  arguments.push_back(nullptr);
  Pipe output;
  Pipe errors;
  const pid_t child = fork();
  if (child < 0) {
    throw std::runtime_error(words.front() + " cannot be started: " + std::strerror(errno));
  }
  if (child == 0) { become(arguments.data(), output, errors); }
  output.close_writer();
  errors.close_writer();
  ChildEnd end;
  listen(child, output, errors, stop, end);
  int status = 0;
  while (waitpid(child, &status, end.stopped ? WNOHANG : 0) < 0 && errno == EINTR) {}
  end.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return end;
}

}  // namespace palpate::timing
