// SPDX-License-Identifier: MIT
#pragma once
/// Connection to a subject: the calls of palpate_subject.h, to a library in this process or to a
/// child process over a pipe.

#include <atomic>
#include <cstddef>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "fixtures/io/file_bytes.hpp"
#include "validation/subject/capabilities.hpp"

namespace palpate {

struct SubjectLimits {
  double call_seconds = 10.0;               ///< of a call; hello, load and reset may take six times
  double memory_mib = 4096.0;               ///< resident memory of the child process [MiB]
  const std::atomic<bool>* stop = nullptr;  ///< ends a call when it becomes true
  /// Counts the calls without an answer in all processes of a run; after `most_timeouts` of them no
  /// further process is started.
  std::shared_ptr<std::atomic<int>> timeouts = std::make_shared<std::atomic<int>>(0);
  /// Folders whose files a child process may not read: references and earlier results.
  std::vector<std::filesystem::path> hidden{};

  static constexpr int most_timeouts = 3;
  [[nodiscard]] double load_seconds() const { return 6.0 * call_seconds; }
};

/// Every call throws SubjectFailure if the subject crashes, exceeds a limit or breaks the protocol,
/// and CannotDo if it answers PALPATE_UNSUPPORTED.
class Connection {
 public:
  virtual ~Connection() = default;
  [[nodiscard]] const SubjectFacts& facts() const { return facts_; }
  /// Returns a folder for files of the subject: the scene folders, and its temporary files.
  [[nodiscard]] const std::filesystem::path& scratch() const { return scratch_.path(); }

  virtual void load(const std::filesystem::path& folder, const std::string& options_json) = 0;
  virtual void reset(std::uint64_t seed) = 0;
  /// Returns true if the state diverged. `seconds` is set to the duration of the step if the
  /// host of a shared library measured it, else to the duration of the whole call [s].
  virtual bool step(double time, double dt, const palpate_tool_input* input,
                    palpate_tool_output* output, double& seconds) = 0;
  virtual void get_state(double* position, double* velocity, std::size_t nodes) = 0;
  virtual void set_state(const double* position, const double* velocity, std::size_t nodes) = 0;
  virtual void set_parameter(const std::string& name, double value) = 0;
  virtual void energy(double joule[3]) = 0;
  /// Destroys the loaded scene; load() may follow.
  virtual void close() = 0;
  /// Returns the duration of an empty call [s]; 0 in process.
  virtual double round_trip() { return 0.0; }
  /// Returns the resident memory of the child process; 0 in process.
  [[nodiscard]] virtual std::size_t resident_bytes() const { return 0; }

 protected:
  SubjectFacts facts_{};

 private:
  io::ScratchFolder scratch_{};
};

/// Returns an output in which every number is NaN.
inline palpate_tool_output empty_output() {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  return {{nan, nan, nan}, nan, nan, nan, nan, nan, nan, nan, nan, nan, 0, 0, nan};
}

/// Connects to PATH.so or exec:COMMAND. A library runs in a child process, palpate-subject-host,
/// unless `in_process`. Throws InputError for an unknown form, a missing file and a library without
/// the function, and SubjectFailure.
std::unique_ptr<Connection> connect_subject(const std::string& subject, bool in_process,
                                            const SubjectLimits& limits = {});

/// Answers frames on two file descriptors with a library, until the input ends. Returns an exit
/// code. Program of palpate-subject-host.
int serve_library(const palpate_subject_api& api, int input, int output);

/// Loads the table of a library. Throws InputError with the reason. `path` must contain a '/'.
const palpate_subject_api& open_library(const std::filesystem::path& path);

}  // namespace palpate
