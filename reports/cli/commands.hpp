// SPDX-License-Identifier: MIT
#pragma once
/// Commands of `palpate`, their exit codes and their shared options.

#include <CLI/CLI.hpp>
#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace palpate::cli {

enum ExitCode : int {
  done = 0,
  fell_short = 1,
  bad_input = 2,
  machine_cannot = 3,
  interrupted_code = 130
};

/// Options that every command accepts.
struct CommonOptions {
  std::filesystem::path out{};           ///< output folder; if empty, palpate-out/COMMAND
  std::vector<std::string> overrides{};  ///< --set dotted.key=value
  bool quiet = false;

  [[nodiscard]] std::filesystem::path folder(const std::string& command) const {
    return out.empty() ? std::filesystem::path("palpate-out") / command : out;
  }
};

/// Set by SIGINT and SIGTERM after catch_interrupts(). A command that calls it must check the flag
/// and return with the results so far. A second signal terminates the program at once.
extern std::atomic<bool> interrupted;
void catch_interrupts();

/// Validator for numbers in [least, most]. Unlike CLI::Range it rejects NaN, for which every
/// comparison is false.
inline CLI::Validator number_range(double least, double most) {
  const auto check = [least, most](std::string& text) -> std::string {
    double value = 0.0;
    if (CLI::detail::lexical_cast(text, value) && value >= least && value <= most) { return {}; }
    return "Value " + text + " not in range " + CLI::detail::to_string(least) + " to " +
           CLI::detail::to_string(most);
  };
  return CLI::Validator(check, "FLOAT in [" + CLI::detail::to_string(least) + " - " +
                                   CLI::detail::to_string(most) + "]");
}

/// Adds --out and --quiet.
void add_common(CLI::App& command, CommonOptions& options, const std::string& name);

/// Adds --set. `file` is the kind of file that contains the keys, for the help text.
void add_overrides(CLI::App& command, CommonOptions& options, const std::string& file);

/// Adds the positional argument SCENE and the option --set.
void add_scene(CLI::App& command, CommonOptions& options, std::filesystem::path& scene);

/// List of integrators at the end of a help text.
std::string integrator_help();

template <class Options> struct Command {
  CLI::App& command;
  Options& options;
};

/// Adds a command. Its options have the lifetime of the application. If the command line selects
/// the command, `chosen` is set to a call of `run`.
template <class Options>
Command<Options> add_command(CLI::App& app, std::function<int()>& chosen, const std::string& name,
                             const std::string& summary, int (*run)(const Options&)) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(name, summary);
  command->callback([options, run, &chosen] { chosen = [options, run] { return run(*options); }; });
  return {*command, *options};
}

// Each command has one source file with its options, its command line and its function.

void add_run(CLI::App& app, std::function<int()>& chosen);
void add_inspect(CLI::App& app, std::function<int()>& chosen);
void add_validate(CLI::App& app, std::function<int()>& chosen);
void add_bench(CLI::App& app, std::function<int()>& chosen);
void add_steps(CLI::App& app, std::function<int()>& chosen);
void add_certify(CLI::App& app, std::function<int()>& chosen);
void add_report(CLI::App& app, std::function<int()>& chosen);
void add_falcon(CLI::App& app, std::function<int()>& chosen);
void add_import(CLI::App& app, std::function<int()>& chosen);
void add_transducer(CLI::App& app, std::function<int()>& chosen);
void add_gate(CLI::App& app, std::function<int()>& chosen);
void add_approve(CLI::App& app, std::function<int()>& chosen);
void add_compare(CLI::App& app, std::function<int()>& chosen);
void add_calibrate(CLI::App& app, std::function<int()>& chosen);
void add_reconstruct(CLI::App& app, std::function<int()>& chosen);

}  // namespace palpate::cli
