// SPDX-License-Identifier: MIT
#pragma once
/// Child processes: other programs or another instance of this program, run to completion.

#include <atomic>
#include <filesystem>
#include <string>
#include <vector>

namespace palpate::timing {

/// Returns the first program with this name on PATH; empty if there is none.
std::filesystem::path find_program(const std::string& name);

/// Returns the path of the running executable.
std::filesystem::path own_program();

struct ChildEnd {
  int status = 0;  ///< exit code, or 128 plus the number of the terminating signal
  std::string output{};
  std::string errors{};
  bool stopped = false;  ///< true if the child was stopped because `stop` became true

  /// Last line of the child's standard error without its prefix, for error messages.
  [[nodiscard]] std::string last_words() const;
};

/// Runs a program. `words` is the path of the program, then its arguments. The child is terminated
/// when this process ends or when `stop` becomes true (nullptr: never); after `stop` the call
/// returns within about a third of a second. Throws std::runtime_error if the child cannot be
/// started.
ChildEnd run_child(const std::vector<std::string>& words, const std::atomic<bool>* stop);

/// Program that runs without output during the lifetime of the object.
class Background {
 public:
  explicit Background(const std::vector<std::string>& words);
  ~Background();
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;

 private:
  int process_;
};

}  // namespace palpate::timing
