// SPDX-License-Identifier: MIT
/// The `palpate` program: command line in, exit code out.

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fcntl.h>
#include <filesystem>
#include <new>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <unistd.h>

#include "fixtures/io/child_read.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "model/kernels/instruction_set.hpp"
#include "model/problem/input_error.hpp"
#include "reports/cli/commands.hpp"

namespace {

using namespace palpate;
using namespace palpate::cli;

/// Opens /dev/null in place of closed standard streams. Otherwise the next file, perhaps one of
/// results, would be standard output. Writing to it fails, as on a full disk.
void occupy_standard_streams() {
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream) {
    if (fcntl(stream, F_GETFD) == -1) { (void)!open("/dev/null", O_RDONLY); }
  }
}

/// Words of the command line that have line breaks.
std::vector<std::string> broken_words{};

void find_broken_words(std::span<char*> words) {
  for (std::string_view word : words) {
    if (word.find('\n') == word.npos) { continue; }
    if (word.starts_with("-")) { word.remove_prefix(std::min(word.find('=') + 1, word.size())); }
    broken_words.emplace_back(word);
  }
}

/// Puts "palpate:" before every line of a message. Text of files and names may hold anything, so
/// what a terminal would obey is replaced, and a line break in a name begins no line.
int refuse(std::string message, int code) {
  constexpr std::size_t most_of_a_line = 4000;
  if (interrupted) { io::end_process(interrupted_code); }  // the problem is a consequence
  for (const std::string& word : broken_words) {
    const std::string shown = io::printable(word);
    for (auto at = message.find(word); at != message.npos; at = message.find(word, at)) {
      message.replace(at, word.size(), shown);
      at += shown.size();
    }
  }
  std::istringstream lines(message);
  for (std::string line; std::getline(lines, line);) {
    std::string text = io::printable(line);
    if (text.size() > most_of_a_line) {  // the beginning has the place, the end what is allowed
      text.replace(most_of_a_line / 2, text.size() - most_of_a_line, " ... ");
    }
    std::fprintf(stderr, "palpate: %s\n", text.c_str());
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

/// Refuses values of flags, as --json=1.
void refuse_values_of_flags(CLI::App& command) {
  for (CLI::Option* option : command.get_options()) {
    if (option->get_items_expected_max() == 0) { option->disable_flag_override(); }
  }
  for (CLI::App* each : command.get_subcommands({})) { refuse_values_of_flags(*each); }
}

/// Throws InputError if an argument is empty, as that of an unset variable of a shell: it would
/// count as left out.
void refuse_empty_arguments(const CLI::App& command) {
  for (const CLI::Option* option : command.get_options()) {
    if (std::ranges::find(option->results(), "") == option->results().end()) { continue; }
    throw InputError(option->get_name() + ": the value is empty; give one, or leave " +
                     option->get_name() + " out");
  }
  for (const CLI::App* chosen : command.get_subcommands()) { refuse_empty_arguments(*chosen); }
}

/// Runs what the command line selects. Throws what the command throws.
int run(Program& program, int argc, char** argv) {
  refuse_values_of_flags(program.app);
  try {
    program.app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) { return program.app.exit(error); }  // --help, --version
    if (argc == 1) {
      std::printf("%s", commands_by_task(program.app).c_str());
      std::fflush(stdout);
    }
    throw InputError(usage_error(program.app, error));
  } catch (const std::invalid_argument& error) { throw InputError(error.what()); }
  // An option that is given twice can have an empty result without an empty argument.
  const bool empty = std::ranges::any_of(std::span(argv, argv + argc), [](std::string_view given) {
    return given.empty() || (given.starts_with('-') && given.ends_with('='));
  });
  if (empty) { refuse_empty_arguments(program.app); }
  try {
    (void)widest_allowed();
  } catch (const std::invalid_argument& error) { throw InputError(error.what()); }
  return program.chosen();
}

/// Commands of one task, in the order of the help text.
struct Task {
  const char* name;
  std::vector<void (*)(Program&)> commands;
};

const std::vector<Task>& tasks() {
  static const std::vector<Task> all{
      {"Scenes", {add_init, add_run, add_inspect, add_scene_keys, add_schema, add_export}},
      {"Judge a model or a simulator", {add_validate, add_bench, add_subject}},
      {"Results over time", {add_report, add_index, add_merge, add_gate, add_approve}},
      {"Campaigns and evidence", {add_campaign, add_evidence, add_verify}},
      {"Real time and devices", {add_live, add_certify, add_falcon}},
      {"Recordings", {add_import, add_transducer, add_compare, add_calibrate, add_reconstruct}},
      {"This program", {add_help, add_version, add_completion, add_steps}}};
  return all;
}

}  // namespace

int main(int argc, char** argv) {
  occupy_standard_streams();
  catch_interrupts();
  Program program;
  CLI::App& app = program.app;
  const std::span<char*> words(argv, static_cast<std::size_t>(argc));
  find_broken_words(words);
  app.set_version_flag("--version", [words] {
    const bool verbose = std::ranges::any_of(
        words, [](std::string_view word) { return word == "--verbose" || word == "-v"; });
    return verbose ? version_details() : version_text();
  });
  app.require_subcommand(1);
  const std::string exit_codes =
      "Exit codes: 0 all checks pass, 1 a check failed, 2 bad usage or input (nothing written),\n"
      "3 this machine cannot do it, 130 interrupted.";
  app.footer(exit_codes);  // also of commands without a footer of their own
  for (const Task& task : tasks()) {
    const std::size_t before = app.get_subcommands({}).size();
    for (const auto& add : task.commands) { add(program); }
    const std::vector<CLI::App*> all = app.get_subcommands({});
    for (std::size_t n = before; n < all.size(); ++n) { all[n]->group(task.name); }
  }
  app.footer(exit_codes + "\n`palpate help COMMAND` explains a command.");
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
