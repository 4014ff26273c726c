// SPDX-License-Identifier: MIT

#include "reports/gate_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "fixtures/io/file_bytes.hpp"
#include "reports/html/html_page.hpp"
#include "reports/results/results_json.hpp"
#include "validation/gate/gate.hpp"

namespace palpate {
namespace {

using gate::CaseChanges;
using gate::Change;
using gate::ChangeKind;

/// Returns true for a case that failed or improved.
bool is_notable(const Change& change) {
  return change.fails() || change.kind == ChangeKind::better;
}

/// Number as text; empty for curves, which have no single number.
std::string number_of(const Change& change, double value) {
  const bool number = change.before != 0.0 || change.now != 0.0;
  if (!number) { return {}; }
  return plain_number(value, digits_apart(change.before, change.now)) +
         (change.unit == "1" ? "" : " " + change.unit);
}

std::vector<std::string> row_of(const CaseChanges& one, const Change& change) {
  const bool texts = !change.text_before.empty() || !change.text_now.empty();
  return {std::string(name_of(change.kind)),
          one.outcome.name,
          change.item.empty() ? "status" : change.item,
          texts ? change.text_before : number_of(change, change.before),
          texts ? change.text_now : number_of(change, change.now),
          texts ? "" : change.moved,
          change.allowed};
}

/// Rows of a case that failed or improved: its worst changes and the number of further ones.
std::vector<std::vector<std::string>> summary_of(const CaseChanges& one) {
  constexpr std::ptrdiff_t most = 4;
  std::vector<std::vector<std::string>> rows;
  const auto all = std::max<std::ptrdiff_t>(1, std::ranges::count_if(one.changes, is_notable));
  for (std::ptrdiff_t n = 0; n < std::min(most, all); ++n) {
    rows.push_back(row_of(one, one.changes[static_cast<std::size_t>(n)]));
  }
  if (all > most) { rows.back()[2] += ", and " + std::to_string(all - most) + " more"; }
  return rows;
}

/// Sorts changes by kind, each kind by how many times what is allowed they moved.
std::vector<std::vector<std::string>> rows_of(const gate::GateResult& result, bool all) {
  std::vector<std::pair<std::pair<ChangeKind, double>, std::vector<std::string>>> rows;
  for (const CaseChanges& one : result.cases) {
    if (all) {
      for (const Change& change : one.changes) {
        rows.emplace_back(std::pair(change.kind, change.excess), row_of(one, change));
      }
    } else if (one.fails() || one.better()) {
      for (std::vector<std::string>& row : summary_of(one)) {
        const Change& worst = one.changes.front();
        rows.emplace_back(std::pair(worst.kind, worst.excess), std::move(row));
      }
    }
  }
  std::ranges::stable_sort(rows, std::ranges::greater{}, [](const auto& row) { return row.first; });
  std::vector<std::vector<std::string>> texts;
  for (auto& [order, row] : rows) {
    for (std::string& cell : row) { cell = io::printable(cell); }
    texts.push_back(std::move(row));
  }
  return texts;
}

constexpr std::array<const char*, 7> heads{"",    "case",     "what",   "before",
                                           "now", "moved by", "allowed"};

Table changes_table(const gate::GateResult& result) {
  Table table{.id = "changes", .title = "Everything that changed"};
  table.columns.assign(heads.begin(), heads.end());
  for (const std::vector<std::string>& row : rows_of(result, true)) {
    table.rows.emplace_back(row.begin(), row.end());
  }
  return table;
}

/// The worst changes of the cases that failed or improved.
LabelledTable notable_table(const std::vector<std::vector<std::string>>& rows, std::size_t most) {
  LabelledTable table{
      .columns = {"what", "judged", "case", "before", "now", "moved by", "allowed"}};
  for (std::size_t n = 0; n < std::min(rows.size(), most); ++n) {
    const std::vector<std::string>& row = rows[n];
    const Status status = row[0] == name_of(ChangeKind::better) ? Status::pass : Status::fail;
    std::vector<LabelledTable::Cell> cells{row[2], Badge{status, row[0]}, row[1]};
    for (std::size_t k = 3; k < row.size(); ++k) {
      cells.emplace_back(row[k].empty() ? "-" : row[k]);
    }
    table.rows.push_back(std::move(cells));
  }
  return table;
}

using Json = nlohmann::ordered_json;

Json change_json(const gate::Change& change) {
  const bool texts = !change.text_before.empty() || !change.text_now.empty();
  const bool numbers = change.before != 0.0 || change.now != 0.0;
  const auto value = [&](const std::string& text, double number) {
    return texts ? Json(text) : numbers ? finite_or_null(number) : Json(nullptr);
  };
  return object("item", change.item, "judgement", name_of(change.kind), "before",
                value(change.text_before, change.before), "now", value(change.text_now, change.now),
                "unit", change.unit, "moved", change.moved, "allowed", change.allowed, "excess",
                change.excess, "status", change.fails() ? "fail" : "pass");
}

Json changes_json(const gate::CaseChanges& one) {
  return object("name", one.outcome.name, "suite", one.outcome.suite, "status",
                name_of(one.outcome.status), "identical", one.identical, "better", one.better(),
                "changes", list_of(one.changes, change_json));
}

constexpr std::size_t most_drawn = 40;  ///< more series in one picture would not be readable

/// Band that shows the allowed deviation in y from the accepted curve.
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

const Figure* figure_named(const std::deque<Figure>& figures, const std::string& id) {
  const auto found = std::ranges::find(figures, id, &Figure::id);
  return found == figures.end() ? nullptr : &*found;
}

/// Change of a curve by more than rounding, or nullptr.
const Change* change_of(const CaseChanges& one, const std::string& item) {
  const auto found = std::ranges::find(one.changes, item, &Change::item);
  return found == one.changes.end() || found->kind == ChangeKind::rounding ? nullptr : &*found;
}

struct MovedCurve {
  const Change* change;
  Figure figure;
};

/// Appends the curves of one case that changed by more than rounding.
void add_overlays(const GateReport& report, const CaseChanges& one,
                  std::vector<MovedCurve>& curves) {
  const std::string& name = one.outcome.name;
  const gate::AcceptedCase* accepted = report.baseline.find(name);
  const auto now = std::ranges::find(report.candidate.outcomes, name, &Outcome::name);
  if (accepted == nullptr || now == report.candidate.outcomes.end()) { return; }
  const Outcome shown = gate::comparable(*now);
  for (const Figure& before : accepted->outcome.figures) {
    for (std::size_t n = 0; n < before.series.size(); ++n) {
      const Change* change = change_of(one, gate::curve_name(before, n));
      if (change == nullptr) { continue; }
      Figure figure = overlay(name, before, figure_named(shown.figures, before.id), n);
      figure.caption += ": " + change->moved +
                        (change->allowed.empty() ? "" : "; allowed " + change->allowed) + ".";
      curves.push_back({.change = change, .figure = std::move(figure)});
    }
  }
}

void add_curves(const GateReport& report, std::vector<PagePart>& parts) {
  std::vector<MovedCurve> curves;
  for (const CaseChanges& one : report.result.cases) { add_overlays(report, one, curves); }
  if (curves.empty()) { return; }
  std::ranges::stable_sort(curves, std::ranges::greater{}, [](const MovedCurve& curve) {
    return std::pair(curve.change->kind, curve.change->excess);
  });
  Section section{.kind = Section::Kind::section, .heading = "Curves that moved"};
  section.parts.emplace_back(
      Paragraph{"Sorted by how many times what is allowed they moved." +
                (curves.size() > most_drawn
                     ? " The first " + std::to_string(most_drawn) + " of " +
                           std::to_string(curves.size()) + " are drawn; the table has them all."
                     : std::string())});
  std::vector<Figure> figures;
  for (std::size_t n = 0; n < std::min(curves.size(), most_drawn); ++n) {
    figures.push_back(std::move(curves[n].figure));
  }
  section.parts.emplace_back(exhibits_of(figures));
  parts.emplace_back(std::move(section));
}

/// Provenance of both builds side by side, to show a change of the compiler or the flags.
Table provenance_table(const GateReport& report) {
  Table table = make_table("provenance", "Builds", "", {"", "accepted", "now"});
  for (const char* key : {"commit", "version", "compiler", "flags", "processor", "date"}) {
    table.rows.push_back(
        {std::string(key), entry(report.baseline.provenance, key), entry(report.provenance, key)});
  }
  return table;
}

Table ledger_table(const gate::Baseline& baseline) {
  Table table =
      make_table("ledger", "What was approved", "", {"date", "commit", "cases", "reason"});
  for (auto entry = baseline.ledger.rbegin(); entry != baseline.ledger.rend(); ++entry) {
    table.rows.push_back(
        {entry->date, entry->commit, static_cast<double>(entry->cases.size()), entry->reason});
  }
  return table;
}

std::vector<Fact> rule_facts() {
  return {
      {"same", "every bit", "nothing further is looked at"},
      {"whole", "finite, complete, of the same units and bounds", "before any difference is taken"},
      {"rounding", "10 times the spread",
       "seen between builds and orders of summation, kept with the baseline; at least a floor "
       "for each unit"},
      {"events", "two ticks", "and the spread"},
      {"errors", "0.1 digits", "and no more; a hundredth of a two-sided bound is no error"},
      {"counts and numbers without a bound", "1 %", "instructions, evaluations; facts of a run"},
      {"curves", "0.1 % of the range or two samples in x, 0.2 % in y",
       "0.1 digits on a logarithmic axis; half a sample late"},
      {"texts of a run", "none", "keys of the scene, kernel, integrator, sizes, warnings"}};
}

}  // namespace

std::string verdict_text(const gate::GateResult& result) {
  const std::string of = " of " + std::to_string(result.cases.size()) + " cases ";
  if (result.holds()) { return "PASS: none" + of + "became worse"; }
  if (result.counts().failed == 0) { return "FAIL: " + result.faults.front(); }
  return "FAIL: " + std::to_string(result.counts().failed) + of + "regressed";
}

std::string verdict_sentence(const gate::GateResult& result) {
  const gate::ChangeCounts sum = result.counts();
  std::string text = std::to_string(sum.identical) + " identical to the last bit, " +
                     std::to_string(sum.unchanged) + " within rounding or what is allowed, " +
                     std::to_string(sum.better) + " better, " + std::to_string(sum.failed) +
                     " regressed";
  return sum.better > 0 ? text + "; `palpate approve` keeps what is better" : text;
}

std::string builds_text(const GateReport& report) {
  const auto build = [](const std::map<std::string, std::string>& provenance) {
    return io::printable("commit " + entry(provenance, "commit") + ", " +
                         entry(provenance, "compiler") + ", " + entry(provenance, "processor"));
  };
  const std::string now = build(report.provenance);
  const std::string before = build(report.baseline.provenance);
  return "made by " + now + "; baseline by " + (before == now ? "the same" : before);
}

std::string changes_text(const gate::GateResult& result) {
  std::vector<std::vector<std::string>> rows = rows_of(result, false);
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

std::string to_json(const GateReport& report) {
  const gate::ChangeCounts sum = report.result.counts();
  Json approved = nullptr;
  if (!report.baseline.ledger.empty()) {
    const gate::Approval& last = report.baseline.ledger.back();
    approved = object("date", last.date, "commit", last.commit, "reason", last.reason);
  }
  return json_text(object(
      "schema", 1, "verdict", report.result.holds() ? "pass" : "fail", "reason",
      verdict_text(report.result), "results", report.results, "baseline", report.baseline_file,
      "approved", approved, "builds", builds_text(report), "identical", sum.identical, "unchanged",
      sum.unchanged, "better", sum.better, "failed", sum.failed, "faults", report.result.faults,
      "provenance", object("before", report.baseline.provenance, "now", report.provenance), "cases",
      list_of(report.result.cases, changes_json)));
}

std::string to_junit(const GateReport& report) {
  return to_junit({.title = "Palpate gate", .outcomes = report.result.outcomes()});
}

std::string to_html(const GateReport& report) {
  const auto& ledger = report.baseline.ledger;
  Page page{.banner = {.title = "Palpate gate",
                       .small_print = {report.command, report.results, builds_text(report),
                                       ledger.empty() ? "" : "baseline of " + ledger.back().date},
                       .status = report.result.holds() ? Status::pass : Status::fail,
                       .verdict = verdict_text(report.result),
                       .detail = verdict_sentence(report.result)},
            .command = report.command};
  const auto add = [&page](const char* heading, std::vector<PagePart> parts) {
    page.parts.emplace_back(Section{.heading = heading, .parts = std::move(parts)});
  };
  if (!report.result.faults.empty()) { add("Why", {Notes{report.result.faults}}); }
  if (gate::is_dirty(entry(report.baseline.provenance, "commit"))) {
    add("Doubt",
        {Notes{
            {"The baseline is of a build with uncommitted changes, which cannot be repeated."}}});
  }
  constexpr std::size_t at_a_glance = 20;
  const std::vector<std::vector<std::string>> notable = rows_of(report.result, false);
  if (!notable.empty()) {
    std::vector<PagePart> parts{notable_table(notable, at_a_glance)};
    if (notable.size() > at_a_glance) {
      parts.insert(parts.begin(), Paragraph{"The worst " + std::to_string(at_a_glance) + " of " +
                                            std::to_string(notable.size()) + "."});
    }
    add("What regressed, and what is better", std::move(parts));
  }
  add_curves(report, page.parts);
  const Table all = changes_table(report.result);
  if (all.rows.size() > std::min(notable.size(), at_a_glance)) { add("All changes", {all}); }
  add("How it was judged", {rule_facts()});
  add("Where the numbers come from", {provenance_table(report), ledger_table(report.baseline)});
  return render(page);
}

}  // namespace palpate
