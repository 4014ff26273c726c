// SPDX-License-Identifier: MIT

#include "reports/cli/provenance.hpp"

#include <algorithm>
#include <array>
#include <ctime>
#include <fstream>
#include <sstream>
#include <sys/utsname.h>
#include <thread>
#include <time.h>
#include <unistd.h>

#include "palpate_version.hpp"

#include "device/real_time.hpp"

#if defined(__x86_64__)
#include <x86intrin.h>
#endif

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

/// Value of a key in /proc/cpuinfo for the first processor; empty if the key is missing.
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

using Value = decltype(EnvironmentFact::value);

/// First line of a file; empty if there is none.
std::string first_line(const std::string& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

Value text(const std::string& found) { return found.empty() ? Value{} : Value{found}; }

/// Reads a file that contains 0 or 1.
Value yes_or_no(const std::string& file, bool yes_is_one = true) {
  const std::string found = first_line(file);
  return found.empty() ? Value{} : Value{(found == "1" || found == "Y") == yes_is_one};
}

bool has_flag(const std::string& flag) {
  std::istringstream flags(processor_line("flags"));
  for (std::string each; flags >> each;) {
    if (each == flag) { return true; }
  }
  return false;
}

std::string on_boot_line(const std::string& key) {
  std::istringstream words(first_line("/proc/cmdline"));
  for (std::string word; words >> word;) {
    if (word.starts_with(key + "=")) { return word.substr(key.size() + 1); }
  }
  return "none";
}

Value turbo() {
  const Value boost = yes_or_no("/sys/devices/system/cpu/cpufreq/boost");
  return boost.index() != 0 ? boost
                            : yes_or_no("/sys/devices/system/cpu/intel_pstate/no_turbo", false);
}

bool is_preempt_rt(const utsname& kernel) {
  return first_line("/sys/kernel/realtime") == "1" ||
         std::string(kernel.version).find("PREEMPT_RT") != std::string::npos;
}

double clock_resolution() {
  timespec resolution{};
  clock_getres(CLOCK_MONOTONIC, &resolution);
  return 1e9 * static_cast<double>(resolution.tv_sec) + static_cast<double>(resolution.tv_nsec);
}

std::string first_words(const std::string& line, int count) {
  std::istringstream in(line);
  std::string words;
  std::string word;
  for (int n = 0; n < count && in >> word; ++n) { words += (n > 0 ? " " : "") + word; }
  return words;
}

std::string granted(const std::string& what, const std::string& refusal) {
  return refusal.empty() ? what : "refused: " + refusal;
}

void add_processor(std::vector<EnvironmentFact>& facts, int processor,
                   const std::optional<double>& cycles) {
  const std::string frequency =
      "/sys/devices/system/cpu/cpu" + std::to_string(processor) + "/cpufreq/scaling_governor";
  const bool virtualised = has_flag("hypervisor");
  facts.insert(
      facts.end(),
      {{"cpu", "processor", text(processor_line("model name"))},
       {"processors", "processors", static_cast<double>(sysconf(_SC_NPROCESSORS_ONLN))},
       {"microcode", "microcode", text(processor_line("microcode"))},
       {"virtualised", "virtual machine", virtualised},
       {"governor", "frequency governor", text(first_line(frequency))},
       {"turbo", "turbo", turbo()},
       {"smt", "two threads a core", yes_or_no("/sys/devices/system/cpu/smt/active")},
       {"cycles_per_second", "steady cycle counter (Hz)", cycles ? Value{*cycles} : Value{}}});
}

void add_kernel(std::vector<EnvironmentFact>& facts) {
  utsname kernel{};
  uname(&kernel);
  facts.insert(
      facts.end(),
      {{"kernel", "kernel", std::string(kernel.release) + " " + kernel.version},
       {"preempt_rt", "PREEMPT_RT", is_preempt_rt(kernel)},
       {"boot_line", "boot line", text(first_line("/proc/cmdline"))},
       {"isolcpus", "isolcpus", on_boot_line("isolcpus")},
       {"nohz_full", "nohz_full", on_boot_line("nohz_full")},
       {"rt_runtime_us", "real-time share of a second (us)",
        text(first_line("/proc/sys/kernel/sched_rt_runtime_us"))},
       {"clock_source", "clock source",
        text(first_line("/sys/devices/system/clocksource/clocksource0/current_clocksource"))},
       {"clock_resolution_ns", "clock resolution (ns)", clock_resolution()},
       {"load_average", "load average over 1, 5, 15 min",
        text(first_words(first_line("/proc/loadavg"), 3))}});
}

}  // namespace

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

