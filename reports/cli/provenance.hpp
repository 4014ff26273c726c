// SPDX-License-Identifier: MIT
#pragma once
/// Origin of a result: version, commit, compiler, flags, processor, date. Facts about the machine.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "reports/certificate_report.hpp"

namespace palpate::cli {

std::map<std::string, std::string> build_provenance();
/// "palpate 0.1.0 (commit)".
std::string version_text();

/// Value of a line of /proc/cpuinfo for the first processor; empty if there is no such line.
std::string processor_line(const std::string& name);

/// Size of the largest cache [bytes]; 32 MiB if the system does not report it.
std::size_t largest_cache();

/// The processors of a list such as "2-4,7".
std::vector<int> processors_in(const std::string& list);
/// Processors that the kernel command line isolates from other work.
std::vector<int> isolated_processors();

/// Times since the start of the machine, from /proc/stat.
certificate::ProcessorTimes processor_times(int processor);

/// Rate of the processor's time stamp counter [1/s], compared with the clock; empty if the counter
/// stops or changes its rate.
std::optional<double> cycles_per_second();

/// Facts for the report, with the rights that the system granted to the loop.
std::vector<EnvironmentFact> environment_of(const certificate::Rights& rights, int priority,
                                            const std::optional<double>& cycles);

}  // namespace palpate::cli
