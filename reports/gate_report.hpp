// SPDX-License-Identifier: MIT
#pragma once
/// The result of a gate as text, JSON, JUnit and a page.

#include <map>
#include <string>

#include "reports/results/results.hpp"
#include "validation/gate/gate.hpp"

namespace palpate {

struct GateReport {
  std::string results{};  ///< folder of the results
  std::string baseline_file{};
  std::string command{};
  std::map<std::string, std::string> provenance{};  ///< of the results
  gate::Candidate candidate{};
  gate::Baseline baseline{};
  gate::GateResult result{};
};

/// "FAIL: 2 of 148 cases regressed".
std::string verdict_text(const gate::GateResult& result);
/// "140 identical, 5 within what is allowed, 1 better".
std::string verdict_sentence(const gate::GateResult& result);

/// One row for each case that failed or became better, worst first, with its worst change; `all`:
/// every change of every case.
Table changes_table(const gate::GateResult& result, bool all);
/// The same as lines of aligned text.
std::string changes_text(const gate::GateResult& result);

/// gate.json and gate.xml (docs/formats.md).
std::string to_json(const GateReport& report);
std::string to_junit(const GateReport& report);

/// The page: verdict, table of changes, and each changed curve with the accepted one.
std::string to_html(const GateReport& report);

}  // namespace palpate
