// SPDX-License-Identifier: MIT
#include <cmath>

#include "reports/gate_report.hpp"
#include "reports/json_number.hpp"
#include "reports/junit.hpp"

namespace palpate {

namespace {

using Json = nlohmann::ordered_json;

Json change_json(const gate::Change& change) {
  return {{"item", change.item},           {"judgement", name_of(change.judgement)},
          {"before", json_number(change.before)}, {"now", json_number(change.now)},
          {"unit", change.unit},           {"moved", change.moved},
          {"allowed", change.allowed},     {"status", change.falls() ? "fail" : "pass"}};
}

Json case_json(const gate::CaseVerdict& verdict) {
  Json changes = Json::array();
  for (const gate::Change& change : verdict.changes) { changes.push_back(change_json(change)); }
  return {{"name", verdict.name},
          {"suite", verdict.suite},
          {"status", verdict.falls() ? "fail" : "pass"},
          {"identical", verdict.identical},
          {"better", verdict.better()},
          {"changes", changes}};
}

Json last_approval(const gate::Baseline& baseline) {
  if (baseline.ledger.empty()) { return nullptr; }
  const gate::Approval& last = baseline.ledger.back();
  return {{"date", last.date}, {"commit", last.commit}, {"reason", last.reason}};
}

/// What fell, a line each.
std::string reasons_of(const gate::CaseVerdict& verdict) {
  std::string text;
  for (const gate::Change& change : verdict.changes) {
    if (!change.falls()) { continue; }
    text += (text.empty() ? "" : "\n") + std::string(name_of(change.judgement)) + ": " + change.item +
            (change.item.empty() ? "" : " ") + change.moved +
            (change.allowed.empty() ? "" : "; allowed " + change.allowed);
  }
  return text;
}

Outcome fault_outcome(const std::string& fault) {
  return {.name = "comparison",
          .suite = "gate",
          .claim = "Results and baseline belong together.",
          .status = Status::error,
          .reason = fault};
}

}  // namespace

std::string to_json(const GateReport& report) {
  const gate::Tally sum = report.verdict.tally();
  Json cases = Json::array();
  for (const gate::CaseVerdict& one : report.verdict.cases) { cases.push_back(case_json(one)); }
  const Json json{{"schema", 1},
                  {"verdict", report.verdict.holds() ? "pass" : "fail"},
                  {"reason", verdict_text(report.verdict)},
                  {"results", report.results},
                  {"baseline", report.baseline_file},
                  {"approved", last_approval(report.baseline)},
                  {"identical", sum.identical},
                  {"unchanged", sum.unchanged},
                  {"better", sum.better},
                  {"failed", sum.fallen},
                  {"faults", report.verdict.faults},
                  {"provenance", {{"before", report.baseline.provenance}, {"now", report.provenance}}},
                  {"cases", cases}};
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string to_junit(const GateReport& report) {
  Results results{.title = "Palpate gate"};
  for (const std::string& fault : report.verdict.faults) { results.outcomes.push_back(fault_outcome(fault)); }
  for (const gate::CaseVerdict& one : report.verdict.cases) {
    results.outcomes.push_back({.name = one.name,
                                .suite = one.suite,
                                .claim = "Not worse than what was accepted.",
                                .status = one.falls() ? Status::fail : Status::pass,
                                .reason = reasons_of(one)});
  }
  return to_junit(results);
}

}  // namespace palpate
