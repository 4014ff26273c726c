// SPDX-License-Identifier: MIT

#include "reports/subject/connection.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <fcntl.h>
#include <poll.h>
#include <stdexcept>
#include <string_view>
#if __has_include(<linux/landlock.h>)
#include <linux/landlock.h>
#endif
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <thread>
#include <type_traits>
#include <unistd.h>
#include <vector>

#include "fixtures/io/csv_file.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "model/problem/input_error.hpp"
#include "reports/timing/child_process.hpp"
#include "validation/number_text.hpp"

namespace palpate {

namespace {

// Frames of the pipe (palpate_subject.h): bytes in and out.

static_assert(std::endian::native == std::endian::little, "frames are written as they are");

struct FrameHeader {
  std::uint32_t length = 0;
  std::uint16_t call = 0;
  std::uint16_t status = 0;
  std::uint64_t sequence = 0;
};
static_assert(sizeof(FrameHeader) == 16);

/// Payloads above this size are refused: a state of 20 million nodes.
constexpr std::uint32_t most_payload = 1U << 30U;
constexpr std::size_t most_nodes = most_payload / (6 * sizeof(double));

/// Longest message of a subject that is shown [bytes].
constexpr std::size_t longest_reason = 2048;

/// Payload under construction, kept between frames so that it allocates once.
class FrameWriter {
 public:
  void clear() { bytes_.clear(); }
  template <class T>
  requires std::is_trivially_copyable_v<T>
  void add(const T& value) {
    const auto* first = reinterpret_cast<const char*>(&value);
    bytes_.insert(bytes_.end(), first, first + sizeof(T));
  }
  void add(const double* values, std::size_t count) {
    const auto* first = reinterpret_cast<const char*>(values);
    bytes_.insert(bytes_.end(), first, first + count * sizeof(double));
  }
  /// Adds numbers that are not a number, for the caller to fill. The payload must be empty.
  double* add_numbers(std::size_t count) {
    bytes_.resize(count * sizeof(double));
    auto* first = reinterpret_cast<double*>(bytes_.data());
    std::fill_n(first, count, std::numeric_limits<double>::quiet_NaN());
    return first;
  }
  void add_text(std::string_view text) {
    add(static_cast<std::uint32_t>(text.size()));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
  }
  [[nodiscard]] const std::vector<char>& bytes() const { return bytes_; }

 private:
  std::vector<char> bytes_{};
};

/// Receives a payload, which may be shorter than its header says: memory grows with what arrives.
/// `receive` reads the bytes of one part, or returns false.
template <class Receive>
bool receive_payload(std::vector<char>& payload, std::size_t size, Receive receive) {
  constexpr std::size_t first_part = 1U << 20U;
  payload.clear();
  while (payload.size() < size) {
    const std::size_t before = payload.size();
    payload.resize(std::min(size, std::max(first_part, 2 * before)));
    if (!receive(payload.data() + before, payload.size() - before)) { return false; }
  }
  return true;
}

/// Reader of a payload. Throws std::length_error beyond its end.
class FrameReader {
 public:
  explicit FrameReader(const std::vector<char>& bytes) : bytes_(bytes) {}

  template <class T>
  requires std::is_trivially_copyable_v<T> T take() {
    T value;
    std::memcpy(&value, next(sizeof(T)), sizeof(T));
    return value;
  }
  void take_bytes(void* to, std::size_t size) { std::memcpy(to, next(size), size); }
  void take(double* values, std::size_t count) {
    if (count > 0) { std::memcpy(values, next(count * sizeof(double)), count * sizeof(double)); }
  }
  std::string take_text() {
    const auto size = take<std::uint32_t>();
    return {next(size), size};
  }
  [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }

 private:
  const char* next(std::size_t size) {
    if (size > left()) { throw std::length_error("the frame is too short"); }
    const char* first = bytes_.data() + at_;
    at_ += size;
    return first;
  }
  const std::vector<char>& bytes_;
  std::size_t at_ = 0;
};

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

std::string call_name(int call) {
  constexpr std::array names{"?",      "hello",     "load",         "reset",
                             "step",   "get_state", "set_state",    "set_parameter",
                             "energy", "close",     "an empty call"};
  return names[static_cast<std::size_t>(std::clamp(call, 0, 10))];
}

/// Throws for every status but OK and DIVERGED.
void check(int status, int call, const std::string& text) {
  if (status == PALPATE_OK || (status == PALPATE_DIVERGED && call == PALPATE_CALL_STEP)) { return; }
  const std::string why = text.empty() ? "" : ": " + io::printable(text);
  if (status == PALPATE_UNSUPPORTED) {
    throw CannotDo("the subject answers \"unsupported\" to " + call_name(call) + why);
  }
  if (status == PALPATE_FAILED || status == PALPATE_DIVERGED) {
    throw SubjectFailure("the subject failed in " + call_name(call) + why);
  }
  throw SubjectFailure("the subject answered " + call_name(call) + " with status " +
                       std::to_string(status) + "; allowed are 0 to 3");
}

std::string text_of(const char* text) { return text != nullptr ? text : ""; }

/// A library in this process.
class LibraryConnection final : public Connection {
 public:
  explicit LibraryConnection(const palpate_subject_api& api) : api_(api) {
    facts_ = {.name = text_of(api.name),
              .version = text_of(api.version),
              .licence = text_of(api.licence),
              .parameters = text_of(api.parameters),
              .carrier = "shared library in process",
              .capabilities = api.capabilities};
  }
  ~LibraryConnection() override { destroy(); }
  LibraryConnection(const LibraryConnection&) = delete;
  LibraryConnection& operator=(const LibraryConnection&) = delete;

