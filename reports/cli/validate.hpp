// SPDX-License-Identifier: MIT
#pragma once
/// Cases selected, run, told, written: what `validate` and `bench` have in common.

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
      cache{};  ///< of references, judged cases, libraries; empty: the user's cache folder
  std::filesystem::path data{};  ///< of networks outside the project; empty: searched
};

/// The difference between the two commands.
struct Judging {
  std::string command{};  ///< "validate"
  std::string title{};
  std::vector<Case> cases{};
  int jobs = 1;
  std::string
      further{};  ///< options that this command has beyond those of both, " --against HEAD~1"
  /// Of the results as a whole, when all cases have run; empty: nothing more is judged.
  std::function<Outcome(const Results&)> afterwards{};
  bool keeps = false;  ///< what passed need not run again while nothing changes
};

/// Exit code of the command.
int judge(const ValidateOptions& options, const Judging& what);

}  // namespace palpate::cli
