// SPDX-License-Identifier: MIT
#include "reports/cli/stress_ng.hpp"

#include <array>
#include <csignal>
#include <spawn.h>
#include <stdexcept>
#include <sys/wait.h>
#include <unistd.h>

#include "reports/timing/child_process.hpp"

namespace palpate::cli {

bool has_stress_ng() { return !timing::find_program("stress-ng").empty(); }

StressNg::StressNg(const std::vector<int>& processors) {
  std::string list;
  for (const int n : processors) { list += (list.empty() ? "" : ",") + std::to_string(n); }
  std::string workers = std::to_string(processors.size());
  std::string program = "stress-ng";
  std::array<std::string, 13> words{"--quiet", "--taskset", list,   "--cpu", workers,
                                    "--cache", workers,     "--vm", "1",     "--vm-bytes",
                                    "64M",     "--hdd",     "1"};
  std::vector<char*> arguments{program.data()};
  for (std::string& word : words) { arguments.push_back(word.data()); }
  arguments.push_back(nullptr);
  if (posix_spawnp(&process_, program.c_str(), nullptr, nullptr, arguments.data(), environ) != 0) {
    throw std::runtime_error("stress-ng cannot be started");
  }
}

StressNg::~StressNg() {
  kill(process_, SIGTERM);
  waitpid(process_, nullptr, 0);
}

}  // namespace palpate::cli
