// SPDX-License-Identifier: MIT
#pragma once
/// Other programs, and this one once more, run to their end.

#include <atomic>
#include <filesystem>
#include <string>
#include <vector>

namespace palpate::timing {

/// The first of that name that PATH leads to; empty: none.
std::filesystem::path find_program(const std::string& name);

/// The file of the program that runs.
std::filesystem::path own_program();

struct ChildEnd {
  int status = 0;  ///< exit code; 128 and the signal that ended it
  std::string output{};
  std::string errors{};
  bool stopped = false;  ///< since `stop` became true

  /// The last line that it wrote for people, without what stands before; for messages.
  [[nodiscard]] std::string last_words() const;
};

/// `words`: the program's file, then its arguments. The child is told to end when this process
/// does, and when `stop` (nullptr: never) becomes true; nobody waits for it then for longer than a
/// third of a second. Throws std::runtime_error when it cannot be started.
ChildEnd run_child(const std::vector<std::string>& words, const std::atomic<bool>* stop);

}  // namespace palpate::timing
