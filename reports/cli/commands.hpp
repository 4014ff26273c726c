// SPDX-License-Identifier: MIT
#pragma once
/// The commands of `palpate`, their exit codes and the arguments that several of them share.

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

/// Options of every command.
struct CommonOptions {
  std::filesystem::path out{};           ///< empty: palpate-out/COMMAND
  std::vector<std::string> overrides{};  ///< --set dotted.key=value
  bool quiet = false;

  [[nodiscard]] std::filesystem::path folder(const std::string& command) const {
    return out.empty() ? std::filesystem::path("palpate-out") / command : out;
  }
};

/// Set by SIGINT and SIGTERM after a call of catch_interrupts(). A command that calls it must check
/// the flag and end with the results so far. A second signal ends the program at once.
extern std::atomic<bool> interrupted;
void catch_interrupts();

/// Accepts a number from `least` to `most`. CLI::Range would accept NaN, for which every comparison
/// is false.
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

/// Adds --set. `file` names the kind of file that the keys belong to.
void add_overrides(CLI::App& command, CommonOptions& options, const std::string& file);

/// Adds the argument SCENE, and --set.
void add_scene(CLI::App& command, CommonOptions& options, std::filesystem::path& scene);

/// The list of integrators for the end of a help text.
std::string integrator_help();

template <class Options> struct Command {
  CLI::App& command;
  Options& options;
};

/// Adds a command. Its options live as long as the application; if the command line names it,
/// `chosen` becomes a call of `run`.
template <class Options>
Command<Options> add_command(CLI::App& app, std::function<int()>& chosen, const std::string& name,
                             const std::string& summary, int (*run)(const Options&)) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(name, summary);
  command->callback([options, run, &chosen] { chosen = [options, run] { return run(*options); }; });
  return {*command, *options};
}

// Each command has one file with its options, its command line and its function.

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
