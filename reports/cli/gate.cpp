// SPDX-License-Identifier: MIT
/// The commands `gate` and `approve`.

#include <algorithm>
#include <cstdio>
#include <sstream>

#include "fixtures/io/child_read.hpp"
#include "fixtures/io/file_bytes.hpp"
#include "model/kernels/instruction_set.hpp"
#include "model/problem/input_error.hpp"
#include "reports/cli/commands.hpp"
#include "reports/gate_report.hpp"
#include "reports/results/results.hpp"
#include "reports/results/results_folder.hpp"
#include "reports/timing/child_process.hpp"
#include "validation/gate/baseline.hpp"

namespace palpate::cli {
namespace {

struct GateOptions : CommonOptions {
  std::filesystem::path results{};
  std::filesystem::path baseline{};
  std::vector<std::string> cases{};  ///< case names or groups; empty: all
  SubjectChoice subject{};           ///< must have made the results, if given
};

struct ApproveOptions : GateOptions {
  std::string reason{};
  std::vector<std::filesystem::path> spreads{};  ///< results of other builds or orders
  std::vector<std::string> failing{};            ///< cases or groups that are accepted nevertheless
  bool no_variants = false;
};

/// Reads a results folder of validate or bench, or the folder of a run. Throws InputError.
Results read_judged(const std::filesystem::path& folder) {
  if (!std::filesystem::is_directory(folder)) {
    throw InputError(folder.string() +
                     ": is not a folder; the results folder of validate, bench or run is needed");
  }
  return is_run_folder(folder) ? read_run_folder(folder) : read_results_folder(folder);
}

/// Names of the cases that the patterns of an option select, by the rule of `validate`; empty
/// without patterns. Throws InputError for a pattern that selects nothing.
std::vector<std::string> names_selected(const std::vector<std::string>& patterns,
                                        const std::vector<std::string>& names,
                                        const std::string& option = "--case") {
  std::vector<std::string> selected;
  for (const std::string& pattern : patterns) {
    bool found = false;
    for (const std::string& name : names) {
      if (name != pattern && !name.starts_with(pattern + "/")) { continue; }
      found = true;
      if (std::ranges::find(selected, name) == selected.end()) { selected.push_back(name); }
    }
    if (!found) {
      throw InputError(option + " " + pattern +
                       ": selects nothing; a case or a group of the results or the baseline");
    }
  }
  return selected;
}

std::vector<std::string> names_in(const Results& results) {
  std::vector<std::string> names;
  for (const Outcome& one : results.outcomes) { names.push_back(one.name); }
  return names;
}

/// Name of the simulator that made results, without its version: versions may be compared.
std::string simulator_in(const std::map<std::string, std::string>& provenance) {
  const std::string subject = entry(provenance, "subject");
  return subject.empty() ? "palpate" : subject.substr(0, subject.rfind(' '));
}

/// Throws InputError if results and baseline are of different commands or simulators, or not of
/// --subject.
void check_simulator(const GateOptions& options, const Results& results,
                     const gate::Baseline& baseline) {
  const bool baseline_of_run = baseline.find("run") != nullptr;
  const bool results_of_run = std::ranges::count(results.outcomes, "run", &Outcome::name) > 0;
  if (!baseline.cases.empty() && baseline_of_run != results_of_run) {
    const auto maker = [](bool run) { return run ? "palpate run" : "palpate validate or bench"; };
    throw InputError(options.baseline.string() + ": is a baseline of `" + maker(baseline_of_run) +
                     "`; " + options.results.string() + " holds results of `" +
                     maker(results_of_run) + "`. A baseline of its own is needed");
  }
  const std::string found = simulator_in(results.provenance);
  const std::string accepted = simulator_in(baseline.provenance);
  if (!baseline.cases.empty() && found != accepted) {
    throw InputError(options.results.string() + ": results of the simulator " + found + "; " +
                     options.baseline.string() + " holds those of " + accepted +
                     ". Each simulator needs a baseline of its own");
  }
  if (options.subject.subject.empty()) { return; }
  if (!options.subject.foreign() && !entry(results.provenance, "subject").empty()) {
    throw InputError(options.results.string() + ": results of the simulator " + found +
                     " behind the interface of subjects; --subject is the model in the program");
  }
  const std::string wanted = make_subject(options.subject)->facts().name;
  if (found != wanted) {
    throw InputError(options.results.string() + ": results of the simulator " + found +
                     "; --subject is " + wanted);
  }
}

int run_gate(const GateOptions& options) {
  const gate::Baseline baseline = read_baseline(options.baseline);
  const Results results = read_judged(options.results);
  check_simulator(options, results, baseline);
  std::vector<std::string> names;
  for (const gate::AcceptedCase& one : baseline.cases) { names.push_back(one.outcome.name); }
  for (const Outcome& one : results.outcomes) { names.push_back(one.name); }
  GateReport report{.results = options.results.string(),
                    .baseline_file = options.baseline.string(),
                    .command = options.command,
                    .provenance = results.provenance,
                    .candidate = {.command = results.command, .outcomes = results.outcomes},
                    .baseline = baseline};
  report.result =
      gate::compare(report.baseline, report.candidate, names_selected(options.cases, names));
  const std::filesystem::path folder =
      options.make_folder({"gate.json", "gate.xml", "report.html"});
  refuse_folder_of(options.results, folder);
  const io::WholeWrite whole;
  io::replace_file(folder / "gate.json", to_json(report));
  io::replace_file(folder / "gate.xml", to_junit(report));
  io::replace_file(folder / "report.html", to_html(report));
  if (!options.quiet) { std::printf("%s", printable_lines(changes_text(report.result)).c_str()); }
  std::printf("%s\n", in_colour(io::printable(verdict_text(report.result)),
                                report.result.holds() ? Status::pass : Status::fail)
                          .c_str());
  if (!options.quiet) {
    std::printf("%s; %s\n%s\n", verdict_sentence(report.result).c_str(),
                io::printable((folder / "report.html").string()).c_str(),
                builds_text(report).c_str());
    if (!report.result.holds()) {
      std::printf("if the change is intended: palpate approve %s --baseline %s --reason \"why\"\n",
                  io::printable(in_shell_quotes(options.results.string())).c_str(),
                  io::printable(in_shell_quotes(options.baseline.string())).c_str());
    }
  }
  return report.result.holds() ? done : fell_short;
}

// Rounding of a run, measured by running its scene again.

/// Throws InputError unless this program made the run, from the scene as it is now.
void check_repeatable(const ApproveOptions& options, const Results& results,
                      const std::map<std::string, std::string>& inputs) {
  constexpr const char* remedy = "; run it again, or give --spread or --no-variants";
  const std::string about = options.results.string() +
                            ": the effect of rounding is measured by "
                            "running the scene again, but ";
  const std::map<std::string, std::string> own = build_provenance();
  for (const char* key : {"commit", "compiler", "flags"}) {
    const std::string made_by = entry(results.provenance, key);
    if (made_by == own.at(key)) { continue; }
    throw InputError(about + "the run is of another program: " + key + " " + made_by +
                     ", this is " + own.at(key) + remedy);
  }
  if (const std::string file = changed_file(files_of_run(inputs)); !file.empty()) {
    throw InputError(about + "its input " + file + " is gone or changed" + remedy);
  }
}

/// Runs the scene of a run folder with the other instruction sets of this machine and with the C
/// library's functions for older processors.
std::vector<std::vector<Outcome>> run_variants(const ApproveOptions& options,
                                               const Results& results) {
  const std::map<std::string, std::string> inputs = inputs_of_run(options.results);
  check_repeatable(options, results, inputs);
  std::vector<std::string> environments{
      "GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA,-AVX2_Usable,-FMA_Usable",
      "PALPATE_INSTRUCTIONS=baseline"};
  if (has_avx2()) { environments.emplace_back("PALPATE_INSTRUCTIONS=avx2"); }
  if (has_avx512()) { environments.emplace_back("PALPATE_INSTRUCTIONS=avx512"); }
  std::vector<std::vector<Outcome>> variants;
  for (const std::string& environment : environments) {
    const io::ScratchFolder scratch;
    std::vector<std::string> words{"/usr/bin/env",
                                   environment,
                                   timing::own_program().string(),
                                   "run",
                                   entry(inputs, "scene_file"),
                                   "--quiet",
                                   "--no-view",
                                   "--out",
                                   scratch.path().string()};
    std::istringstream overrides(entry(inputs, "overrides"));
    for (std::string line; std::getline(overrides, line);) {
      words.insert(words.end(), {"--set", line});
    }
    if (const std::string script = entry(inputs, "script"); !script.empty()) {
      words.insert(words.end(), {"--script", script});
    }
    if (!entry(inputs, "no_skip").empty()) { words.emplace_back("--no-skip"); }
    if (const std::string every = entry(inputs, "every"); !every.empty()) {
      words.insert(words.end(), {"--every", every});
    }
    if (!options.quiet) {
      std::printf("run again with %s\n", environment.c_str());
      std::fflush(stdout);
    }
    const timing::ChildEnd end = timing::run_child(words, &interrupted);
    if (end.stopped) { throw io::ReadInterrupted(); }
    if (end.status != done) {
      throw InputError(options.results.string() + ": its scene with " + environment + ": " +
                       end.last_words() + "; a run that ends well in each variant");
    }
    variants.push_back(read_run_folder(scratch.path()).outcomes);
  }
  return variants;
}

/// Returns results that differ from these by rounding alone; none if they are not to be measured.
std::vector<std::vector<Outcome>> variants_of(const ApproveOptions& options,
                                              const Results& results) {
  std::vector<std::vector<Outcome>> variants;
  for (const std::filesystem::path& folder : options.spreads) {
    variants.push_back(read_judged(folder).outcomes);
    for (const Outcome& one : variants.back()) {
      const auto same = std::ranges::find(results.outcomes, one.name, &Outcome::name);
      const bool ends_alike = same == results.outcomes.end() || same->status == one.status;
      if (ends_alike || one.status == Status::pass || one.status == Status::skip) { continue; }
      throw InputError(folder.string() + ": case " + one.name + " is " +
                       std::string(name_of(one.status)) + ", " + options.results.string() +
                       " has " + std::string(name_of(same->status)) +
                       "; --spread takes results that differ by rounding alone");
    }
  }
  const bool measured = variants.empty() && !options.no_variants &&
                        is_run_folder(options.results) &&
                        entry(results.provenance, "subject").empty() &&
                        results.outcomes.front().status == Status::pass;
  return measured ? run_variants(options, results) : variants;
}

/// Creates the folder of the baseline if it does not exist, and locks it.
void lock_baseline(const std::filesystem::path& baseline) {
  const std::filesystem::path folder =
      baseline.has_parent_path() ? baseline.parent_path() : std::filesystem::path(".");
  std::error_code problem;
  std::filesystem::create_directories(folder, problem);
  if (problem) { throw InputError(folder.string() + ": " + problem.message() + "; a folder"); }
  lock_folder(folder);
}

int run_approve(const ApproveOptions& options) {
  keep_results_of_interrupted();
  if (options.reason.find_first_not_of(" \t\n") == std::string::npos) {
    throw InputError("--reason: is empty; the reason of the change is recorded in the ledger");
  }
  const Results results = read_judged(options.results);
  const auto accepted_before = [&] {
    const bool exists = std::filesystem::exists(options.baseline);
    gate::Baseline before = exists ? read_baseline(options.baseline) : gate::Baseline{};
    check_simulator(options, results, before);
    return before;
  };
  (void)accepted_before();  // refuses a wrong file before the variants are run, which takes longer
  const gate::Acceptance acceptance{
      .command = results.command,
      .provenance = results.provenance,
      .date = build_provenance().at("date"),
      .reason = options.reason,
      .outcomes = results.outcomes,
      .only = names_selected(options.cases, names_in(results)),
      .failing = names_selected(options.failing, names_in(results), "--accept-failing"),
      .variants = variants_of(options, results)};
  lock_baseline(options.baseline);
  const gate::Baseline old = accepted_before();
  const gate::Baseline updated = gate::accept(old, acceptance);
  for (const std::string& line : gate::described_changes(old, updated)) {
    if (!options.quiet) { std::printf("%s\n", io::printable(line).c_str()); }
  }
  if (const std::string commit = entry(results.provenance, "commit"); gate::is_dirty(commit)) {
    std::fprintf(stderr,
                 "palpate: warning: made by %s, a build with uncommitted changes, which cannot be "
                 "repeated\n",
                 io::printable(commit).c_str());
  }
  write_baseline(options.baseline, updated);
  std::printf("%zu of %zu cases accepted; %s\n", updated.ledger.back().cases.size(),
              updated.cases.size(), io::printable(options.baseline.string()).c_str());
  return done;
}

void add_judged(CLI::App& command, GateOptions& options) {
  add_value(command, "results", options.results, "RESULTS",
            "results folder of validate, bench or run")
      ->required();
  add_value(command, "--baseline", options.baseline, "FILE",
            "accepted results (JSON; curves in an .h5 file beside it)")
      ->required();
  add_value(command, "--case", options.cases, "NAME", "only this case or group; repeatable [all]");
  add_value(command, "--subject", options.subject.subject, "SUBJECT",
            "simulator that must have made the results: model, PATH.so, exec:COMMAND [any]");
}

}  // namespace

void add_gate(Program& program) {
  const auto [command, options] =
      add_command(program, "gate", "compare results with a baseline", run_gate);
  add_judged(command, options);
  add_json(command, options, "gate.json");
  command.footer(
      "Writes gate.json, gate.xml (JUnit) and report.html. Exit codes: 0 no case became worse, 1 a "
      "case\ndid or cannot be compared, 2 bad input. docs/gate.md has the rules.");
}

void add_approve(Program& program) {
  const auto [command, options] =
      add_command(program, "approve", "accept results as the new baseline", run_approve);
  add_judged(command, options);
  add_value(command, "--reason", options.reason, "TEXT",
            "why numbers may change; recorded in the ledger")
      ->required();
  add_value(command, "--spread", options.spreads, "RESULTS",
            "results of the same cases by another build or order of summation, to measure the "
            "effect of rounding; repeatable [a run is run again with other instruction sets]");
  add_value(command, "--accept-failing", options.failing, "NAME",
            "accept this case or group although it fails; repeatable");
  command.add_flag("--no-variants", options.no_variants,
                   "do not run the scene of a run again to measure the effect of rounding");
  command.footer(
      "Prints the old value, the new value and the bound of every change, then writes FILE\nand "
      "its curves. Results that ended in an error, are not finite or fail are refused. "
      "docs/gate.md has "
      "more.");
}

}  // namespace palpate::cli
