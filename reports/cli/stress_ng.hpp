// SPDX-License-Identifier: MIT
#pragma once
/// The program stress-ng as other work on the machine.

#include <string>
#include <vector>

namespace palpate::cli {

/// Whether it is on the search path.
bool has_stress_ng();

/// Runs while this lives: computing, caches, memory and files, on these processors.
class StressNg {
 public:
  /// Throws std::runtime_error where it cannot be started.
  explicit StressNg(const std::vector<int>& processors);
  ~StressNg();
  StressNg(const StressNg&) = delete;
  StressNg& operator=(const StressNg&) = delete;

 private:
  int process_ = -1;
};

}  // namespace palpate::cli
