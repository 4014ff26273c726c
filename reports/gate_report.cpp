// SPDX-License-Identifier: MIT

#include "reports/gate_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "reports/html/html_page.hpp"
#include "reports/html/results_page.hpp"
#include "reports/plot/figure_svg.hpp"
#include "reports/results/results.hpp"
#include "reports/results/results_json.hpp"
#include "validation/gate/change.hpp"

namespace palpate {

namespace {

using gate::CaseVerdict;
using gate::Change;
using gate::Judgement;

bool is_told(const Change& change) {
  return change.falls() || change.judgement == Judgement::better;
}

/// Curves have no single number.
std::string number_of(const Change& change, double value) {
  const bool number = change.before != 0.0 || change.now != 0.0;
  return number ? plain_number(value, digits_apart(change.before, change.now)) + " " + change.unit
                : "";
}

std::vector<std::string> row_of(const CaseVerdict& verdict, const Change& change) {
  return {std::string(name_of(change.judgement)),
          verdict.name,
          change.item,
          number_of(change, change.before),
          number_of(change, change.now),
          change.moved,
          change.allowed};
}

/// Of a case as a whole: its worst change, and how many more there are.
std::vector<std::string> summary_of(const CaseVerdict& verdict) {
  std::vector<std::string> row = row_of(verdict, verdict.changes.front());
  const auto more =
      std::ranges::count_if(verdict.changes, [](const Change& one) { return is_told(one); }) - 1;
  if (more > 0) { row[2] += (row[2].empty() ? "and " : ", and ") + std::to_string(more) + " more"; }
  return row;
}

/// Worst first, and within a kind in the order of the cases.
std::vector<std::vector<std::string>> rows_of(const gate::Verdict& verdict, bool all) {
  std::vector<std::pair<Judgement, std::vector<std::string>>> rows;
  for (const CaseVerdict& one : verdict.cases) {
    if (all) {
      for (const Change& change : one.changes) {
        rows.emplace_back(change.judgement, row_of(one, change));
      }
    } else if (one.falls() || one.better()) {
      rows.emplace_back(one.changes.front().judgement, summary_of(one));
    }
  }
  std::ranges::stable_sort(rows, std::ranges::greater{},
                           [](const auto& row) { return static_cast<int>(row.first); });
  std::vector<std::vector<std::string>> texts;
  for (auto& [judgement, row] : rows) { texts.push_back(std::move(row)); }
  return texts;
}

constexpr std::array<const char*, 7> heads{"",    "case",     "what",   "before",
                                           "now", "moved by", "allowed"};

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
                     std::to_string(sum.better) + " better, " + std::to_string(sum.fallen) +
                     " fell";
  return sum.better > 0 ? text + "; `palpate approve` keeps what is better" : text;
}

Table changes_table(const gate::Verdict& verdict, bool all) {
  Table table{.id = "changes",
              .title = all ? "Everything that changed" : "What fell, and what is better"};
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

namespace {

using Json = nlohmann::ordered_json;

Json change_json(const gate::Change& change) {
  return {{"item", change.item},
          {"judgement", name_of(change.judgement)},
          {"before", json_number(change.before)},
          {"now", json_number(change.now)},
          {"unit", change.unit},
          {"moved", change.moved},
          {"allowed", change.allowed},
          {"status", change.falls() ? "fail" : "pass"}};
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
    text += (text.empty() ? "" : "\n") + std::string(name_of(change.judgement)) + ": " +
            change.item + (change.item.empty() ? "" : " ") + change.moved +
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
  const Json json{
      {"schema", 1},
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
  for (const std::string& fault : report.verdict.faults) {
    results.outcomes.push_back(fault_outcome(fault));
  }
  for (const gate::CaseVerdict& one : report.verdict.cases) {
    results.outcomes.push_back({.name = one.name,
                                .suite = one.suite,
                                .claim = "Not worse than what was accepted.",
                                .status = one.falls() ? Status::fail : Status::pass,
                                .reason = reasons_of(one)});
  }
  return to_junit(results);
}

namespace {

constexpr std::size_t most_drawn = 40;  ///< beyond that a picture more tells no reader anything

/// The tube in y around what was accepted, as a band.
Series tube_of(const Figure& before, std::size_t series) {
  const Series& curve = before.series[series];
  const double half = gate::tube_around(before, series).y;
  Series band{.label = "allowed", .style = Series::Style::band, .x = curve.x};
  for (const double y : curve.y) {
    band.y.push_back(before.y.logarithmic ? y * std::pow(10.0, -half) : y - half);
    band.y2.push_back(before.y.logarithmic ? y * std::pow(10.0, half) : y + half);
  }
  return band;
}

/// Accepted and new, one over the other.
Figure overlay(const std::string& case_name, const Figure& before, const Figure* now,
               std::size_t series) {
  Figure figure{.id = before.id + "-" + std::to_string(series),
                .title = case_name + ": " + gate::curve_name(before, series),
                .caption = before.title,
                .x = before.x,
                .y = before.y};
  const Series& curve = before.series[series];
  const bool drawn = curve.style != Series::Style::points && std::ranges::is_sorted(curve.x);
  if (drawn && curve.y2.empty()) { figure.series.push_back(tube_of(before, series)); }
  figure.series.push_back(before.series[series]);
  figure.series.back().label = "accepted";
  if (now == nullptr || series >= now->series.size()) { return figure; }
  figure.series.push_back(now->series[series]);
  figure.series.back().label = "now";
  if (figure.series.back().style == Series::Style::line) {
    figure.series.back().style = Series::Style::dashed;
  }
  return figure;
}

const Figure* figure_named(const std::vector<Figure>& figures, const std::string& id) {
  const auto found = std::ranges::find(figures, id, &Figure::id);
  return found == figures.end() ? nullptr : &*found;
}

bool has_changed(const gate::CaseVerdict& verdict, const std::string& item) {
  return std::ranges::any_of(verdict.changes, [&](const gate::Change& change) {
    return change.item == item && change.judgement != gate::Judgement::rounding;
  });
}

/// Of the curves of one case that moved by more than rounding.
void add_overlays(const GateReport& report, const gate::CaseVerdict& verdict,
                  std::vector<Figure>& figures) {
  const gate::AcceptedCase* accepted = report.baseline.find(verdict.name);
  const auto now = std::ranges::find(report.candidate.outcomes, verdict.name, &Outcome::name);
  if (accepted == nullptr || now == report.candidate.outcomes.end()) { return; }
  const Outcome shown = gate::comparable(*now);
  for (const Figure& before : accepted->outcome.figures) {
    for (std::size_t n = 0; n < before.series.size(); ++n) {
      if (!has_changed(verdict, gate::curve_name(before, n))) { continue; }
      figures.push_back(overlay(verdict.name, before, figure_named(shown.figures, before.id), n));
    }
  }
}

std::string curves_section(const GateReport& report) {
  std::vector<Figure> figures;
  for (const bool fallen : {true, false}) {
    for (const gate::CaseVerdict& one : report.verdict.cases) {
      if (one.falls() == fallen) { add_overlays(report, one, figures); }
    }
  }
  if (figures.empty()) { return {}; }
  const std::size_t count = figures.size();
  figures.resize(std::min(count, most_drawn));
  std::vector<const Figure*> drawn;
  for (const Figure& figure : figures) { drawn.push_back(&figure); }
  const std::vector<std::string> svgs = draw_figures(drawn);
  std::string html = "<section>\n<h2>Curves that moved</h2>\n";
  if (count > most_drawn) {
    html += "<p class=\"soft\">The first " + std::to_string(most_drawn) + " of " +
            std::to_string(count) + " are drawn; the table has them all.</p>\n";
  }
  html += "<div class=\"exhibits\">\n";
  for (std::size_t n = 0; n < figures.size(); ++n) { html += html_figure(figures[n], svgs[n]); }
  return html + "</div>\n</section>\n";
}

/// Side by side, so that a reader sees at once that a compiler changed and not the code.
Table provenance_table(const GateReport& report) {
  Table table{.id = "provenance", .title = "Builds", .columns = {"", "accepted", "now"}};
  const auto value = [](const auto& map, const std::string& key) {
    const auto found = map.find(key);
    return found == map.end() ? std::string() : found->second;
  };
  for (const char* key : {"commit", "version", "compiler", "flags", "processor", "date"}) {
    table.rows.push_back(
        {std::string(key), value(report.baseline.provenance, key), value(report.provenance, key)});
  }
  return table;
}

Table ledger_table(const gate::Baseline& baseline) {
  Table table{.id = "ledger",
              .title = "What was approved",
              .columns = {"date", "commit", "cases", "reason"}};
  for (auto entry = baseline.ledger.rbegin(); entry != baseline.ledger.rend(); ++entry) {
    table.rows.push_back(
        {entry->date, entry->commit, static_cast<double>(entry->cases.size()), entry->reason});
  }
  return table;
}

/// So short that it is read at a glance.
Table worst_table(const gate::Verdict& verdict) {
  constexpr std::size_t at_a_glance = 20;
  Table table = changes_table(verdict, false);
  if (table.rows.size() > at_a_glance) {
    table.caption = "The worst " + std::to_string(at_a_glance) + " of " +
                    std::to_string(table.rows.size()) + ".";
    table.rows.resize(at_a_glance);
  }
  return table;
}

std::vector<Fact> rule_facts() {
  return {
      {"same", "every bit", "nothing further is looked at"},
      {"whole", "finite, complete, of the same units and bounds", "before any difference is taken"},
      {"rounding", "10 times the spread",
       "seen between builds and orders of summation, kept with the baseline"},
      {"errors", "0.1 digits", "and no more; a hundredth of a two-sided bound is no error"},
      {"counts and numbers without a bound", "1 %", "instructions, evaluations; facts of a run"},
      {"curves", "0.1 % of the range in x, 0.2 % in y",
       "0.1 digits on a logarithmic axis; half a sample late"}};
}

}  // namespace

std::string to_html(const GateReport& report) {
  const std::string title = "Palpate gate";
  const auto& last = report.baseline.ledger;
  std::string body =
      html_banner({.title = title,
                   .small_print = {report.command, report.results,
                                   last.empty() ? "" : "baseline of " + last.back().date},
                   .held = report.verdict.holds(),
                   .verdict = verdict_text(report.verdict),
                   .detail = verdict_sentence(report.verdict)});
  body += "<main>\n";
  if (!report.verdict.faults.empty()) {
    body += "<h2>Why</h2>\n" + html_notes(report.verdict.faults);
  }
  const Table shown = worst_table(report.verdict);
  if (!shown.rows.empty()) { body += "<h2>What changed</h2>\n" + html_table(shown); }
  body += curves_section(report);
  const Table all = changes_table(report.verdict, true);
  if (all.rows.size() > shown.rows.size()) { body += "<h2>All changes</h2>\n" + html_table(all); }
  body += "<h2>How it was judged</h2>\n" + html_facts(rule_facts());
  body += "<h2>Where the numbers come from</h2>\n" + html_table(provenance_table(report)) +
          html_table(ledger_table(report.baseline)) + "</main>\n" +
          html_provenance({}, report.command);
  return html_page(title, body, {});
}

}  // namespace palpate