std::size_t largest_cache() {
  constexpr long least = 1L << 20U;
  constexpr long most = 128L << 20U;
  const long found = sysconf(_SC_LEVEL3_CACHE_SIZE);
  return static_cast<std::size_t>(found <= 0 ? 32L << 20U : std::clamp(found, least, most));
}

std::vector<int> isolated_processors() {
  std::vector<int> processors;
  std::istringstream parts(first_line("/sys/devices/system/cpu/isolated"));
  for (std::string part; std::getline(parts, part, ',');) {
    int first = 0;
    int last = 0;
    const int read = std::sscanf(part.c_str(), "%d-%d", &first, &last);
    for (int n = first; read >= 1 && n <= (read == 2 ? last : first); ++n) {
      processors.push_back(n);
    }
  }
  return processors;
}

certificate::ProcessorTimes processor_times(int processor) {
  std::ifstream stat("/proc/stat");
  const double tick = 1.0 / static_cast<double>(sysconf(_SC_CLK_TCK));
  certificate::ProcessorTimes times;
  for (std::string line; std::getline(stat, line);) {
    if (!line.starts_with("cpu") || line[3] == ' ') {
      continue;
    }  // the first line is the sum of all
    int number = -1;
    double user = 0, nice = 0, system = 0, idle = 0, waiting = 0, hard = 0, soft = 0, stolen = 0;
    if (std::sscanf(line.c_str(), "cpu%d %lf %lf %lf %lf %lf %lf %lf %lf", &number, &user, &nice,
                    &system, &idle, &waiting, &hard, &soft, &stolen) != 9) {
      continue;
    }
    if (number == processor) {
      times.stolen = tick * stolen;
      times.interrupts = tick * (hard + soft);
    } else {
      times.others += tick * (user + nice + system + hard + soft);
    }
  }
  return times;
}

std::optional<double> cycles_per_second() {
#if defined(__x86_64__)
  if (!has_flag("constant_tsc") || !has_flag("nonstop_tsc")) { return {}; }
  constexpr double enough = 0.05;  // [s]
  const double begin = device::monotonic_now();
  const auto first = __rdtsc();
  double now = begin;
  while (now - begin < enough) { now = device::monotonic_now(); }
  return static_cast<double>(__rdtsc() - first) / (now - begin);
#else
  return {};
#endif
}

std::vector<EnvironmentFact> environment_of(const certificate::Rights& rights, int priority,
                                            const std::optional<double>& cycles) {
  const auto build = build_provenance();
  std::vector<EnvironmentFact> facts;
  add_processor(facts, rights.on, cycles);
  add_kernel(facts);
  facts.insert(
      facts.end(),
      {{"scheduling", "scheduling of the loop",
        granted("SCHED_FIFO, priority " + std::to_string(priority), rights.fifo)},
       {"memory", "memory", granted("locked, stack touched", rights.memory)},
       {"processor", "loop kept to processor",
        rights.processor.empty() ? Value{static_cast<double>(rights.on)} : Value{rights.processor}},
       {"compiler", "compiler", build.at("compiler")},
       {"flags", "flags", build.at("flags")}});
  return facts;
}

}  // namespace palpate::cli
