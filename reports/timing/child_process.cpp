// SPDX-License-Identifier: MIT

#include "reports/timing/child_process.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <valgrind/callgrind.h>

#include "fixtures/io/file_bytes.hpp"
#include "model/problem/input_error.hpp"

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
  if (to_output < 0 || to_errors < 0) {
    const std::string problem = std::strerror(errno);
    close(to_output);
    io::refuse_file(to_output < 0 ? output : errors,
                    "cannot be written: " + problem + "; space for temporary files is needed");
  }
  const pid_t child = fork();
  if (child == 0) { become(arguments.data(), to_output, to_errors); }
  const std::string problem = std::strerror(errno);
  close(to_output);
  close(to_errors);
  if (child < 0) { throw std::runtime_error(words.front() + " cannot be started: " + problem); }
  return child;
}

constexpr std::size_t most_bytes = 1U << 26U;
constexpr int main_thread = 1;  // callgrind's number of it
constexpr std::string_view request = "desc: Trigger: Client Request: ";

/// Returns the text after a key at the start of a line.
std::optional<std::string> after(const std::string& line, std::string_view key) {
  if (!line.starts_with(key)) { return std::nullopt; }
  return line.substr(key.size());
}

template <class Integer> Integer number_from(const std::string& text, const std::string& file) {
  Integer number = 0;
  const char* end = text.data() + text.size();
  const auto [rest, problem] = std::from_chars(text.data(), end, number);
  if (problem != std::errc() || rest != end) {
    throw InputError(file + ": \"" + text + "\" where a count should be; a whole number");
  }
  return number;
}

std::string why_not(const std::filesystem::path& valgrind) {
#ifdef PALPATE_SANITIZED
  return "a program with sanitizers does not run under valgrind";
#endif
  return valgrind.empty() ? "valgrind is not installed (the package valgrind)" : "";
}

std::vector<std::string> command_of(const std::filesystem::path& valgrind,
                                    const std::filesystem::path& folder,
                                    const std::vector<std::string>& words) {
  std::vector<std::string> command{valgrind.string(),
                                   "--tool=callgrind",
                                   "--instr-atstart=no",
                                   "--separate-threads=yes",
                                   "--vgdb=no",
                                   "--callgrind-out-file=" + (folder / "part").string(),
                                   own_program().string(),
                                   "steps"};
  command.insert(command.end(), words.begin(), words.end());
  return command;
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

CallgrindPart part_from(const std::string& text, const std::string& file) {
  CallgrindPart part;
  bool counted = false;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (const auto creator = after(line, "creator: ")) { part.creator = *creator; }
    if (const auto label = after(line, request)) { part.label = *label; }
    if (const auto number = after(line, "part: ")) {
      part.number = number_from<int>(*number, file);
    }
    if (const auto thread = after(line, "thread: ")) {
      part.thread = number_from<int>(*thread, file);
    }
    if (const auto events = after(line, "events: "); events && *events != "Ir") {
      throw InputError(file + ": counts " + *events + "; Ir alone");
    }
    if (const auto totals = after(line, "totals: ")) {
      part.instructions = number_from<std::int64_t>(*totals, file);
      counted = true;
    }
  }
  if (!counted) { throw InputError(file + ": ends without totals; a whole file of callgrind"); }
  return part;
}

std::vector<CallgrindPart> labelled_parts(const std::filesystem::path& folder) {
  std::vector<CallgrindPart> parts;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    // "part.1-01" was requested; "part" and "part-01" are left at the end of the program.
    if (!entry.path().has_extension()) { continue; }
    parts.push_back(part_from(io::read_text(entry.path(), most_bytes), entry.path().string()));
  }
  // Another thread (it waits for signals) may start late, when the main thread already counts.
  std::erase_if(parts, [](const CallgrindPart& part) {
    return part.label.empty() || part.thread != main_thread;
  });
  std::ranges::sort(parts, {}, &CallgrindPart::number);
  return parts;
}

void run_counted(const std::string& label, const std::function<void()>& work) {
  const char* const text = label.c_str();
  CALLGRIND_START_INSTRUMENTATION;
  CALLGRIND_ZERO_STATS;
  work();
  CALLGRIND_DUMP_STATS_AT(text);
  CALLGRIND_STOP_INSTRUMENTATION;
}

InstructionCount count_steps(const std::vector<std::string>& words, const std::atomic<bool>* stop) {
  InstructionCount count;
  const std::filesystem::path valgrind = find_program("valgrind");
  count.refusal = why_not(valgrind);
  if (!count.refusal.empty()) { return count; }
  const io::ScratchFolder folder;
  const ChildEnd end = run_child(command_of(valgrind, folder.path(), words), stop);
  if (end.stopped) {
    count.refusal = "interrupted";
  } else if (end.status == bad_input) {
    throw InputError(end.last_words());
  } else if (end.status != 0) {
    count.refusal = "valgrind ended with " + std::to_string(end.status) + ": " + end.last_words();
  } else {
    for (const CallgrindPart& part : labelled_parts(folder.path())) {
      count.passes.push_back(part.instructions);
      count.kernel = part.label;
      count.counter = part.creator;
    }
    if (count.passes.empty()) { count.refusal = "callgrind counted nothing"; }
  }
  return count;
}

InstructionCounter callgrind_counter(const std::atomic<bool>* stop) {
  // Each count starts a new process. A second count in one process would use other memory
  // addresses, which changes the instruction count.
  return [stop](const std::string& workload) {
    InstructionCount count = count_steps({workload}, stop);
    if (!count.refusal.empty()) { return count; }
    const InstructionCount again = count_steps({workload}, stop);
    count.refusal = again.refusal;
    count.passes.insert(count.passes.end(), again.passes.begin(), again.passes.end());
    return count;
  };
}

}  // namespace palpate::timing
