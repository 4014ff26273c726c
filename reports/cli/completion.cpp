// SPDX-License-Identifier: MIT
/// The command `completion`, and the manual page: both written from the description of the command
/// line.

#include <cstdio>
#include <sstream>

#include "palpate_version.hpp"

#include "model/problem/input_error.hpp"
#include "reports/cli/commands.hpp"

namespace palpate::cli {
namespace {

struct CompletionOptions : CommonOptions {
  const CLI::App* program = nullptr;
  std::string shell{};
};

struct NamedCommand {
  std::string path{};  ///< "subject check"
  const CLI::App* app = nullptr;
};

void collect(const CLI::App& parent, const std::string& path, std::vector<NamedCommand>& all) {
  for (const CLI::App* child : subcommands_of(parent)) {
    all.push_back({path.empty() ? child->get_name() : path + " " + child->get_name(), child});
    collect(*child, all.back().path, all);
  }
}

/// Returns every command, parents before their subcommands.
std::vector<NamedCommand> all_commands(const CLI::App& app) {
  std::vector<NamedCommand> all;
  collect(app, "", all);
  return all;
}

std::vector<const CLI::Option*> shown_options(const CLI::App& command) {
  return command.get_options([](const CLI::Option* option) {
    return option->nonpositional() && !option->get_group().empty();
  });
}

std::vector<std::string> spellings(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) { names.push_back("-" + name); }
  for (const std::string& name : option.get_lnames()) { names.push_back("--" + name); }
  return names;
}

bool takes_value(const CLI::Option& option) { return option.get_items_expected_max() > 0; }

/// Puts a backslash before these characters.
std::string escaped(const std::string& text, std::string_view special) {
  std::string result;
  for (const char c : text) {
    if (special.find(c) != std::string_view::npos) { result += '\\'; }
    result += c;
  }
  return result;
}

std::string joined_words(const std::vector<std::string>& words, const char* between) {
  std::string text;
  for (const std::string& word : words) { text += (text.empty() ? "" : between) + word; }
  return text;
}

/// Words that may follow a command: subcommands and options.
std::string words_after(const CLI::App& command) {
  std::vector<std::string> words;
  for (const CLI::App* child : subcommands_of(command)) { words.push_back(child->get_name()); }
  for (const CLI::Option* option : shown_options(command)) {
    for (const std::string& name : spellings(*option)) { words.push_back(name); }
  }
  return joined_words(words, " ");
}

std::string bash_script(const CLI::App& app) {
  std::string known;
  std::string words = "    '') words='" + words_after(app) + "' ;;\n";
  for (const NamedCommand& each : all_commands(app)) {
    known += (known.empty() ? "" : "|") + in_shell_quotes(each.path);
    words += "    '" + each.path + "') words='" + words_after(*each.app) + "' ;;\n";
  }
  return "# bash completion of palpate; written by `palpate completion bash`\n"
         "_palpate() {\n"
         "  local current=${COMP_WORDS[COMP_CWORD]} command='' words='' word\n"
         "  for word in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do\n"
         "    case \"${command:+$command }$word\" in\n"
         "      " +
         known +
         ") command=\"${command:+$command }$word\" ;;\n"
         "    esac\n"
         "  done\n"
         "  case $command in\n" +
         words +
         "  esac\n"
         "  # An option or a command; anything else is a file.\n"
         "  mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$current\")\n"
         "  [ ${#COMPREPLY[@]} -gt 0 ] || mapfile -t COMPREPLY < <(compgen -f -- \"$current\")\n"
         "}\n"
         "complete -o filenames -F _palpate palpate\n";
}

std::string zsh_commands(const CLI::App& parent) {
  std::string list;
  for (const CLI::App* child : subcommands_of(parent)) {
    list += " \\\n      " +
            in_shell_quotes(child->get_name() + ":" + escaped(child->get_description(), ":\\"));
  }
  return list;
}

std::string zsh_options(const CLI::App& command) {
  std::string list;
  for (const CLI::Option* option : shown_options(command)) {
    const std::string what = escaped(option->get_description(), "[]:\\");
    for (const std::string& name : spellings(*option)) {
      const std::string value = takes_value(*option) ? ":value:_files" : "";
      list += " \\\n        " + in_shell_quotes("*" + name + "[" + what + "]" + value);
    }
  }
  return list;
}

std::string zsh_script(const CLI::App& app) {
  std::string cases;
  for (const NamedCommand& each : all_commands(app)) {
    cases += "    " + in_shell_quotes(each.path) + ")\n      _arguments" + zsh_options(*each.app) +
             " \\\n        '*:file:_files' ;;\n";
  }
  std::string groups;
  for (const NamedCommand& each : all_commands(app)) {
    if (subcommands_of(*each.app).empty()) { continue; }
    groups += "  if [[ $command == " + in_shell_quotes(each.path) +
              " ]]; then\n    if (( CURRENT == 3 )); then\n      names=(" +
              zsh_commands(*each.app) +
              ")\n      _describe command names\n      return\n    fi\n"
              "    command=\"$command $words[3]\"\n  fi\n";
  }
  return "#compdef palpate\n"
         "# zsh completion of palpate; written by `palpate completion zsh`\n"
         "_palpate() {\n"
         "  local -a names\n"
         "  if (( CURRENT == 2 )); then\n    names=(" +
         zsh_commands(app) +
         ")\n    _describe command names\n    return\n  fi\n"
         "  local command=$words[2]\n" +
         groups + "  case $command in\n" + cases +
         "  esac\n"
         "}\n"
         "_palpate \"$@\"\n";
}

std::string fish_script(const CLI::App& app) {
  const auto quoted = [](const std::string& text) { return "'" + escaped(text, "'\\") + "'"; };
  std::string text =
      "# fish completion of palpate; written by `palpate completion fish`\n"
      "complete -c palpate -n __fish_use_subcommand -f\n";
  for (const NamedCommand& each : all_commands(app)) {
    const std::size_t space = each.path.rfind(' ');
    const bool inner = space != std::string::npos;
    const std::string name = inner ? each.path.substr(space + 1) : each.path;
    const std::string parent = inner ? each.path.substr(0, space) : "";
    text += "complete -c palpate -n " +
            (inner ? quoted("__fish_seen_subcommand_from " + parent) : "__fish_use_subcommand") +
            " -f -a " + name + " -d " + quoted(each.app->get_description()) + "\n";
    std::string here = "__fish_seen_subcommand_from " + name;
    if (inner) { here += "; and __fish_seen_subcommand_from " + parent; }
    for (const CLI::Option* option : shown_options(*each.app)) {
      text += "complete -c palpate -n " + quoted(here);
      for (const std::string& short_name : option->get_snames()) { text += " -s " + short_name; }
      for (const std::string& long_name : option->get_lnames()) { text += " -l " + long_name; }
      text +=
          (takes_value(*option) ? " -r -d " : " -d ") + quoted(option->get_description()) + "\n";
    }
  }
  return text;
}

int run_completion(const CompletionOptions& options) {
  const std::string& shell = options.shell;
  if (shell != "bash" && shell != "zsh" && shell != "fish") {
    throw InputError("completion " + shell + ": unknown shell; bash, zsh or fish");
  }
  const CLI::App& app = *options.program;
  const std::string script = shell == "bash"  ? bash_script(app)
                             : shell == "zsh" ? zsh_script(app)
                                              : fish_script(app);
  std::printf("%s", script.c_str());
  return done;
}

/// Text of a manual page: a hyphen that is no line break, and no line that begins with a request.
std::string man_text(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if ((c == '.' || c == '\'') && (result.empty() || result.back() == '\n')) { result += "\\&"; }
    result += c == '-' ? "\\-" : c == '\\' ? "\\e" : std::string(1, c);
  }
  return result;
}

