// SPDX-License-Identifier: MIT
#pragma once
/// A results folder: results.json, results.xml, report.html and traces/.

#include <filesystem>

#include "reports/results.hpp"

namespace palpate {

/// Writes every file under a temporary name and renames it; report.html last.
void write_results_folder(const std::filesystem::path& folder, const Results& results);

/// From results.json and traces/ alone. Throws InputError.
Results read_results_folder(const std::filesystem::path& folder);

}  // namespace palpate