  void load(const std::filesystem::path& folder, const std::string& options) override {
    destroy();
    std::array<char, 512> error{};
    const int status =
        api_.load(folder.c_str(), options.c_str(), &subject_, error.data(), error.size());
    error.back() = '\0';
    load_error_ = error.data();
    last_status_ = status;
    check(status, PALPATE_CALL_LOAD, load_error_);
    if (subject_ == nullptr) {
      last_status_ = PALPATE_FAILED;
      load_error_ = "it returned a null pointer";
      check(PALPATE_FAILED, PALPATE_CALL_LOAD, load_error_);
    }
  }
  void reset(std::uint64_t seed) override {
    check(last_status_ = api_.reset != nullptr ? api_.reset(subject_, seed) : PALPATE_UNSUPPORTED,
          PALPATE_CALL_RESET, {});
  }
  bool step(double time, double dt, const palpate_tool_input* input, palpate_tool_output* output,
            double& seconds) override {
    const auto begin = Clock::now();
    const int status = api_.step(subject_, time, dt, input, output);
    seconds = seconds_since(begin);
    last_status_ = status;
    check(status, PALPATE_CALL_STEP, {});
    return status == PALPATE_DIVERGED;
  }
  void get_state(double* position, double* velocity, std::size_t nodes) override {
    check(last_status_ = api_.get_state != nullptr
                             ? api_.get_state(subject_, position, velocity, nodes)
                             : PALPATE_UNSUPPORTED,
          PALPATE_CALL_GET_STATE, {});
  }
  void set_state(const double* position, const double* velocity, std::size_t nodes) override {
    check(last_status_ = api_.set_state != nullptr
                             ? api_.set_state(subject_, position, velocity, nodes)
                             : PALPATE_UNSUPPORTED,
          PALPATE_CALL_SET_STATE, {});
  }
  void set_parameter(const std::string& name, double value) override {
    check(last_status_ = api_.set_parameter != nullptr
                             ? api_.set_parameter(subject_, name.c_str(), value)
                             : PALPATE_UNSUPPORTED,
          PALPATE_CALL_SET_PARAMETER, {});
  }
  void energy(double joule[3]) override {
    check(
        last_status_ = api_.energy != nullptr ? api_.energy(subject_, joule) : PALPATE_UNSUPPORTED,
        PALPATE_CALL_ENERGY, {});
  }
  void close() override { destroy(); }
  /// Returns the status that the library gave to the last call.
  [[nodiscard]] int last_status() const { return last_status_; }
  /// Returns what the library said about the last load.
  [[nodiscard]] const std::string& load_error() const { return load_error_; }

 private:
  void destroy() {
    if (subject_ != nullptr) { api_.destroy(subject_); }
    subject_ = nullptr;
  }

  const palpate_subject_api& api_;
  palpate_subject* subject_ = nullptr;
  std::string load_error_{};
  int last_status_ = PALPATE_OK;
};

/// Landlock ruleset for a child process: files can be read and removed everywhere but in hidden
/// folders. Landlock has no exceptions, so on the way from the root to a hidden folder every
/// neighbour is allowed by itself. Files that appear later beside a hidden folder or beside its
/// parents cannot be read either; the scratch folder can. A hidden folder that could be renamed
/// would be read by the next child, so neither it nor a parent can be removed or renamed.
class ReadBarrier {
 public:
  ReadBarrier(const std::vector<std::filesystem::path>& hidden,
              const std::vector<std::filesystem::path>& readable) {
    if (hidden.empty()) { return; }
#ifdef LANDLOCK_ACCESS_FS_READ_FILE
    const landlock_ruleset_attr handled{.handled_access_fs = rights};
    // Every version of Landlock has these rights; later members of the struct stay out.
    rules_ = static_cast<int>(
        syscall(SYS_landlock_create_ruleset, &handled, sizeof handled.handled_access_fs, 0));
#endif
    if (rules_ < 0) {
      state_ = "the subject could read references and results: the kernel has no Landlock";
      return;
    }
    for (const std::filesystem::path& folder : hidden) {
      hidden_.push_back(std::filesystem::weakly_canonical(std::filesystem::absolute(folder)));
    }
    allow_around("/");
    for (const std::filesystem::path& path : readable) { allow(path); }
    state_ = "confined";
  }
  ~ReadBarrier() {
    if (rules_ >= 0) { ::close(rules_); }
  }
  ReadBarrier(const ReadBarrier&) = delete;
  ReadBarrier& operator=(const ReadBarrier&) = delete;

