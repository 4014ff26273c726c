// SPDX-License-Identifier: MIT

#include "reports/timing/child_process.hpp"

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <sstream>
#include <stdexcept>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "fixtures/io/file_bytes.hpp"

namespace palpate::timing {

namespace {

constexpr auto look_every = std::chrono::milliseconds(10);
constexpr int looks_after_stop = 30;  // for clean-up, then the call returns

/// Runs in the child. It must not allocate, since threads of the parent may have held the
/// allocator's lock.
[[noreturn]] void become(char* const* arguments, int output, int errors) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  dup2(output, STDOUT_FILENO);
  dup2(errors, STDERR_FILENO);
  execvp(arguments[0], arguments);
  _exit(127);
}

/// Starts a program whose output goes to files.
pid_t start(std::vector<std::string> words, const std::filesystem::path& output,
            const std::filesystem::path& errors) {
  std::vector<char*> arguments;
  for (std::string& word : words) { arguments.push_back(word.data()); }
  arguments.push_back(nullptr);
  constexpr int flags = O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC;
  const int to_output = open(output.c_str(), flags, 0600);
  const int to_errors = open(errors.c_str(), flags, 0600);
  const pid_t child = fork();
  if (child == 0) { become(arguments.data(), to_output, to_errors); }
  const std::string problem = std::strerror(errno);
  close(to_output);
  close(to_errors);
  if (child < 0) { throw std::runtime_error(words.front() + " cannot be started: " + problem); }
  return child;
}

}  // namespace

Background::Background(const std::vector<std::string>& words)
    : process_(start(words, "/dev/null", "/dev/null")) {}

Background::~Background() {
  kill(process_, SIGTERM);
  waitpid(process_, nullptr, 0);
}

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
  constexpr std::size_t most_bytes = 1U << 26U;
  const io::ScratchFolder folder;
  const pid_t child = start(words, folder / "output", folder / "errors");
  ChildEnd end;
  int status = 0;
  for (int looks = 0; waitpid(child, &status, WNOHANG) == 0 && looks <= looks_after_stop;) {
    if (stop != nullptr && stop->load()) {
      if (!end.stopped) { kill(child, SIGTERM); }
      end.stopped = true;
      ++looks;
    }
    std::this_thread::sleep_for(look_every);
  }
  end.output = io::read_bytes(folder / "output", most_bytes);
  end.errors = io::read_bytes(folder / "errors", most_bytes);
  end.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return end;
}

}  // namespace palpate::timing
