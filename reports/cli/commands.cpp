// SPDX-License-Identifier: MIT

#include "reports/cli/commands.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fcntl.h>
#include <fstream>
#include <poll.h>
#include <semaphore.h>
#include <sstream>
#include <sys/file.h>
#include <system_error>
#include <thread>
#include <unistd.h>

#include "palpate_version.hpp"

#include "fixtures/io/child_read.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "model/problem/input_error.hpp"
#include "model/stepping/integrator.hpp"
#include "reports/index_page.hpp"
#include "validation/number_text.hpp"

namespace palpate::cli {

namespace fs = std::filesystem;

namespace {

/// Locks a folder until the process ends. Returns false if another process holds the lock.
bool lock_until_end(const fs::path& folder) {
  const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) {
    throw InputError(folder.string() + ": cannot be opened: " + std::strerror(errno) +
                     "; a folder that can be read");
  }
  const bool held = flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  if (held) { close(descriptor); }
  return !held;  // also on a file system without locks
}

}  // namespace

void lock_folder(const fs::path& folder) {
  constexpr int tries_a_second = 50;
  for (int tries = 0; !lock_until_end(folder); ++tries) {
    if (interrupted) { throw io::ReadInterrupted(); }
    if (tries == tries_a_second) {
      std::fprintf(stderr, "palpate: waiting for another palpate that writes to %s\n",
                   io::printable(folder.string()).c_str());
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1000 / tries_a_second));
  }
}

namespace {

/// Default output folder of this process, once it is locked.
fs::path indexed_folder;

}  // namespace

void refuse_input(const fs::path& file) {
  if (!io::was_read(file)) { return; }
  throw InputError(file.string() +
                   ": is an input of this command, which would replace it; another --out");
}

fs::path CommonOptions::output_folder() const {
  return out.empty() ? fs::path("palpate-out") / name : out;
}

fs::path CommonOptions::make_folder(const std::vector<std::string>& files) const {
  const fs::path folder = output_folder();
  for (const std::string& file : files) {
    std::error_code absent;
    if (!file.ends_with('/')) {
      refuse_input(folder / file);
      if (fs::is_directory(folder / file, absent)) {
        throw InputError((folder / file).string() +
                         ": a folder, where this command writes a file; another --out");
      }
      continue;
    }
    for (const fs::directory_entry& each : fs::directory_iterator(folder / file, absent)) {
      refuse_input(each.path());
    }
  }
  std::error_code problem;
  fs::create_directories(folder, problem);
  if (problem && !fs::exists(folder)) {
    throw InputError(folder.string() + ": cannot be created: " + problem.message() +
                     "; a folder that can be written is needed");
  }
  if (problem || !fs::is_directory(folder) || access(folder.c_str(), W_OK | X_OK) != 0) {
    throw InputError(folder.string() + ": not a folder that can be written; a folder");
  }
  if (!lock_until_end(folder)) {
    throw InputError(folder.string() +
                     ": another palpate writes to it; wait until it ends, or use another --out");
  }
  if (out.empty()) { indexed_folder = folder; }
  return folder;
}

void refuse_folder_of(const fs::path& results, const fs::path& folder) {
  std::error_code absent;
  if (!fs::equivalent(results, folder, absent)) { return; }
  throw InputError(
      folder.string() +
      ": holds the results that are read, whose report.html would be replaced; another folder");
}

void refuse_to_replace(const fs::path& file, const std::function<bool(std::string_view)>& is_own,
                       std::string_view kind) {
  const fs::file_status status = fs::status(file);
  if (fs::is_directory(status)) { throw InputError(file.string() + ": is a folder; a file"); }
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw InputError(file.string() + ": is not a regular file; the name of a file");
  }
  refuse_input(file);
  fs::path folder = fs::absolute(file).parent_path();
  while (!fs::exists(folder) && folder.has_relative_path()) { folder = folder.parent_path(); }
  if (!fs::is_directory(folder) || access(folder.c_str(), W_OK | X_OK) != 0) {
    throw InputError(folder.string() + ": not a folder that can be written; a folder");
  }
  if (!fs::exists(status)) { return; }
  constexpr long enough = 1L << 16;
  std::string start(enough, '\0');
  std::ifstream in(file, std::ios::binary);
  in.read(start.data(), enough);
  start.resize(static_cast<std::size_t>(in.gcount()));
  if (!is_own(start)) {
    throw InputError(file.string() + ": exists and is not " + std::string(kind) +
                     "; the name of a new file, or of " + std::string(kind));
  }
}