  [[nodiscard]] const std::string& state() const { return state_; }
  /// Confines the calling process; safe after fork. Returns false if the kernel refuses.
  [[nodiscard]] bool enter() const {
#ifdef LANDLOCK_ACCESS_FS_READ_FILE
    return rules_ < 0 || (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
                          syscall(SYS_landlock_restrict_self, rules_, 0) == 0);
#else
    return true;
#endif
  }

 private:
#ifdef LANDLOCK_ACCESS_FS_READ_FILE
  static constexpr std::uint64_t rights =
      LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_REMOVE_FILE | LANDLOCK_ACCESS_FS_REMOVE_DIR;
#endif
  void allow(const std::filesystem::path& path) {
#ifdef LANDLOCK_ACCESS_FS_READ_FILE
    const int file = open(path.c_str(), O_PATH | O_CLOEXEC);
    if (file < 0) { return; }
    struct stat status {};
    // A file has no entries to remove.
    const bool folder = fstat(file, &status) == 0 && S_ISDIR(status.st_mode);
    const landlock_path_beneath_attr rule{
        .allowed_access = folder ? rights : std::uint64_t{LANDLOCK_ACCESS_FS_READ_FILE},
        .parent_fd = file};
    syscall(SYS_landlock_add_rule, rules_, LANDLOCK_RULE_PATH_BENEATH, &rule, 0);
    ::close(file);
#endif
  }
  /// `folder` is a parent of a hidden folder.
  void allow_around(const std::filesystem::path& folder) {
    std::error_code problem;
    for (std::filesystem::directory_iterator each(folder, problem), end; each != end;
         each.increment(problem)) {
      const std::filesystem::path& path = each->path();
      if (each->is_symlink(problem)) { continue; }  // its target has a rule of its own
      const auto inside = [&path](const std::filesystem::path& one) {
        return std::mismatch(path.begin(), path.end(), one.begin(), one.end()).first == path.end();
      };
      if (std::ranges::find(hidden_, path) != hidden_.end()) { continue; }
      std::ranges::any_of(hidden_, inside) ? allow_around(path) : allow(path);
    }
  }

  std::vector<std::filesystem::path> hidden_{};
  std::string state_{};
  int rules_ = -1;
};

/// Name of a signal: "SIGSEGV".
std::string signal_text(int signal) {
  const char* name = sigabbrev_np(signal);
  return "signal " + std::to_string(signal) +
         (name != nullptr ? " (SIG" + std::string(name) + ")" : "");
}

/// Program in a child process that answers frames.
class PipeConnection final : public Connection {
 public:
  /// `words` is the program with its arguments.
  PipeConnection(std::vector<std::string> words, std::string carrier, bool host,
                 const SubjectLimits& limits)
      : limits_(limits), host_(host) {
    if (*limits_.timeouts >= SubjectLimits::most_timeouts) {
      throw SubjectFailure(
          "the subject is not started again: " + std::to_string(SubjectLimits::most_timeouts) +
          " calls had no answer within their time limit, which "
          "--subject-time-limit sets");
    }
    start(std::move(words));
    writer_.clear();
    writer_.add(static_cast<std::uint32_t>(PALPATE_SUBJECT_ABI));
    FrameReader answer = exchange(PALPATE_CALL_HELLO, limits_.load_seconds());
    const auto abi = taken<std::uint32_t>(answer, PALPATE_CALL_HELLO);
    if (abi != PALPATE_SUBJECT_ABI) {
      fail("speaks version " + std::to_string(abi) +
           " of the interface; this program has version " + std::to_string(PALPATE_SUBJECT_ABI));
    }
    try {
      facts_.capabilities = answer.take<std::uint64_t>();
      for (std::string* text :
           {&facts_.name, &facts_.version, &facts_.licence, &facts_.parameters}) {
        *text = io::shown(answer.take_text());
      }
    } catch (const std::length_error&) { fail("gave an answer to hello that is too short"); }
    must_end(answer, PALPATE_CALL_HELLO);
    facts_.carrier = std::move(carrier);
  }
  ~PipeConnection() override { stop(); }
  PipeConnection(const PipeConnection&) = delete;
  PipeConnection& operator=(const PipeConnection&) = delete;

