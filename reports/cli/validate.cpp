// SPDX-License-Identifier: MIT
#include <algorithm>
#include <thread>

#include "reports/cli/interrupt.hpp"
#include "reports/cli/judging.hpp"

namespace palpate::cli {

int validate(const ValidateOptions& options) {
  catch_interrupts();
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return judge(options, {.command = "validate",
                         .title = "Palpate validation",
                         .cases = all_cases(),
                         .jobs = options.jobs > 0 ? options.jobs : cores,
                         .keeps = true});
}

}  // namespace palpate::cli
