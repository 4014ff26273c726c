// SPDX-License-Identifier: MIT
#pragma once
/// Commands of `palpate`, their exit codes and their shared options.

#include <CLI/CLI.hpp>
#include <atomic>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "device/byte_link.hpp"
#include "reports/results/results.hpp"
#include "reports/subject/foreign_subject.hpp"
#include "validation/campaign/findings.hpp"
#include "validation/outcome.hpp"

namespace palpate::build {

/// Hash of the object code that determines what is computed; defined in build/.../code_hash.cpp.
const char* code_hash();

}  // namespace palpate::build

namespace palpate::cli {

enum ExitCode : int {
  done = 0,
  fell_short = 1,
  bad_input = 2,
  machine_cannot = 3,
  interrupted_code = 130
};

/// Options that commands share; add_command() adds them.
struct CommonOptions {
  std::string name{};     ///< name of the command
  std::string command{};  ///< command line that reproduces the result
  std::filesystem::path out{};
  std::vector<std::string> overrides{};  ///< --set dotted.key=value
  bool quiet = false;
  bool verbose = false;
  bool json = false;        ///< result on standard output instead of text
  std::string json_file{};  ///< file in the output folder that --json prints; empty: none

  [[nodiscard]] std::filesystem::path output_folder() const;

  /// Creates the output folder if it does not exist, locks it against other processes of this
  /// program until this one ends, and returns it. `files` are the files that the command writes
  /// there, or folders with their files, which end with '/'. Throws InputError, also if the folder
  /// is locked, or if one of the files is an input, which this process has read.
  [[nodiscard]] std::filesystem::path make_folder(const std::vector<std::string>& files) const;
};

/// Waits until no other process of this program has locked a folder, and locks it until this
/// process ends. Throws InputError if it is not a folder that can be read. Does nothing on file
/// systems without locks.
void lock_folder(const std::filesystem::path& folder);

/// Throws InputError if this process has read the file, which a command is about to write.
void refuse_input(const std::filesystem::path& file);

/// Creates the folder of a file that a command will write. Throws InputError.
void make_folder_of(const std::filesystem::path& file);

/// Throws InputError if a folder of results is the one that a command writes its page to.
void refuse_folder_of(const std::filesystem::path& results, const std::filesystem::path& folder);

/// Throws InputError if `file` is no regular file, cannot be written, was read by this process, or
/// exists and its beginning is not that of an own file, as with a key; `kind` is what it may be,
/// such as "an archive".
void refuse_to_replace(const std::filesystem::path& file,
                       const std::function<bool(std::string_view)>& is_own, std::string_view kind);

/// Set by SIGINT, SIGTERM and SIGHUP after catch_interrupts().
extern std::atomic<bool> interrupted;

/// From here on SIGINT, SIGTERM and SIGHUP end the program with exit code 130 as soon as no file is
/// being written (io::WholeWrite). A second signal ends it at once.
void catch_interrupts();

/// Called by a command that checks `interrupted` and then writes its results so far: it gets most
/// of a second to begin with that.
void keep_results_of_interrupted();

/// Validator for numbers in [least, most]. Unlike CLI::Range it rejects NaN, for which every
/// comparison is false.
inline CLI::Validator number_range(double least, double most) {
  const std::string range = CLI::detail::to_string(least) + " to " + CLI::detail::to_string(most);
  const auto check = [least, most, range](std::string& text) -> std::string {
    double value = 0.0;
    if (CLI::detail::lexical_cast(text, value) && value >= least && value <= most) { return {}; }
    return "Value " + text + " not in range " + range;
  };
  return CLI::Validator(check, "from " + range);
}

/// Validator for seeds. Without it -1 would become 2^64 - 1.
inline CLI::Validator seed_range() {
  const auto check = [](std::string& text) -> std::string {
    std::uint64_t seed = 0;
    const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), seed);
    if (problem == std::errc() && end == text.data() + text.size()) { return {}; }
    return "Value " + text + " is no whole number from 0 to 2^64 - 1";
  };
  return CLI::Validator(check, "from 0");
}

