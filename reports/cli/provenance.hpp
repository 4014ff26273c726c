// SPDX-License-Identifier: MIT
#pragma once
/// Where a result came from: version, commit, compiler, flags, processor, date.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "reports/certificate_report.hpp"

namespace palpate::cli {

std::map<std::string, std::string> build_provenance();
/// "palpate 0.1.0 (commit)".
std::string version_text();

// What the system says about the machine, as far as it matters to a loop with deadlines.

/// A line of /proc/cpuinfo, of the first processor; empty where there is none of that name.
std::string processor_line(const std::string& name);

/// Bytes of the largest cache, 32 MiB where the system does not say.
std::size_t largest_cache();

/// "2-4,7": the processors of such a list.
std::vector<int> processors_in(const std::string& list);
/// Processors that the boot line keeps free of other work.
std::vector<int> isolated_processors();

/// Since the start of the machine, from /proc/stat.
certificate::ProcessorTimes processor_times(int processor);

/// Of the processor's own counter, measured against the clock; nothing where it stops or changes
/// its pace.
std::optional<double> cycles_per_second();

/// With the rights that the loop was granted.
std::vector<EnvironmentFact> environment_of(const certificate::Rights& rights, int priority,
                                            const std::optional<double>& cycles);

}  // namespace palpate::cli
