// SPDX-License-Identifier: MIT
#include "reports/cli/common_arguments.hpp"

namespace palpate::cli {

void add_common(CLI::App& command, CommonOptions& options, const std::string& name) {
  command.add_option("--out", options.out, "folder for what is written [palpate-out/" + name + "]")
      ->type_name("DIR");
  command.add_flag("--quiet", options.quiet, "say nothing but errors");
}

void add_overrides(CLI::App& command, CommonOptions& options, const std::string& file) {
  command.add_option("--set", options.overrides, file + " key to override, value in TOML syntax; repeatable")
      ->type_name("dotted.key=value")
      ->allow_extra_args(false);
}

}  // namespace palpate::cli
