// SPDX-License-Identifier: MIT

#include "reports/cli/provenance.hpp"

#include <array>
#include <ctime>
#include <fstream>
#include <thread>
#include <time.h>

#include "palpate_version.hpp"

namespace palpate::cli {
namespace {

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  std::array<char, 32> buffer{};
  std::strftime(buffer.data(), buffer.size(), "%Y-%m-%dT%H:%M:%SZ", &parts);
  return buffer.data();
}

}  // namespace

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
      {"date", utc_now()}};
}

std::string version_text() {
  return std::string("palpate ") + build::version + " (" + build::commit + ")";
}

}  // namespace palpate::cli
