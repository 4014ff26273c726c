// SPDX-License-Identifier: MIT
#pragma once
/// Runs cases on several threads and gives their outcomes in the order asked for.

#include <atomic>
#include <functional>
#include <vector>

#include "validation/case.hpp"

namespace palpate::cli {

struct RunnerResult {
  std::vector<Outcome> outcomes{};  ///< of the finished cases, in the order of `cases`
  bool interrupted = false;         ///< then some cases are still running on their threads
};

/// finished(outcome, done, total) is called on the calling thread as cases end. After an interrupt
/// it returns within a fraction of a second without waiting for the running cases, so the caller
/// must end the process without destroying what they use.
RunnerResult run_cases(std::vector<Case> cases, const CaseContext& context, int jobs,
                       const std::atomic<bool>& stop,
                       const std::function<void(const Outcome&, std::size_t, std::size_t)>& finished);

}  // namespace palpate::cli