void make_folder_of(const fs::path& file) {
  const fs::path folder = file.parent_path();
  std::error_code problem;
  if (folder.empty() || fs::create_directories(folder, problem) || fs::is_directory(folder)) {
    return;
  }
  throw InputError(folder.string() + ": cannot be created: " + problem.message() +
                   "; a folder that can be written is needed");
}

std::atomic<bool> interrupted{false};

namespace {

std::atomic<int> grace_ms{0};
sem_t signalled;

/// Runs on a thread of its own, so that also libraries and loops without a check are ended.
void end_after_signal() {
  while (sem_wait(&signalled) != 0) {}
  const int grace = grace_ms.load();
  std::this_thread::sleep_for(std::chrono::milliseconds(grace));
  constexpr std::string_view lost =
      "palpate: interrupted; results that were not ready within 0.7 s are not written\n";
  pollfd stream{.fd = STDERR_FILENO, .events = POLLOUT, .revents = 0};
  if (grace > 0 && poll(&stream, 1, 0) == 1) {  // never waits for a reader
    [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, lost.data(), lost.size());
  }
  io::end_process(interrupted_code);
}

void note_signal(int) {
  if (interrupted.exchange(true)) { _exit(interrupted_code); }  // for a write that never ends
  sem_post(&signalled);
}

}  // namespace

void catch_interrupts() {
  static_assert(std::atomic<bool>::is_always_lock_free);
  sem_init(&signalled, 0, 0);
  std::thread(end_after_signal).detach();
  io::end_reads_on(&interrupted);
  std::signal(SIGINT, note_signal);
  std::signal(SIGTERM, note_signal);
  // A terminal that is closed; nohup ignores that, and so does its child.
  if (std::signal(SIGHUP, note_signal) == SIG_IGN) { std::signal(SIGHUP, SIG_IGN); }
  std::signal(SIGXFSZ, SIG_IGN);  // a file over `ulimit -f` then causes a failed write
}

void keep_results_of_interrupted() {
  constexpr int most_ms = 700;  // of the second that a user waits; the rest is for writing
  grace_ms.store(most_ms);
}

void add_common(CLI::App& command, CommonOptions& options) {
  add_value(command, "-o,--out", options.out, "DIR",
            "output folder [palpate-out/" + options.name + "]");
  command.add_flag("-q,--quiet", options.quiet, "print errors and the last line only");
  command.set_version_flag("--version", version_text());
}

void add_json(CLI::App& command, CommonOptions& options, const std::string& file) {
  options.json_file = file;
  command.add_flag("--json", options.json,
                   file.empty() ? "as JSON on standard output"
                                : "print " + file + " on standard output and no other text there");
}

void add_verbose(CLI::App& command, CommonOptions& options, const std::string& help) {
  command.add_flag("-v,--verbose", options.verbose, help);
}

void writes_nothing(CLI::App& command) {
  for (const char* name : {"--out", "--quiet"}) { command.get_option(name)->group(""); }
}

std::string in_colour(const std::string& text, Status status) {
  const char* plain = std::getenv("NO_COLOR");
  const char* terminal = std::getenv("TERM");
  const bool dumb = terminal == nullptr || std::string_view(terminal) == "dumb";
  if (isatty(STDOUT_FILENO) == 0 || dumb || (plain != nullptr && *plain != '\0')) { return text; }
  const char* colour = status == Status::pass   ? "\033[32m"
                       : status == Status::skip ? ""
                                                : "\033[31m";
  return colour + text + "\033[0m";
}

namespace {

/// Sends standard output to standard error during its lifetime.
class TextToStandardError {
 public:
  TextToStandardError() : output_(dup(STDOUT_FILENO)) {
    std::fflush(stdout);
    dup2(STDERR_FILENO, STDOUT_FILENO);
  }
  ~TextToStandardError() {
    std::fflush(stdout);
    dup2(output_, STDOUT_FILENO);
    close(output_);
  }
  TextToStandardError(const TextToStandardError&) = delete;
  TextToStandardError& operator=(const TextToStandardError&) = delete;

 private:
  int output_;
};

}  // namespace

namespace {

/// Adds the result to palpate-out/index.html. A page that cannot be written is no failure of the
/// command.
int noted(const CommonOptions& options, int code) {
  if (indexed_folder.empty()) { return code; }
  try {
    add_to_index(indexed_folder, options.command, code);
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "palpate: warning: no index: %s\n", io::printable(problem.what()).c_str());
  }
  return code;
}

}  // namespace