  void load(const std::filesystem::path& folder, const std::string& options) override {
    writer_.clear();
    writer_.add_text(std::filesystem::absolute(folder).string());
    writer_.add_text(options);
    must_end(exchange(PALPATE_CALL_LOAD, limits_.load_seconds()), PALPATE_CALL_LOAD);
  }
  void reset(std::uint64_t seed) override {
    writer_.clear();
    writer_.add(seed);
    must_end(exchange(PALPATE_CALL_RESET, limits_.load_seconds()), PALPATE_CALL_RESET);
  }
  bool step(double time, double dt, const palpate_tool_input* input, palpate_tool_output* output,
            double& seconds) override {
    writer_.clear();
    writer_.add(time);
    writer_.add(dt);
    writer_.add(static_cast<std::uint32_t>(input != nullptr ? 1 : 0));
    if (input != nullptr) { writer_.add(*input); }
    const auto begin = Clock::now();
    FrameReader answer = exchange(PALPATE_CALL_STEP, limits_.call_seconds);
    seconds = seconds_since(begin);
    if (status_ == PALPATE_DIVERGED && answer.left() == 0) { return true; }
    const auto inside = taken<double>(answer, PALPATE_CALL_STEP);
    if (host_) { seconds = inside; }
    if (input != nullptr && output != nullptr) {
      constexpr std::size_t without_depth = offsetof(palpate_tool_output, depth);
      *output = empty_output();
      if (answer.left() == without_depth) {
        answer.take_bytes(output, without_depth);
      } else {
        *output = taken<palpate_tool_output>(answer, PALPATE_CALL_STEP);
      }
    }
    must_end(answer, PALPATE_CALL_STEP);
    return status_ == PALPATE_DIVERGED;
  }
  void get_state(double* position, double* velocity, std::size_t nodes) override {
    writer_.clear();
    writer_.add(static_cast<std::uint64_t>(nodes));
    FrameReader answer = exchange(PALPATE_CALL_GET_STATE, limits_.call_seconds);
    if (answer.left() != 6 * nodes * sizeof(double)) {
      fail("answered get_state with " + std::to_string(answer.left()) + " bytes; must be " +
           std::to_string(6 * nodes * sizeof(double)) + " for " + std::to_string(nodes) + " nodes");
    }
    answer.take(position, 3 * nodes);
    answer.take(velocity, 3 * nodes);
  }
  void set_state(const double* position, const double* velocity, std::size_t nodes) override {
    writer_.clear();
    writer_.add(static_cast<std::uint64_t>(nodes));
    writer_.add(position, 3 * nodes);
    writer_.add(velocity, 3 * nodes);
    must_end(exchange(PALPATE_CALL_SET_STATE, limits_.call_seconds), PALPATE_CALL_SET_STATE);
  }
  void set_parameter(const std::string& name, double value) override {
    writer_.clear();
    writer_.add_text(name);
    writer_.add(value);
    must_end(exchange(PALPATE_CALL_SET_PARAMETER, limits_.call_seconds),
             PALPATE_CALL_SET_PARAMETER);
  }
  void energy(double joule[3]) override {
    writer_.clear();
    FrameReader answer = exchange(PALPATE_CALL_ENERGY, limits_.call_seconds);
    for (int n = 0; n < 3; ++n) { joule[n] = taken<double>(answer, PALPATE_CALL_ENERGY); }
    must_end(answer, PALPATE_CALL_ENERGY);
  }
  void close() override {
    writer_.clear();
    must_end(exchange(PALPATE_CALL_CLOSE, limits_.load_seconds()), PALPATE_CALL_CLOSE);
  }
  double round_trip() override {
    writer_.clear();
    const auto begin = Clock::now();
    must_end(exchange(PALPATE_CALL_EMPTY, limits_.call_seconds), PALPATE_CALL_EMPTY);
    return seconds_since(begin);
  }
  [[nodiscard]] std::size_t resident_bytes() const override {
    std::array<char, 64> path{};
    std::snprintf(path.data(), path.size(), "/proc/%d/statm", static_cast<int>(child_));
    const int file = open(path.data(), O_RDONLY | O_CLOEXEC);
    if (file < 0) { return 0; }
    std::array<char, 128> text{};
    const ssize_t size = read(file, text.data(), text.size() - 1);
    ::close(file);
    long all = 0;
    long resident = 0;
    if (size <= 0 || std::sscanf(text.data(), "%ld %ld", &all, &resident) != 2) { return 0; }
    return static_cast<std::size_t>(resident) * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  }

