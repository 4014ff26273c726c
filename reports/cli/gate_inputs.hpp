// SPDX-License-Identifier: MIT
#pragma once
/// What gate and approve read alike.

#include <filesystem>
#include <string>
#include <vector>

#include "reports/results.hpp"

namespace palpate::cli {

/// Of validate or bench, or the folder of a run. Throws InputError.
Results read_judged(const std::filesystem::path& folder);

/// Names of the cases that patterns select as validate does; empty where there is no pattern. Throws InputError
/// where one selects nothing.
std::vector<std::string> names_of(const std::vector<std::string>& patterns, const std::vector<std::string>& names);

}  // namespace palpate::cli
