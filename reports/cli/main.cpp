// SPDX-License-Identifier: MIT
/// The `palpate` program: command line in, exit code out.

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <new>
#include <sstream>
#include <stdexcept>

#include "fixtures/io/child_read.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "model/kernels/instruction_set.hpp"
#include "model/problem/input_error.hpp"
#include "reports/cli/commands.hpp"

namespace {

using namespace palpate;
using namespace palpate::cli;

/// Puts "palpate:" before every line of a message. Text of files may hold anything, so what a
/// terminal would obey is replaced.
int refuse(const std::string& message, int code) {
  if (interrupted) { io::end_process(interrupted_code); }  // the problem is a consequence
  std::istringstream lines(message);
  for (std::string line; std::getline(lines, line);) {
    std::fprintf(stderr, "palpate: %s\n", io::printable(line).c_str());
  }
  return code;
}

/// Returns the exit code of a finished command. A full disk under standard output is noticed when
/// the last text is written.
int after_output(int code) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) { return code; }
  const int failed = refuse(std::string("standard output cannot be written: ") +
                                std::strerror(errno) + "; a file or terminal with space is needed",
                            machine_cannot);
  return code == done ? failed : code;
}

/// Runs what the command line selects. Throws what the command throws.
int run(Program& program, int argc, char** argv) {
  try {
    program.app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) { return program.app.exit(error); }  // --help, --version
    throw InputError(std::string(error.what()) + "; `palpate --help` shows what is allowed");
  }
  try {
    (void)widest_allowed();
  } catch (const std::invalid_argument& error) { throw InputError(error.what()); }
  return program.chosen();
}

}  // namespace

int main(int argc, char** argv) {
  catch_interrupts();
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
    return after_output(run(program, argc, argv));
  } catch (const InputError& error) {
    return refuse(error.what(), bad_input);
  } catch (const std::filesystem::filesystem_error& error) {
    const std::string path = error.path1().string();
    return refuse((path.empty() ? "" : path + ": ") + error.code().message() +
                      "; a file or folder that can be used is needed",
                  bad_input);
  } catch (const std::bad_alloc&) {
    return refuse("out of memory; a smaller scene or file is needed, or more memory",
                  machine_cannot);
  } catch (const std::length_error&) {  // a container larger than any memory
    return refuse("out of memory; a smaller scene or file is needed, or more memory",
                  machine_cannot);
  } catch (const io::ReadInterrupted&) {
    io::end_process(interrupted_code);
  } catch (const std::exception& error) { return refuse(error.what(), fell_short); }
}