 private:
  void start(std::vector<std::string> words) {
    // A write to a child that ended must be an error here, not the end of this program.
    std::signal(SIGPIPE, SIG_IGN);
    std::array<int, 2> to{-1, -1};
    std::array<int, 2> from{-1, -1};
    errors_ = memfd_create("palpate-subject-errors", MFD_CLOEXEC);
    const bool open = errors_ >= 0 && fcntl(errors_, F_SETFL, O_APPEND) == 0 &&
                      pipe2(to.data(), O_CLOEXEC) == 0 && pipe2(from.data(), O_CLOEXEC) == 0;
    if (!open) {
      throw SubjectFailure(std::string("no pipe to the subject: ") + std::strerror(errno));
    }
    std::vector<char*> arguments;
    for (std::string& word : words) { arguments.push_back(word.data()); }
    arguments.push_back(nullptr);
    std::vector<std::filesystem::path> readable{scratch()};
    if (host_) { readable.emplace_back(words.back()); }
    const ReadBarrier barrier(limits_.hidden, readable);
    facts_.confinement = barrier.state();
    const std::string temporary = "TMPDIR=" + scratch().string();
    std::vector<char*> variables{const_cast<char*>(temporary.c_str())};
    for (char** each = environ; *each != nullptr; ++each) {
      if (!std::string_view(*each).starts_with("TMPDIR=")) { variables.push_back(*each); }
    }
    variables.push_back(nullptr);
    child_ = fork();
    if (child_ == 0) {
      // Only calls that are safe after fork in a program with threads.
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      setpgid(0, 0);
      std::signal(SIGPIPE, SIG_DFL);
      dup2(to[0], STDIN_FILENO);
      dup2(from[1], STDOUT_FILENO);
      dup2(errors_, STDERR_FILENO);
      if (!barrier.enter()) { _exit(126); }
      execvpe(arguments[0], arguments.data(), variables.data());
      _exit(127);
    }
    ::close(to[0]);
    ::close(from[1]);
    to_ = to[1];
    from_ = from[0];
    if (child_ < 0) { throw SubjectFailure("the subject cannot be started: no more processes"); }
  }

  void stop() noexcept {
    if (to_ >= 0) { ::close(to_); }
    if (from_ >= 0) { ::close(from_); }
    to_ = from_ = -1;
    if (child_ > 0) {
      // Its input has ended, which ends a sound subject.
      for (int look = 0; look < 50 && !has_ended(); ++look) {
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
      }
      end_group();
    }
    if (errors_ >= 0) { ::close(errors_); }
    errors_ = -1;
  }

  /// Returns true once the child has ended; leaves its status for waitpid(), which keeps its
  /// number from being given to another process.
  [[nodiscard]] bool has_ended() const noexcept {
    siginfo_t info{};
    return waitid(P_PID, static_cast<id_t>(child_), &info, WEXITED | WNOHANG | WNOWAIT) != 0 ||
           info.si_pid != 0;
  }
  /// Ends the child and every process that it has started and that is still in its group. Returns
  /// the status of the child.
  int end_group() noexcept {
    int status = 0;
    // Before the child has a group of its own it is reached alone.
    if (kill(-child_, SIGKILL) != 0) { kill(child_, SIGKILL); }
    waitpid(child_, &status, 0);
    child_ = -1;
    return status;
  }

  [[noreturn]] void fail(const std::string& why) {
    if (child_ > 0) { end_group(); }
    failed_ = "the subject " + why + last_words();
    throw SubjectFailure(failed_);
  }

  /// Last line that the child wrote to standard error, as the end of a message.
  [[nodiscard]] std::string last_words() const {
    const off_t size = lseek(errors_, 0, SEEK_END);
    std::array<char, longest_reason> text{};
    const off_t begin = std::max<off_t>(0, size - static_cast<off_t>(text.size()));
    const ssize_t count = pread(errors_, text.data(), text.size(), begin);
    std::string_view all(text.data(), static_cast<std::size_t>(std::max<ssize_t>(0, count)));
    while (!all.empty() && (all.back() == '\n' || all.back() == '\r')) { all.remove_suffix(1); }
    if (all.empty()) { return {}; }
    const auto line = all.rfind('\n');
    return "; its last message: " + io::printable(line == all.npos ? all : all.substr(line + 1));
  }

  /// Ends with the reason why the child closed its pipe.
  [[noreturn]] void fail_ended(int call) {
    for (int look = 0; look < 100 && !has_ended(); ++look) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    const std::string where = " in " + call_name(call);
    if (!has_ended()) { fail("closed its output" + where); }
    const int status = end_group();
    if (WIFSIGNALED(status)) { fail("was killed by " + signal_text(WTERMSIG(status)) + where); }
    if (WEXITSTATUS(status) == 127) {
      fail(host_ ? "did not start: palpate-subject-host, which loads it, cannot be run"
                 : "did not start: the command was not found, or cannot be run");
    }
    fail("ended with exit code " + std::to_string(WEXITSTATUS(status)) + where);
  }

