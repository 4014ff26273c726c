// SPDX-License-Identifier: MIT
#pragma once
/// Provenance of a result: version, commit, compiler, flags, processor, date, machine properties.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "reports/certificate_report.hpp"

namespace palpate::cli {

std::map<std::string, std::string> build_provenance();
/// Program version with commit: "palpate 0.1.0 (commit)".
std::string version_text();

/// Size of the largest cache [bytes]; 32 MiB if the system does not report it.
std::size_t largest_cache();

/// Processors that the kernel command line isolates from the scheduler.
std::vector<int> isolated_processors();

/// Processor times since boot, from /proc/stat.
certificate::ProcessorTimes processor_times(int processor);

/// Rate of the time stamp counter [1/s], measured against the system clock. Empty if the counter
/// stops or has a variable rate.
std::optional<double> cycles_per_second();

/// Machine properties for the report, including the real-time rights granted to the loop.
std::vector<EnvironmentFact> environment_of(const certificate::Rights& rights, int priority,
                                            const std::optional<double>& cycles);

}  // namespace palpate::cli
