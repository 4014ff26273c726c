// SPDX-License-Identifier: MIT
#include "reports/cli/provenance.hpp"

#include <array>
#include <ctime>
#include <fstream>
#include <thread>

#include "palpate_version.hpp"

namespace palpate::cli {

namespace {

std::string processor() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) {
      const std::size_t colon = line.find(':');
      return colon == std::string::npos ? line : line.substr(line.find_first_not_of(' ', colon + 1));
    }
  }
  return "unknown";
}

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  std::array<char, 32> buffer{};
  std::strftime(buffer.data(), buffer.size(), "%Y-%m-%dT%H:%M:%SZ", &parts);
  return buffer.data();
}

}  // namespace

std::map<std::string, std::string> build_provenance() {
  return {{"version", build::version},
          {"commit", build::commit},
          {"compiler", std::string("g++ ") + __VERSION__},
          {"flags", PALPATE_FLAGS},
          {"processor", processor() + ", " + std::to_string(std::thread::hardware_concurrency()) +
                            " hardware threads"},
          {"date", utc_now()}};
}

std::string version_text() {
  return std::string("palpate ") + build::version + " (" + build::commit + ")";
}

}  // namespace palpate::cli
