// SPDX-License-Identifier: MIT
#pragma once
/// Command lines of what reads recordings.

#include <CLI/CLI.hpp>

#include "reports/cli/commands.hpp"

namespace palpate::cli {

void add_import(CLI::App& command, ImportOptions& options);
void add_transducer(CLI::App& command, TransducerCommandOptions& options);
void add_compare(CLI::App& command, CompareOptions& options);
void add_calibrate(CLI::App& command, CalibrateOptions& options);

}  // namespace palpate::cli
