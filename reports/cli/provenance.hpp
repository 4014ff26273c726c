// SPDX-License-Identifier: MIT
#pragma once
/// Provenance of a result: version, commit, compiler, flags, processor, date.

#include <map>
#include <string>

namespace palpate::cli {

std::map<std::string, std::string> build_provenance();

/// Program version with commit: "palpate 0.1.0 (commit)".
std::string version_text();

/// Value of a key in /proc/cpuinfo for the first processor; empty if the key is missing.
std::string processor_line(const std::string& name);

}  // namespace palpate::cli
