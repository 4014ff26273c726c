// SPDX-License-Identifier: MIT
/// The `palpate` program: command line in, exit code out.

#include <cstdio>
#include <exception>
#include <sstream>

#include "model/kernels/instruction_set.hpp"
#include "model/problem/input_error.hpp"
#include "reports/cli/commands.hpp"

namespace {

using namespace palpate;
using namespace palpate::cli;

/// Puts "palpate:" before every line of a message.
int refuse(const std::string& message, int code) {
  std::istringstream lines(message);
  for (std::string line; std::getline(lines, line);) {
    std::fprintf(stderr, "palpate: %s\n", line.c_str());
  }
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  Program program;
  CLI::App& app = program.app;
  app.set_version_flag("--version", version_text());
  app.require_subcommand(1);
  app.footer(integrator_help() +
             "\nExit codes: 0 all checks pass, 1 a check failed, 2 bad usage or input "
             "(nothing written),\n3 this machine cannot do it, 130 interrupted.");
  for (const auto& add :
       {add_run, add_inspect, add_validate, add_bench, add_steps, add_certify, add_report,
        add_export, add_subject, add_falcon, add_import, add_transducer, add_gate, add_approve,
        add_compare, add_calibrate, add_reconstruct}) {
    add(program);
  }
  for (CLI::App* each : app.get_subcommands({})) {
    each->set_version_flag("--version", version_text());
  }
  try {
    app.parse(argc, argv);
    try {
      (void)widest_allowed();
    } catch (const std::invalid_argument& error) { throw InputError(error.what()); }
    return program.chosen();
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) { return app.exit(error); }  // --help, --version
    return refuse(std::string(error.what()) + "; `palpate --help` shows what is allowed",
                  bad_input);
  } catch (const InputError& error) {
    return refuse(error.what(), bad_input);
  } catch (const std::exception& error) { return refuse(error.what(), fell_short); }
}
