// SPDX-License-Identifier: MIT
#include <cstdio>

#include "fixtures/io/file_bytes.hpp"
#include "reports/baseline_file.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/gate_inputs.hpp"
#include "reports/cli/loaded_scene.hpp"
#include "reports/gate_report.hpp"

namespace palpate::cli {

namespace {

GateReport judged(const GateOptions& options) {
  const gate::Baseline baseline = read_baseline(options.baseline);
  const Results results = read_judged(options.results);
  std::vector<std::string> names;
  for (const gate::AcceptedCase& one : baseline.cases) { names.push_back(one.outcome.name); }
  for (const Outcome& one : results.outcomes) { names.push_back(one.name); }
  GateReport report{.results = options.results.string(),
                    .baseline_file = options.baseline.string(),
                    .command = "palpate gate " + options.results.string() + " --baseline " + options.baseline.string(),
                    .provenance = results.provenance,
                    .candidate = {.command = results.command, .outcomes = results.outcomes},
                    .baseline = baseline};
  for (const std::string& each : options.cases) { report.command += " --case " + each; }
  report.verdict = gate::judge(report.baseline, report.candidate, names_of(options.cases, names));
  return report;
}

}  // namespace

int gate(const GateOptions& options) {
  const GateReport report = judged(options);
  const std::filesystem::path folder = make_folder(options.folder("gate"));
  io::replace_file(folder / "gate.json", to_json(report));
  io::replace_file(folder / "gate.xml", to_junit(report));
  io::replace_file(folder / "report.html", to_html(report));
  if (!options.quiet) {
    std::printf("%s%s\n%s; %s\n", changes_text(report.verdict).c_str(), verdict_text(report.verdict).c_str(),
                verdict_sentence(report.verdict).c_str(), (folder / "report.html").string().c_str());
  }
  return report.verdict.holds() ? done : fell_short;
}

}  // namespace palpate::cli