  void wait_for(int file, short event, Clock::time_point until, int call) {
    for (;;) {
      pollfd one{.fd = file, .events = event, .revents = 0};
      const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now());
      const int wait = static_cast<int>(std::clamp<long>(left.count() + 1, 0, 100));
      const int ready = poll(&one, 1, wait);
      if (ready > 0) { return; }
      if (ready < 0 && errno != EINTR) {
        fail(std::string("cannot be reached, poll: ") + std::strerror(errno));
      }
      check_memory();
      if (limits_.stop != nullptr && limits_.stop->load()) { fail("was interrupted"); }
      if (Clock::now() >= until) {
        ++*limits_.timeouts;
        fail(std::string(has_ended() ? "ended, left a process that holds its output, and " : "") +
             "gave no answer to " + call_name(call) + " within the time limit of " +
             plain_number(limit_) + " s");
      }
    }
  }
  /// Also forgets the messages of the child once they are long.
  void check_memory() {
    constexpr off_t most_messages = 1 << 20;  // [bytes]
    if (lseek(errors_, 0, SEEK_END) > most_messages) { (void)ftruncate(errors_, 0); }
    if (static_cast<double>(resident_bytes()) > 1048576.0 * limits_.memory_mib) {
      fail("uses more memory than the limit of " + plain_number(limits_.memory_mib, 6) + " MiB");
    }
  }

  void send(const char* bytes, std::size_t size, Clock::time_point until, int call) {
    while (size > 0) {
      wait_for(to_, POLLOUT, until, call);
      const ssize_t sent = write(to_, bytes, std::min<std::size_t>(size, 65536));
      if (sent < 0 && errno == EPIPE) { fail_ended(call); }
      if (sent < 0 && errno != EINTR) {
        fail(std::string("cannot be reached, write: ") + std::strerror(errno));
      }
      if (sent > 0) {
        bytes += sent;
        size -= static_cast<std::size_t>(sent);
      }
    }
  }
  void receive(char* bytes, std::size_t size, Clock::time_point until, int call) {
    while (size > 0) {
      wait_for(from_, POLLIN, until, call);
      const ssize_t got = read(from_, bytes, size);
      if (got == 0) { fail_ended(call); }
      if (got < 0 && errno != EINTR) {
        fail(std::string("cannot be reached, read: ") + std::strerror(errno));
      }
      if (got > 0) {
        bytes += got;
        size -= static_cast<std::size_t>(got);
      }
    }
  }

  /// Sends the payload of `writer_` and returns the answer's.
  FrameReader exchange(int call, double limit) {
    if (!failed_.empty()) { throw SubjectFailure(failed_); }
    limit_ = limit;
    const auto until = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                          std::chrono::duration<double>(limit));
    const FrameHeader request{.length = static_cast<std::uint32_t>(writer_.bytes().size()),
                              .call = static_cast<std::uint16_t>(call),
                              .sequence = ++sequence_};
    // One write for a small request: it wakes the child once.
    request_.resize(sizeof request);
    std::memcpy(request_.data(), &request, sizeof request);
    request_.insert(request_.end(), writer_.bytes().begin(), writer_.bytes().end());
    send(request_.data(), request_.size(), until, call);
    FrameHeader answer;
    receive(reinterpret_cast<char*>(&answer), sizeof answer, until, call);
    if (answer.call != call || answer.sequence != sequence_ || answer.length > most_payload) {
      fail("answered " + call_name(call) + " with a frame of call " + std::to_string(answer.call) +
           ", sequence " + std::to_string(answer.sequence) + " and " +
           std::to_string(answer.length) + " bytes (\"" +
           io::shown({reinterpret_cast<const char*>(&answer), sizeof answer}) +
           "\"); expected call " + std::to_string(call) + ", sequence " +
           std::to_string(sequence_) + " and at most " + std::to_string(most_payload) +
           " bytes. Standard output must hold frames only");
    }
    receive_payload(answer_, answer.length, [&](char* bytes, std::size_t size) {
      receive(bytes, size, until, call);
      return true;
    });
    if ((sequence_ & 255U) == 0) { check_memory(); }
    status_ = answer.status;
    std::string text;
    if (status_ != PALPATE_OK && !answer_.empty() && call == PALPATE_CALL_LOAD) {
      try {
        text = FrameReader(answer_).take_text().substr(0, longest_reason);
      } catch (const std::length_error&) { fail("gave an answer to load that is too short"); }
    }
    try {
      check(status_, call, text);
    } catch (const SubjectFailure& problem) {
      if (!text.empty()) { throw; }
      throw SubjectFailure(problem.what() + last_words());
    }
    return FrameReader(answer_);
  }

  template <class T> T taken(FrameReader& answer, int call) {
    try {
      return answer.take<T>();
    } catch (const std::length_error&) {
      fail("gave an answer to " + call_name(call) + " that is too short");
    }
  }

