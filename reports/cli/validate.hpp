// SPDX-License-Identifier: MIT
#pragma once
/// Common part of `validate` and `bench`: select, run and report cases, and write the results.

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "reference/solution.hpp"
#include "reports/cli/commands.hpp"
#include "reports/results/results.hpp"
#include "validation/case.hpp"

namespace palpate::cli {

/// Options shared by validate and bench.
struct ValidateOptions : CommonOptions {
  std::vector<std::string> cases{};
  bool list = false;
  bool quick = false;
  bool no_skip = false;
  int jobs = 0;                   ///< parallel jobs; 0: one per core
  std::uint64_t order = 0;        ///< seed of an alternative summation order; 0: default order
  std::filesystem::path cache{};  ///< folder for references, judged cases and libraries; if empty,
                                  ///< the user's cache folder
  std::filesystem::path data{};   ///< networks outside the project; if empty, the default folders
};

/// Settings that differ between the two commands.
struct Judging {
  std::string title{};
  std::vector<Case> cases{};
  int jobs = 1;
  /// Judges the complete results after all cases; may be empty.
  std::function<Outcome(const Results&)> afterwards{};
  bool keeps = false;  ///< if true, passed cases are not run again while their inputs are unchanged
};

/// Adds the positional argument CASE and the options of both commands.
void add_cases(CLI::App& command, ValidateOptions& options, const char* help);

/// Runs the cases and returns the exit code of the command.
int judge(const ValidateOptions& options, const Judging& what);

/// Source folder that this program was built from. It contains the shipped scenes.
std::filesystem::path source_folder();

// Cache of reference solutions (reference::Cache) in a folder of HDF5 files.

/// Returns $XDG_CACHE_HOME/palpate, else ~/.cache/palpate, else a folder beside the temporary
/// files.
std::filesystem::path default_cache_folder();

reference::Cache cache_in(const std::filesystem::path& folder);

}  // namespace palpate::cli