int run_command(CommonOptions& options, const std::function<int()>& run) {
  if (!options.json || options.json_file.empty()) { return noted(options, run()); }
  options.quiet = true;
  const fs::path file = options.output_folder() / options.json_file;
  // A file of an earlier run is not this one's result.
  std::error_code absent;
  const fs::file_time_type before = fs::last_write_time(file, absent);
  const bool existed = !absent;
  int code = done;
  {
    const TextToStandardError redirected;
    code = run();
  }
  const fs::file_time_type after = fs::last_write_time(file, absent);
  if (!absent && (!existed || after != before)) {
    const std::string text = io::read_text(file, std::size_t{1} << 32);
    std::fwrite(text.data(), 1, text.size(), stdout);
  } else if (code == done) {
    throw InputError("--json: " + options.json_file + " is not written with these options");
  }
  return noted(options, code);
}

void add_overrides(CLI::App& command, CommonOptions& options, const std::string& file) {
  add_value(command, "--set", options.overrides, "dotted.key=value",
            file + " key to override, value in TOML syntax; repeatable");
}

void add_scene(CLI::App& command, CommonOptions& options, fs::path& scene) {
  add_value(command, "scene", scene, "SCENE", "scene file (TOML, docs/scenes.md)")->required();
  add_overrides(command, options);
}

void add_terminal(CLI::App& command, bool& pty) {
  command.add_flag("--pty", pty,
                   "on a new pseudo-terminal, whose path is the first line of output");
}

std::unique_ptr<device::PtyLink> open_terminal() {
  auto link = std::make_unique<device::PtyLink>();
  std::printf("%s\n", link->path().c_str());
  std::fflush(stdout);
  return link;
}

int serve_device(const std::function<void()>& serve) {
  std::signal(SIGPIPE, SIG_IGN);  // a closed reader then causes a failed write
  try {
    serve();
  } catch (const InputError& problem) {
    if (!interrupted) { throw; }  // main() takes errors after Ctrl-C for its consequences
    std::fprintf(stderr, "palpate: %s\n", io::printable(problem.what()).c_str());
    return bad_input;
  } catch (const std::system_error& problem) {
    std::fprintf(stderr, "palpate: %s; this machine must offer it\n", problem.what());
    return machine_cannot;
  }
  return interrupted ? interrupted_code : done;
}

std::string integrator_help() {
  std::string text = "Integrators:\n";
  const auto add = [&text](std::string name, std::string_view summary) {
    name.resize(26, ' ');
    text += "  " + name + std::string(summary) + "\n";
  };
  for (const IntegratorInfo* info : integrators()) { add(std::string(info->name), info->summary); }
  add("auto", "chosen for the scene; `palpate inspect` shows which and why");
  return text;
}

std::string in_shell_quotes(const std::string& word) {
  constexpr const char* plain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=+%,:";
  if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) { return word; }
  std::string text = "'";
  for (const char c : word) { text += c == '\'' ? "'\\''" : std::string(1, c); }
  return text + "'";
}

std::string processor_line(const std::string& name) {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    const std::size_t colon = line.find(':');
    if (!line.starts_with(name) || colon == std::string::npos) { continue; }
    const std::size_t begin = line.find_first_not_of(' ', colon + 1);
    return begin == std::string::npos ? "" : line.substr(begin);
  }
  return {};
}

std::map<std::string, std::string> build_provenance() {
  const std::string processor = processor_line("model name");
  return {
      {"version", build::version},
      {"commit", build::commit},
      {"compiler", std::string("g++ ") + __VERSION__},
      {"flags", PALPATE_FLAGS},
      {"processor", (processor.empty() ? "unknown" : processor) + ", " +
                        std::to_string(std::thread::hardware_concurrency()) + " hardware threads"},
      {"date", utc_text(std::time(nullptr))}};
}

std::string printable_lines(const std::string& text) {
  std::string result;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) { result += io::printable(line) + "\n"; }
  return result;
}

std::string version_text() {
  return std::string("palpate ") + build::version + " (" + build::commit + ")";
}

std::string reproducible(const CLI::App& command) {
  constexpr std::array<std::string_view, 10> without_effect{
      "--out",   "--quiet", "--verbose", "--json",  "--jobs",
      "--cache", "--data",  "--history", "--slack", "--shard"};
  const CLI::App* parent = command.get_parent();
  const bool nested = parent != nullptr && parent->get_parent() != nullptr;
  std::string text = "palpate " + (nested ? parent->get_name() + " " : "") + command.get_name();
  for (const CLI::Option* option : command.get_options()) {
    const std::string name = option->get_name();
    if (option->count() == 0 || std::ranges::count(without_effect, name) > 0) { continue; }
    for (const std::string& value : option->results()) {
      if (option->nonpositional()) { text += " " + name; }
      if (option->get_items_expected_max() > 0) { text += " " + in_shell_quotes(value); }
    }
  }
  return text;
}

}  // namespace palpate::cli