  /// Fails if an answer has more than was taken from it.
  void must_end(const FrameReader& answer, int call) {
    if (answer.left() == 0) { return; }
    fail("gave an answer to " + call_name(call) + " that is " + std::to_string(answer.left()) +
         " bytes too long");
  }

  SubjectLimits limits_;
  bool host_;
  pid_t child_ = -1;
  int to_ = -1;
  int from_ = -1;
  int errors_ = -1;
  double limit_ = 0.0;
  int status_ = 0;
  std::uint64_t sequence_ = 0;
  std::string failed_{};
  FrameWriter writer_{};
  std::vector<char> request_{};
  std::vector<char> answer_{};
};

bool read_all(int file, char* bytes, std::size_t size) {
  while (size > 0) {
    const ssize_t got = read(file, bytes, size);
    if (got == 0 || (got < 0 && errno != EINTR)) { return false; }
    if (got > 0) {
      bytes += got;
      size -= static_cast<std::size_t>(got);
    }
  }
  return true;
}
bool write_all(int file, const char* bytes, std::size_t size) {
  while (size > 0) {
    const ssize_t sent = write(file, bytes, size);
    if (sent < 0 && errno != EINTR) { return false; }
    if (sent > 0) {
      bytes += sent;
      size -= static_cast<std::size_t>(sent);
    }
  }
  return true;
}

/// One call of a library from its payload. Returns the status; the answer is written to `answer`.
int answer_call(LibraryConnection& library, int call, FrameReader request, FrameWriter& answer,
                std::vector<double>& state) {
  switch (call) {
    case PALPATE_CALL_HELLO: {
      const SubjectFacts& facts = library.facts();
      answer.add(static_cast<std::uint32_t>(PALPATE_SUBJECT_ABI));
      answer.add(facts.capabilities);
      for (const std::string& text : {facts.name, facts.version, facts.licence, facts.parameters}) {
        answer.add_text(text);
      }
      return PALPATE_OK;
    }
    case PALPATE_CALL_LOAD: {
      const std::string folder = request.take_text();
      library.load(folder, request.take_text());
      return PALPATE_OK;
    }
    case PALPATE_CALL_RESET: library.reset(request.take<std::uint64_t>()); return PALPATE_OK;
    case PALPATE_CALL_STEP: {
      const auto time = request.take<double>();
      const auto dt = request.take<double>();
      const bool tool = request.take<std::uint32_t>() != 0;
      const palpate_tool_input input =
          tool ? request.take<palpate_tool_input>() : palpate_tool_input{};
      palpate_tool_output output = empty_output();
      double seconds = 0.0;
      const bool diverged =
          library.step(time, dt, tool ? &input : nullptr, tool ? &output : nullptr, seconds);
      answer.add(seconds);
      if (tool) { answer.add(output); }
      return diverged ? PALPATE_DIVERGED : PALPATE_OK;
    }
    case PALPATE_CALL_GET_STATE: {
      const auto nodes = static_cast<std::size_t>(request.take<std::uint64_t>());
      if (nodes > most_nodes) { return PALPATE_FAILED; }
      double* position = answer.add_numbers(6 * nodes);
      library.get_state(position, position + 3 * nodes, nodes);
      return PALPATE_OK;
    }
    case PALPATE_CALL_SET_STATE: {
      const auto nodes = static_cast<std::size_t>(request.take<std::uint64_t>());
      if (nodes > most_nodes || request.left() != 6 * nodes * sizeof(double)) {
        return PALPATE_FAILED;
      }
      state.resize(6 * nodes);
      request.take(state.data(), state.size());
      library.set_state(state.data(), state.data() + 3 * nodes, nodes);
      return PALPATE_OK;
    }
    case PALPATE_CALL_SET_PARAMETER: {
      const std::string name = request.take_text();
      library.set_parameter(name, request.take<double>());
      return PALPATE_OK;
    }
    case PALPATE_CALL_ENERGY: {
      std::array<double, 3> joule{};
      library.energy(joule.data());
      answer.add(joule.data(), joule.size());
      return PALPATE_OK;
    }
    case PALPATE_CALL_CLOSE: library.close(); return PALPATE_OK;
    case PALPATE_CALL_EMPTY: return PALPATE_OK;
    default: return PALPATE_UNSUPPORTED;
  }
}

}  // namespace

