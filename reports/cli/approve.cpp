// SPDX-License-Identifier: MIT
#include <cstdio>

#include "model/dynamics/scene_check.hpp"
#include "reports/baseline_file.hpp"
#include "reports/cli/commands.hpp"
#include "reports/cli/gate_inputs.hpp"
#include "reports/cli/provenance.hpp"
#include "validation/gate/approval.hpp"

namespace palpate::cli {

namespace {

/// What it replaces, what replaces it, and what the truth is by the case's own bounds.
void show(const gate::Baseline& baseline, const gate::Baseline& updated) {
  for (const std::string& line : gate::described_changes(baseline, updated)) { std::printf("%s\n", line.c_str()); }
}

std::vector<std::vector<Outcome>> read_variants(const std::vector<std::filesystem::path>& folders) {
  std::vector<std::vector<Outcome>> variants;
  for (const std::filesystem::path& folder : folders) { variants.push_back(read_judged(folder).outcomes); }
  return variants;
}

std::vector<std::string> names_in(const Results& results) {
  std::vector<std::string> names;
  for (const Outcome& one : results.outcomes) { names.push_back(one.name); }
  return names;
}

}  // namespace

int approve(const ApproveOptions& options) {
  if (options.reason.find_first_not_of(" \t\n") == std::string::npos) {
    throw InputError("--reason: is empty; why the numbers may change, for who reads the ledger");
  }
  const Results results = read_judged(options.results);
  const bool exists = std::filesystem::exists(options.baseline);
  const gate::Baseline old = exists ? read_baseline(options.baseline) : gate::Baseline{};
  const gate::Acceptance acceptance{.command = results.command,
                                    .provenance = results.provenance,
                                    .date = build_provenance().at("date"),
                                    .reason = options.reason,
                                    .outcomes = results.outcomes,
                                    .only = names_of(options.cases, names_in(results)),
                                    .variants = read_variants(options.spreads)};
  const gate::Baseline updated = gate::accept(old, acceptance);
  if (!options.quiet) { show(old, updated); }
  write_baseline(options.baseline, updated);
  if (!options.quiet) {
    std::printf("%zu of %zu cases taken in; %s\n", updated.ledger.back().cases.size(), updated.cases.size(),
                options.baseline.string().c_str());
  }
  return done;
}

}  // namespace palpate::cli
