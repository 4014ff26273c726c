// SPDX-License-Identifier: MIT
/// The options of --subject, and the commands `export` and `subject new`.

#include <algorithm>
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "subject_skeletons.hpp"

#include "fixtures/io/csv_file.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "fixtures/io/scene_folder.hpp"
#include "model/problem/input_error.hpp"
#include "model/tissue/network_builder.hpp"
#include "reports/cli/commands.hpp"
#include "reports/timing/child_process.hpp"
#include "validation/gate/gate.hpp"

namespace palpate::cli {

void add_subject_options(CLI::App& command, SubjectChoice& choice) {
  choice.limits.stop = &interrupted;
  if (command.get_name() != "check") {
    add_value(command, "--subject", choice.subject, "SUBJECT",
              "simulator under test: model, PATH.so, exec:COMMAND or trace:FILE.csv [model]");
  }
  add_value(command, "--subject-options", choice.options_json, "JSON",
            "object that the simulator receives when it loads a scene [{}]")
      ->check([](const std::string& text) {
        const auto json = nlohmann::json::parse(text, nullptr, false);
        return json.is_object() ? std::string() : "not a JSON object: " + io::shown(text);
      });
  command.add_flag("--in-process", choice.in_process,
                   "run a shared library in this process, for profilers; a crash ends the program");
  command
      .add_option("--subject-time-limit", choice.limits.call_seconds,
                  "seconds for a call to the simulator, six times as many to load [10]")
      ->check(number_range(1e-3, 1e6));
  command
      .add_option("--subject-memory-limit", choice.limits.memory_mib,
                  "memory of the simulator's process in MiB [4096]")
      ->check(number_range(1.0, 1e9));
  add_value(command, "--column", choice.columns, "NAME=ROLE",
            "column of a trace and its role: a column of trace.csv, with _ms, _mm, _mN, _kPa or "
            "_mmHg for other units; repeatable");
  command.parse_complete_callback([&choice] {
    if (choice.columns.empty() || choice.subject.starts_with("trace:")) { return; }
    throw CLI::ValidationError("--column",
                               "assigns columns of --subject trace:FILE.csv, which is "
                               "not given; `palpate import FILE --column NAME=ROLE` "
                               "reads columns of a recording");
  });
}

std::filesystem::path default_cache_folder() {
  if (const char* folder = std::getenv("XDG_CACHE_HOME"); folder != nullptr && *folder != '\0') {
    return std::filesystem::path(folder) / "palpate";
  }
  if (const char* home = std::getenv("HOME"); home != nullptr && *home != '\0') {
    return std::filesystem::path(home) / ".cache" / "palpate";
  }
  return io::private_folder("palpate-cache");
}

SubjectChoice confined(const SubjectChoice& choice, const CommonOptions& options,
                       const std::vector<std::filesystem::path>& more) {
  SubjectChoice result = choice;
  if (!choice.foreign()) { return result; }
  result.limits.hidden = more;
  result.limits.hidden.push_back(default_cache_folder());
  result.limits.hidden.push_back(options.output_folder());
  return result;
}

std::vector<std::filesystem::path> files_of_subject(const std::string& subject) {
  constexpr std::string_view command = "exec:";
  constexpr std::string_view trace = "trace:";
  if (subject.empty() || subject == "model") { return {}; }
  if (subject.starts_with(trace)) { return {subject.substr(trace.size())}; }
  if (!subject.starts_with(command)) { return {subject}; }
  std::vector<std::filesystem::path> files;
  for (const std::string& word : gate::shell_words(subject.substr(command.size()))) {
    std::error_code unknown;
    const bool is_file = std::filesystem::is_regular_file(word, unknown);
    if (is_file) { files.emplace_back(word); }
    if (is_file || !files.empty() || word.find('/') != word.npos) { continue; }
    if (auto program = timing::find_program(word); !program.empty()) {
      files.push_back(std::move(program));
    }
  }
  return files;
}

std::string hash_of_subject(const std::string& subject) {
  const std::vector<std::filesystem::path> files = files_of_subject(subject);
  if (!subject.starts_with("exec:")) { return io::sha256_of_file(files.at(0)); }
  std::string all = subject;
  for (const std::filesystem::path& file : files) { all += "\n" + io::sha256_of_file(file); }
  return io::sha256(all);
}

std::map<std::string, std::string> subject_provenance(const SubjectFacts& facts) {
  return {{"subject", facts.name + " " + facts.version},
          {"subject licence", facts.licence},
          {"subject carrier", facts.carrier},
          {"subject capabilities", names_of(facts.capabilities)},
          {"subject confinement", facts.confinement.empty() ? "none" : facts.confinement}};
}

namespace {

namespace fs = std::filesystem;

struct ExportOptions : CommonOptions {
  fs::path scene{};
};

int run_export(const ExportOptions& options) {
  const io::SceneFile file = io::read_scene(options.scene, options.overrides);
  const SpringNetwork network =
      file.scene.tissue.source == Source::oscillator ? SpringNetwork{} : build_network(file.scene);
  std::string needs;
  try {
    needs = names_of(needs_of(file.scene, network));
  } catch (const CannotDo& reason) {
    std::fprintf(stderr, "palpate: warning: %s: %s\n",
                 io::printable(options.scene.string()).c_str(),
                 io::printable(reason.what()).c_str());
  }
  const fs::path folder = options.make_folder(
      {"initial.csv", "inputs/", "layers.csv", "loads.csv", "manifest.json", "nodes.csv",
       "record.csv", "scene.toml", "settings.csv", "springs.csv", "tool.csv"});
  const io::WholeWrite whole;
  io::write_scene_folder(folder, {.scene = file.scene,
                                  .network = network,
                                  .needs = needs,
                                  .abi = PALPATE_SUBJECT_ABI,
                                  .file = &file});
  std::printf("%s: %td nodes, %zu springs; needs %s\n", io::printable(folder.string()).c_str(),
              network.node_count(), network.springs.size(),
              needs.empty() ? "what only the model has" : needs.c_str());
  return done;
}

struct Skeleton {
  std::string_view language;
  std::vector<TemplateFile> files;
  std::string_view next;  ///< how to build and check it
};

const std::array<Skeleton, 3>& skeletons() {
  static const std::array<Skeleton, 3> all{
      Skeleton{"c",
               {{"subject.c", skeletons::subject_c},
                {"palpate_subject.h", skeletons::palpate_subject_h},
                {"CMakeLists.txt", skeletons::cmake_lists}},
               "cmake -S . -B build && cmake --build build && palpate subject check "
               "build/subject.so"},
      Skeleton{"python",
               {{"subject.py", skeletons::subject_py}},
               "palpate subject check \"exec:python3 subject.py\""},
      Skeleton{"javascript",
               {{"subject.mjs", skeletons::subject_mjs}},
               "palpate subject check \"exec:node subject.mjs\""}};
  return all;
}

struct NewOptions : CommonOptions {
  std::string language = "c";
  fs::path folder{};
};

int run_new(const NewOptions& options) {
  const std::string next = write_subject_skeleton(options.language, options.folder);
  std::printf("%s\n", io::printable(next).c_str());
  return done;
}

}  // namespace

std::string write_subject_skeleton(const std::string& language, const fs::path& folder) {
  const auto found = std::ranges::find(skeletons(), language, &Skeleton::language);
  if (found == skeletons().end()) {
    throw InputError("--language " + io::shown(language) + ": unknown; c, python or javascript");
  }
  write_new_folder(folder, found->files);
  return "cd " + in_shell_quotes(folder.string()) + " && " + std::string(found->next);
}

void add_export(Program& program) {
  const auto [command, options] =
      add_command(program, "export", "write a scene as CSV files for other simulators", run_export);
  add_scene(command, options, options.scene);
}

void add_subject(Program& program) {
  CLI::App* subject = program.app.add_subcommand("subject", "other simulators under test");
  subject->require_subcommand(1);
  add_subject_check(program, *subject);
  const auto [command, options] =
      add_command(program, "new", "write the skeleton of a simulator", run_new, subject);
  command.remove_option(command.get_option("--out"));  // DIR is the folder
  add_value(command, "folder", options.folder, "DIR", "new folder")->required();
  add_value(command, "--language", options.language, "LANGUAGE", "c, python or javascript [c]");
}

}  // namespace palpate::cli
