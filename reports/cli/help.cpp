// SPDX-License-Identifier: MIT
/// The commands `help` and `version`, and messages for command lines that cannot be parsed.

#include <algorithm>
#include <cstdio>
#include <sstream>

#include "fixtures/io/problems.hpp"
#include "model/kernels/instruction_set.hpp"
#include "model/problem/input_error.hpp"
#include "reports/cli/commands.hpp"

namespace palpate::cli {
namespace {

struct HelpOptions : CommonOptions {
  const CLI::App* program = nullptr;
  std::vector<std::string> words{};
  bool man = false;
};

std::vector<std::string> names_of_commands(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : subcommands_of(app)) { names.push_back(command->get_name()); }
  return names;
}

std::vector<std::string> names_of_options(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) { names.push_back(name); }
  }
  return names;
}

/// Returns "; did you mean WORD?", or an empty string.
std::string did_you_mean(std::string_view word, const std::vector<std::string>& known,
                         const std::string& before = {}) {
  const std::string_view nearest = io::nearest_word(word, {known.begin(), known.end()});
  return nearest.empty() ? "" : "; did you mean " + before + std::string(nearest) + "?";
}

std::string unknown_command(const std::string& word, const CLI::App& parent,
                            const std::string& path) {
  const std::vector<std::string> known = names_of_commands(parent);
  std::string list;
  for (const std::string& name : known) { list += (list.empty() ? "" : ", ") + name; }
  const std::string hint = did_you_mean(word, known, path);
  return path + word + ": unknown command" +
         (!hint.empty()  ? hint
          : path.empty() ? "; `palpate help` lists the commands"
                         : "; one of " + list);
}

/// Words of a command, such as "subject check", without the program.
std::string path_of(const CLI::App& command) {
  const CLI::App* parent = command.get_parent();
  if (parent == nullptr) { return {}; }
  const std::string before = path_of(*parent);
  return before + (before.empty() ? "" : " ") + command.get_name();
}

int run_help(const HelpOptions& options) {
  if (options.man) {
    std::printf("%s", man_page(*options.program).c_str());
    return done;
  }
  const CLI::App* command = options.program;
  for (const std::string& word : options.words) {
    const std::string path = path_of(*command);
    const auto children = command->get_subcommands(
        [&word](const CLI::App* child) { return child->get_name() == word; });
    if (children.empty()) {
      throw InputError(unknown_command(word, *command, path.empty() ? "" : path + " "));
    }
    command = children.front();
  }
  const std::string parent =
      command->get_parent() == nullptr ? "" : path_of(*command->get_parent());
  const std::string text = options.words.empty()
                               ? commands_by_task(*command)
                               : command->help("palpate" + (parent.empty() ? "" : " " + parent));
  std::printf("%s", text.c_str());
  return done;
}

}  // namespace

std::string commands_by_task(const CLI::App& app) {
  constexpr std::size_t column = 14;
  std::string text = app.get_description() + "\n";
  std::string task;
  for (const CLI::App* command : subcommands_of(app)) {
    if (command->get_group() != task) {
      task = command->get_group();
      text += "\n" + task + "\n";
    }
    std::string name = command->get_name();
    name.resize(column, ' ');
    text += "  " + name + command->get_description() + "\n";
  }
  return text +
         "\n`palpate help COMMAND` explains a command. To begin:\n"
         "  palpate init needle --out first && palpate run first/scene.toml\n";
}

std::string usage_error(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App* command = &app;
  while (command->remaining().empty() && !command->get_subcommands().empty()) {
    command = command->get_subcommands().back();
  }
  const std::string path = path_of(*command);
  const std::string before = path.empty() ? "" : path + " ";
  const std::string help = "`palpate " + (path.empty() ? "help" : "help " + path) + "`";
  const bool group = !names_of_commands(*command).empty();
  const std::vector<std::string> extra = command->remaining();
  if (extra.empty()) {
    if (group && command->get_subcommands().empty()) {
      return path.empty() ? "no command; `palpate help` lists them"
                          : path + ": no command" + "; " + help + " lists them";
    }
    return std::string(error.what()) + "; " + help + " shows what is allowed";
  }
  const std::string word = extra.front().substr(0, extra.front().find('='));
  if (!word.starts_with("-")) {
    return group ? unknown_command(word, *command, before)
                 : before + word + ": one argument too many; " + help + " shows what is allowed";
  }
  const std::string bare = word.substr(std::min(word.find_first_not_of('-'), word.size()));
  const std::string hint = did_you_mean(bare, names_of_options(*command), "--");
  const bool misplaced = group && !command->get_subcommands().empty() && hint.empty();
  return before + word + ": unknown option" +
         (misplaced      ? "; options follow the command"
          : hint.empty() ? "; " + help + " lists the options"
                         : hint);
}

void add_help(Program& program) {
  const auto [command, options] =
      add_command(program, "help", "list the commands, or explain one", run_help);
  options.program = &program.app;
  add_value(command, "command", options.words, "COMMAND", "command to explain, such as run");
  command.add_flag("--man", options.man, "the manual page palpate(1), for man");
  writes_nothing(command);
}

namespace {

const char* instructions_here() {
  return widest_allowed() >= Widest::avx512 && has_avx512() ? "AVX-512"
         : widest_allowed() >= Widest::avx2 && has_avx2()   ? "AVX2"
                                                            : "baseline x86-64";
}

}  // namespace

std::string version_details() {
  std::string text = version_text();
  const auto add = [&](std::string_view name, std::string_view value) {
    text += "\n  ";
    text += name;
    text.append(name.size() < 14 ? 14 - name.size() : 0, ' ');
    text += ' ';
    text += value;
  };
  const std::map<std::string, std::string> facts = build_provenance();
  for (const char* name : {"compiler", "flags", "processor"}) { add(name, facts.at(name)); }
  add("instructions", instructions_here());
  add("licence", "GPL-3.0-or-later as a whole, because it links GSL; its sources are MIT");
  std::istringstream libraries(PALPATE_LIBRARIES);
  for (std::string each; std::getline(libraries, each, '|');) {
    add(each.substr(0, each.find(' ')), each.substr(each.find(' ') + 1));
  }
  return text;
}

namespace {

int run_version(const CommonOptions&) {
  std::printf("%s\n", version_details().c_str());
  return done;
}

}  // namespace

void add_version(Program& program) {
  const auto [command, options] = add_command(
      program, "version", "version, compiler, libraries and instruction set", run_version);
  writes_nothing(command);
}

}  // namespace palpate::cli