/// Adds an option; `type` names its value in the help text. A list takes one value at each use.
template <class Value>
CLI::Option* add_value(CLI::App& command, const std::string& name, Value& value, const char* type,
                       const std::string& help) {
  CLI::Option* option = command.add_option(name, value, help)->type_name(type);
  if (name.starts_with("-")) { option->allow_extra_args(false); }
  return option;
}

/// Adds --set. `file` is the kind of file that contains the keys, for the help text.
void add_overrides(CLI::App& command, CommonOptions& options, const std::string& file = "scene");

/// Adds the positional argument SCENE and the option --set.
void add_scene(CLI::App& command, CommonOptions& options, std::filesystem::path& scene);

/// Adds --subject and the options of other simulators.
void add_subject_options(CLI::App& command, SubjectChoice& choice);

/// Adds --shard. `items` are what it selects, for the help text.
void add_shard(CLI::App& command, std::string& shard, const std::string& items);

/// Returns the shard of --shard, else that of TEST_SHARD_INDEX, GTEST_SHARD_INDEX (from 0) or a
/// whole Slurm array; empty if there is none. Throws InputError.
std::optional<campaign::Shard> chosen_shard(const std::string& given);

// Keys of the provenance of a shard of `validate`, and what `merge` needs of it.
inline constexpr const char* shard_key = "shard";
inline constexpr const char* shard_positions_key = "shard positions";
inline constexpr const char* shard_total_key = "shard total";

/// Folder of kept references, judged cases and libraries, unless --cache names another.
std::filesystem::path default_cache_folder();

/// Returns the choice with what the simulator's process may not read: the cache, the output folder
/// and `more`, files or folders with answers.
SubjectChoice confined(const SubjectChoice& choice, const CommonOptions& options,
                       const std::vector<std::filesystem::path>& more = {});

/// File that a command writes from a text of the program.
struct TemplateFile {
  std::string_view name;
  std::string_view text;
};

/// Writes files into a new folder. Throws InputError if it exists and is not empty.
void write_new_folder(const std::filesystem::path& folder, const std::vector<TemplateFile>& files);

/// Writes the skeleton of a simulator into a new folder. Returns the command that builds and checks
/// it. Throws InputError.
std::string write_subject_skeleton(const std::string& language,
                                   const std::filesystem::path& folder);

/// Returns the files that a simulator under test is read from: a library, a trace, or of a command
/// its program and each of its words that is a file. None for the model.
std::vector<std::filesystem::path> files_of_subject(const std::string& subject);

/// Returns the hash of these files, and of the text of a command. Not for the model.
std::string hash_of_subject(const std::string& subject);

/// Entries of a provenance that describe a subject.
std::map<std::string, std::string> subject_provenance(const SubjectFacts& facts);

// Emulated devices on a pseudo-terminal or on standard input and output.

void add_terminal(CLI::App& command, bool& pty);

/// Opens a pseudo-terminal and prints its path.
std::unique_ptr<device::PtyLink> open_terminal();

/// Calls `serve` and returns the exit code of the command.
int serve_device(const std::function<void()>& serve);

/// List of integrators at the end of a help text.
std::string integrator_help();

/// Returns a word as one argument for a shell, quoted where necessary.
std::string in_shell_quotes(const std::string& word);

/// Command line with all options that affect the result, quoted for a shell.
std::string reproducible(const CLI::App& command);

/// Provenance of a result: version, commit, compiler, flags, processor, date.
std::map<std::string, std::string> build_provenance();

/// Program version with commit: "palpate 0.1.0 (commit)".
std::string version_text();
/// The same, and a line for each fact of build, processor, licence and libraries.
std::string version_details();

/// Value of a key in /proc/cpuinfo for the first processor; empty if the key is missing.
std::string processor_line(const std::string& name);

struct Program {
  CLI::App app{"Palpate: validation and regression harness for haptic soft-tissue simulation"};
  std::function<int()> chosen{};  ///< function of the command that the command line selects
};