/// Arguments of a command, then its options.
std::string man_options(const CLI::App& command) {
  const auto entry = [](const std::string& name, const CLI::Option& option) {
    return ".TP\n.B " + man_text(name) + "\n" + man_text(option.get_description()) + "\n";
  };
  std::string text;
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_positional()) { text += entry(option->get_type_name(), *option); }
  }
  for (const CLI::Option* option : shown_options(command)) {
    text += entry(joined_words(spellings(*option), ", ") +
                      (takes_value(*option) ? " " + option->get_type_name() : ""),
                  *option);
  }
  return text;
}

/// Lines of a help text, kept as they are.
std::string man_lines(const std::string& text) {
  return text.empty() ? "" : ".PP\n.nf\n" + man_text(text) + "\n.fi\n";
}

}  // namespace

std::string man_page(const CLI::App& app) {
  std::string text =
      std::string(".TH PALPATE 1 \"\" \"palpate ") + build::version +
      "\" \"User Commands\"\n.SH NAME\npalpate \\- " +
      man_text("validation and regression harness for haptic soft-tissue simulation") +
      "\n.SH SYNOPSIS\n.B palpate\n.I COMMAND\n[\\fIOPTION\\fR]...\n.SH COMMANDS\n";
  std::string task;
  const std::vector<NamedCommand> commands = all_commands(app);
  for (const NamedCommand& each : commands) {
    if (each.path.find(' ') == std::string::npos && each.app->get_group() != task) {
      task = each.app->get_group();
      text += ".SS " + man_text(task) + "\n";
    }
    text += ".TP\n.B " + man_text(each.path) + "\n" + man_text(each.app->get_description()) + "\n";
  }
  for (const NamedCommand& each : commands) {
    std::string title = each.path;
    for (char& c : title) { c = static_cast<char>(std::toupper(static_cast<unsigned char>(c))); }
    text += ".SH " + man_text(title) + "\n" + man_text(each.app->get_description()) + ".\n" +
            man_options(*each.app);
    // A command without a footer of its own has the exit codes, which have their own section.
    const std::string footer = each.app->get_footer();
    if (!app.get_footer().starts_with(footer)) { text += man_lines(footer); }
  }
  return text + ".SH FILES\n.TP\n.I palpate\\-out/COMMAND\nresults, without\n.B \\-\\-out\n" +
         ".SH EXIT STATUS\n" + man_lines(app.get_footer());
}

void add_completion(Program& program) {
  const auto [command, options] =
      add_command(program, "completion", "print the completion script of a shell", run_completion);
  options.program = &program.app;
  add_value(command, "shell", options.shell, "SHELL", "bash, zsh or fish")->required();
  writes_nothing(command);
  command.footer(
      "bash: palpate completion bash > ~/.local/share/bash-completion/completions/palpate\n"
      "`cmake --install` installs the scripts of all three and the manual page.");
}

}  // namespace palpate::cli
