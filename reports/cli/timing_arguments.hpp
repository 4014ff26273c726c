// SPDX-License-Identifier: MIT
#pragma once
/// Command lines of what is timed and counted.

#include <CLI/CLI.hpp>

#include "reports/cli/commands.hpp"

namespace palpate::cli {

void add_bench(CLI::App& command, BenchOptions& options);
void add_steps(CLI::App& command, StepsOptions& options);

}  // namespace palpate::cli
