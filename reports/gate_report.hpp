// SPDX-License-Identifier: MIT
#pragma once
/// Result of a gate as text, JSON, JUnit and HTML.

#include <map>
#include <string>

#include "reports/results/results.hpp"
#include "validation/gate/gate.hpp"

namespace palpate {

struct GateReport {
  std::string results{};  ///< path of the results folder
  std::string baseline_file{};
  std::string command{};
  std::map<std::string, std::string> provenance{};  ///< provenance of the results
  gate::Candidate candidate{};
  gate::Baseline baseline{};
  gate::GateResult result{};
};

/// Verdict of a gate: "FAIL: 2 of 148 cases regressed".
std::string verdict_text(const gate::GateResult& result);
/// Counts of the other cases: "140 identical, 5 within what is allowed, 1 better".
std::string verdict_sentence(const gate::GateResult& result);

/// Line that names the builds and processors of the results and of the baseline.
std::string builds_text(const GateReport& report);

/// Table with one row for each case that failed or improved, worst first, with its worst change, as
/// lines of aligned text.
std::string changes_text(const gate::GateResult& result);

/// Contents of gate.json and gate.xml (docs/formats.md).
std::string to_json(const GateReport& report);
std::string to_junit(const GateReport& report);

/// HTML page: verdict, table of changes, and each changed curve with the accepted one.
std::string to_html(const GateReport& report);

}  // namespace palpate