const palpate_subject_api& open_library(const std::filesystem::path& path) {
  const std::string file = path.string();
  void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    throw InputError(file + ": cannot be loaded: " + io::printable(text_of(dlerror())));
  }
  const auto function =
      reinterpret_cast<palpate_subject_api_function>(dlsym(library, "palpate_subject_api_v1"));
  if (function == nullptr) {
    throw InputError(file +
                     ": no function palpate_subject_api_v1; a subject exports it "
                     "(palpate_subject.h)");
  }
  const palpate_subject_api* api = function();
  if (api == nullptr) { throw InputError(file + ": palpate_subject_api_v1 returned null"); }
  if (api->abi != PALPATE_SUBJECT_ABI || api->size < sizeof(palpate_subject_api)) {
    throw InputError(file + ": version " + std::to_string(api->abi) +
                     " of the interface, table of " + std::to_string(api->size) +
                     " bytes; must be version " + std::to_string(PALPATE_SUBJECT_ABI) + " of " +
                     std::to_string(sizeof(palpate_subject_api)) + " bytes");
  }
  if (api->load == nullptr || api->step == nullptr || api->destroy == nullptr) {
    throw InputError(file + ": load, step or destroy is null; a subject must have all three");
  }
  return *api;
}

int serve_library(const palpate_subject_api& api, int input, int output) {
  LibraryConnection library(api);
  FrameHeader header;
  std::vector<char> request;
  std::vector<char> bytes;
  std::vector<double> state;
  FrameWriter answer;
  while (read_all(input, reinterpret_cast<char*>(&header), sizeof header)) {
    if (header.length > most_payload) { return 2; }
    const auto receive = [input](char* part, std::size_t size) {
      return read_all(input, part, size);
    };
    if (!receive_payload(request, header.length, receive)) { return 2; }
    answer.clear();
    int status = PALPATE_OK;
    bool refused = true;
    try {
      status = answer_call(library, header.call, FrameReader(request), answer, state);
      refused = false;
    } catch (const CannotDo&) { status = library.last_status(); } catch (const SubjectFailure&) {
      status = library.last_status();
    } catch (const std::exception& problem) {
      std::fprintf(stderr, "%s\n", problem.what());  // the last words of the subject
      status = PALPATE_FAILED;
    }
    if (refused) {
      answer.clear();
      if (header.call == PALPATE_CALL_LOAD) { answer.add_text(library.load_error()); }
    }
    const FrameHeader out{.length = static_cast<std::uint32_t>(answer.bytes().size()),
                          .call = header.call,
                          .status = static_cast<std::uint16_t>(status),
                          .sequence = header.sequence};
    // One write for a small answer: it wakes the other end once.
    constexpr std::size_t small = 1U << 16U;
    const std::vector<char>& payload = answer.bytes();
    const std::size_t together = payload.size() <= small ? payload.size() : 0;
    bytes.resize(sizeof out);
    std::memcpy(bytes.data(), &out, sizeof out);
    bytes.insert(bytes.end(), payload.begin(), payload.begin() + static_cast<long>(together));
    if (!write_all(output, bytes.data(), bytes.size()) ||
        !write_all(output, payload.data() + together, payload.size() - together)) {
      return 2;
    }
  }
  return 0;
}

namespace {

/// Returns palpate-subject-host beside the running program, or above it (programs of tests).
std::filesystem::path host_program() {
  constexpr std::string_view name = "palpate-subject-host";
  std::filesystem::path folder = timing::own_program().parent_path();
  for (int up = 0; up < 3; ++up, folder = folder.parent_path()) {
    if (std::filesystem::exists(folder / name)) { return folder / name; }
  }
  throw InputError(std::string(name) + ": not beside the program; it must be installed with it");
}

}  // namespace

std::unique_ptr<Connection> connect_subject(const std::string& subject, bool in_process,
                                            const SubjectLimits& limits) {
  constexpr std::string_view command = "exec:";
  if (subject.starts_with(command)) {
    const std::string line = subject.substr(command.size());
    if (line.empty()) { throw InputError("--subject exec: needs a command, as exec:./simulator"); }
    return std::make_unique<PipeConnection>(
        std::vector<std::string>{"/bin/sh", "-c", "exec " + line}, "pipe", false, limits);
  }
  const std::filesystem::path file = subject;
  if (file.extension() != ".so") {
    const std::string kind = file.extension().string();
    const char* runner = kind == ".py"                     ? "python3 "
                         : kind == ".js" || kind == ".mjs" ? "node "
                         : std::filesystem::exists(file)   ? ""
                                                           : nullptr;
    const std::string near =
        runner == nullptr ? "" : "did you mean \"exec:" + (runner + io::shown(subject)) + "\"? ";
    throw InputError("--subject " + io::shown(subject) + ": unknown; " + near +
                     "model, PATH.so, exec:COMMAND or trace:FILE.csv");
  }
  // dlopen() waits for ever at a FIFO.
  (void)io::open_regular(file, "a shared library");
  const std::filesystem::path path = std::filesystem::absolute(file);
  if (in_process) { return std::make_unique<LibraryConnection>(open_library(path)); }
  return std::make_unique<PipeConnection>(
      std::vector<std::string>{host_program().string(), path.string()}, "shared library", true,
      limits);
}

}  // namespace palpate
