// SPDX-License-Identifier: MIT
#pragma once
/// Where a result came from: version, commit, compiler, flags, processor, date.

#include <map>
#include <string>

namespace palpate::cli {

std::map<std::string, std::string> build_provenance();
/// "palpate 0.1.0 (commit)".
std::string version_text();

}  // namespace palpate::cli
