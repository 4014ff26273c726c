// SPDX-License-Identifier: MIT
#pragma once
/// The common part of `validate` and `bench`: select, run and report cases, and write the results.

#include <functional>
#include <string>
#include <vector>

#include "reports/cli/commands.hpp"
#include "reports/results/results.hpp"
#include "validation/case.hpp"

namespace palpate::cli {

/// Options that validate and bench share.
struct ValidateOptions : CommonOptions {
  std::vector<std::string> cases{};
  bool list = false;
  bool quick = false;
  bool no_skip = false;
  int jobs = 0;             ///< 0: one per core
  std::uint64_t order = 0;  ///< seed of another order of summation; 0: none
  std::filesystem::path
      cache{};  ///< references, judged cases and libraries; empty: the user's cache folder
  std::filesystem::path data{};  ///< networks outside the project; empty: default folders
};

/// The difference between the two commands.
struct Judging {
  std::string command{};  ///< "validate"
  std::string title{};
  std::vector<Case> cases{};
  int jobs = 1;
  std::string further{};  ///< further options of the command line, " --against HEAD~1"
  /// Judges the results as a whole after all cases; may be empty.
  std::function<Outcome(const Results&)> afterwards{};
  bool keeps = false;  ///< cases that passed are not run again while nothing changes
};

/// Runs the cases and returns the exit code of the command.
int judge(const ValidateOptions& options, const Judging& what);

}  // namespace palpate::cli