template <class Options> struct Command {
  CLI::App& command;
  Options& options;
};

/// Adds --out, --quiet and --version.
void add_common(CLI::App& command, CommonOptions& options);

/// Adds --json, which prints `file` of the output folder. Without a file the command prints itself.
void add_json(CLI::App& command, CommonOptions& options, const std::string& file = {});

/// Adds --verbose; `help` says what it adds to the text.
void add_verbose(CLI::App& command, CommonOptions& options, const std::string& help);

/// Hides --out and --quiet from the help of a command that writes no files. It accepts them.
void writes_nothing(CLI::App& command);

/// Returns the text in green or red if standard output is a terminal, and as it is elsewhere, with
/// the environment variable NO_COLOR and on a dumb terminal.
std::string in_colour(const std::string& text, Status status);

/// Calls `run`, with --json as add_json() says.
int run_command(CommonOptions& options, const std::function<int()>& run);

/// Adds a command with the common options, which have the lifetime of the program. A command
/// `parent name` is a subcommand of `parent`.
template <class Options>
Command<Options> add_command(Program& program, const std::string& name, const std::string& summary,
                             int (*run)(const Options&), CLI::App* parent = nullptr) {
  const auto options = std::make_shared<Options>();
  options->name = parent != nullptr ? parent->get_name() + "-" + name : name;
  CLI::App* command = (parent != nullptr ? parent : &program.app)->add_subcommand(name, summary);
  add_common(*command, *options);
  command->callback([command, options, run, &program] {
    options->command = reproducible(*command);
    program.chosen = [options, run] {
      return run_command(*options, [&options, run] { return run(*options); });
    };
  });
  return {*command, *options};
}

/// Returns the commands of a program or the subcommands of a command, in the order of the help
/// text.
inline std::vector<const CLI::App*> subcommands_of(const CLI::App& parent) {
  return parent.get_subcommands([](const CLI::App*) { return true; });
}

/// Names of all commands, grouped by task, with one line each.
std::string commands_by_task(const CLI::App& app);

/// Manual page in the format of man(7).
std::string man_page(const CLI::App& app);

/// Message for a command line that CLI11 refused: the word, the nearest known word, where help is.
std::string usage_error(const CLI::App& app, const CLI::ParseError& error);

/// io::printable() for text of several lines.
std::string printable_lines(const std::string& text);

// Each command has one source file with its options, its command line and its function.

void add_help(Program& program);
void add_init(Program& program);
void add_scene_keys(Program& program);
void add_schema(Program& program);
void add_completion(Program& program);
void add_version(Program& program);
void add_run(Program& program);
void add_inspect(Program& program);
void add_validate(Program& program);
void add_export(Program& program);
void add_subject(Program& program);
/// Adds `subject check`, which judges with the cases of `validate`.
void add_subject_check(Program& program, CLI::App& subject);
void add_bench(Program& program);
void add_steps(Program& program);
void add_certify(Program& program);
void add_report(Program& program);
void add_index(Program& program);
void add_merge(Program& program);
void add_campaign(Program& program);
void add_evidence(Program& program);
void add_verify(Program& program);

/// Returns the findings of a merged campaign, and extends the domain by its jobs with the status
/// ok. `name` is used in messages. Throws InputError.
Results campaign_findings(const std::string& text, const std::string& name,
                          campaign::Domain& domain);

/// Returns the scenes and their files in `header`, the first line of a campaign, each with its
/// SHA-256. Throws InputError with `name`, the campaign's file.
std::vector<std::pair<std::filesystem::path, std::string>> files_of_campaign(
    const std::string& header, const std::string& name);

void add_falcon(Program& program);
void add_live(Program& program);
void add_import(Program& program);
void add_transducer(Program& program);
void add_gate(Program& program);
void add_approve(Program& program);
void add_compare(Program& program);
void add_calibrate(Program& program);
void add_reconstruct(Program& program);

}  // namespace palpate::cli
