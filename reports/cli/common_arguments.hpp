// SPDX-License-Identifier: MIT
#pragma once
/// Arguments that several commands take.

#include <CLI/CLI.hpp>

#include "reports/cli/commands.hpp"

namespace palpate::cli {

/// --out and --quiet.
void add_common(CLI::App& command, CommonOptions& options, const std::string& name);

/// --set; `file`: what the keys are of.
void add_overrides(CLI::App& command, CommonOptions& options, const std::string& file);

}  // namespace palpate::cli
