// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>

#include "reports/gate_report.hpp"
#include "reports/markup.hpp"

namespace palpate {

namespace {

using gate::CaseVerdict;
using gate::Change;
using gate::Judgement;

bool is_told(const Change& change) { return change.falls() || change.judgement == Judgement::better; }

/// Curves have no single number.
std::string number_of(const Change& change, double value) {
  const bool number = change.before != 0.0 || change.now != 0.0;
  return number ? plain_number(value, digits_apart(change.before, change.now)) + " " + change.unit : "";
}

std::vector<std::string> row_of(const CaseVerdict& verdict, const Change& change) {
  return {std::string(name_of(change.judgement)),  verdict.name,
          change.item,                             number_of(change, change.before),
          number_of(change, change.now),           change.moved,
          change.allowed};
}

/// Of a case as a whole: its worst change, and how many more there are.
std::vector<std::string> summary_of(const CaseVerdict& verdict) {
  std::vector<std::string> row = row_of(verdict, verdict.changes.front());
  const auto more = std::ranges::count_if(verdict.changes, [](const Change& one) { return is_told(one); }) - 1;
  if (more > 0) { row[2] += (row[2].empty() ? "and " : ", and ") + std::to_string(more) + " more"; }
  return row;
}

/// Worst first, and within a kind in the order of the cases.
std::vector<std::vector<std::string>> rows_of(const gate::Verdict& verdict, bool all) {
  std::vector<std::pair<Judgement, std::vector<std::string>>> rows;
  for (const CaseVerdict& one : verdict.cases) {
    if (all) {
      for (const Change& change : one.changes) { rows.emplace_back(change.judgement, row_of(one, change)); }
    } else if (one.falls() || one.better()) {
      rows.emplace_back(one.changes.front().judgement, summary_of(one));
    }
  }
  std::ranges::stable_sort(rows, std::ranges::greater{}, [](const auto& row) { return static_cast<int>(row.first); });
  std::vector<std::vector<std::string>> texts;
  for (auto& [judgement, row] : rows) { texts.push_back(std::move(row)); }
  return texts;
}

constexpr std::array<const char*, 7> heads{"", "case", "what", "before", "now", "moved by", "allowed"};

}  // namespace

std::string verdict_text(const gate::Verdict& verdict) {
  const std::string of = " of " + std::to_string(verdict.cases.size()) + " cases ";
  if (verdict.holds()) { return "PASS: none" + of + "became worse"; }
  if (verdict.tally().fallen == 0) { return "FAIL: " + verdict.faults.front(); }
  return "FAIL: " + std::to_string(verdict.tally().fallen) + of + "fell";
}

std::string verdict_sentence(const gate::Verdict& verdict) {
  const gate::Tally sum = verdict.tally();
  std::string text = std::to_string(sum.identical) + " identical to the last bit, " +
                     std::to_string(sum.unchanged) + " within rounding or what is allowed, " +
                     std::to_string(sum.better) + " better, " + std::to_string(sum.fallen) + " fell";
  return sum.better > 0 ? text + "; `palpate approve` keeps what is better" : text;
}

Table changes_table(const gate::Verdict& verdict, bool all) {
  Table table{.id = "changes", .title = all ? "Everything that changed" : "What fell, and what is better"};
  table.columns.assign(heads.begin(), heads.end());
  for (const std::vector<std::string>& row : rows_of(verdict, all)) {
    table.rows.emplace_back(row.begin(), row.end());
  }
  return table;
}

std::string changes_text(const gate::Verdict& verdict) {
  std::vector<std::vector<std::string>> rows = rows_of(verdict, false);
  if (rows.empty()) { return {}; }
  rows.insert(rows.begin(), std::vector<std::string>(heads.begin(), heads.end()));
  std::array<std::size_t, heads.size()> width{};
  for (const auto& row : rows) {
    for (std::size_t n = 0; n < heads.size(); ++n) { width[n] = std::max(width[n], row[n].size()); }
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t n = 0; n < heads.size(); ++n) {
      line += row[n] + std::string(width[n] - row[n].size() + 2, ' ');
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

}  // namespace palpate
