// SPDX-License-Identifier: MIT
#pragma once
/// What a gate found, for people, for CI and for programs.

#include <map>
#include <string>

#include "reports/results/results.hpp"
#include "validation/gate/gate.hpp"

namespace palpate {

struct GateReport {
  std::string results{};  ///< folder that was judged
  std::string baseline_file{};
  std::string command{};
  std::map<std::string, std::string> provenance{};  ///< of the results
  gate::Candidate candidate{};
  gate::Baseline baseline{};
  gate::Verdict verdict{};
};

/// "FAIL: 2 of 148 cases fell".
std::string verdict_text(const gate::Verdict& verdict);
/// "140 identical, 5 within what is allowed, 1 better".
std::string verdict_sentence(const gate::Verdict& verdict);

/// What a reviewer reads: a line for every case that fell or became better, worst first, with its
/// worst change; `all`: every change of every case.
Table changes_table(const gate::Verdict& verdict, bool all);
/// The same as lines of aligned text.
std::string changes_text(const gate::Verdict& verdict);

/// gate.json and gate.xml (docs/formats.md).
std::string to_json(const GateReport& report);
std::string to_junit(const GateReport& report);

/// The page: verdict, table, then accepted and new curves laid over each other wherever one moved.
std::string to_html(const GateReport& report);

}  // namespace palpate
