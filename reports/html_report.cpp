// SPDX-License-Identifier: MIT
#include "reports/html_report.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "reports/figure_svg.hpp"
#include "reports/html_page.hpp"
#include "reports/markup.hpp"
#include "report_assets.hpp"

namespace palpate {

namespace {

std::string anchor(const std::string& case_name) {
  std::string id = "case-" + case_name;
  std::ranges::replace(id, '/', '-');
  return id;
}

std::string with_unit(double value, const std::string& unit) {
  return short_number(value) + (unit == "1" || unit.empty() ? "" : " " + unit);
}

std::string bound_text(const Quantity& q) {
  const bool above = std::isfinite(q.lower);
  const bool below = std::isfinite(q.upper);
  if (above && below) {
    return q.lower == q.upper ? "= " + with_unit(q.lower, q.unit)
                              : short_number(q.lower) + " to " + with_unit(q.upper, q.unit);
  }
  if (below) { return "≤ " + with_unit(q.upper, q.unit); }
  return above ? "≥ " + with_unit(q.lower, q.unit) : "finite";
}

std::string banner(const Results& results) {
  const Tally sum = tally(results.outcomes);
  const int ran = sum.all() - sum.skipped;
  std::string head = sum.holds() ? "Pass: all " + std::to_string(sum.passed) + " cases that ran hold"
                                 : "Fail: " + std::to_string(sum.failed + sum.errors) + " of " +
                                       std::to_string(ran) + " cases fell short";
  if (ran == 0) { head = "Fail: no case ran"; }
  std::string rest = std::to_string(sum.passed) + " passed, " + std::to_string(sum.failed) +
                     " failed, " + std::to_string(sum.errors) + " ended in an error, " +
                     std::to_string(sum.skipped) + " not run (each says why).";
  return "<div class=\"verdict " + std::string(sum.holds() ? "pass" : "fail") + "\"><strong>" + head +
         "</strong>" + rest + "</div>\n";
}

std::string filters() {
  return "<div class=\"filters\"><input type=\"search\" placeholder=\"Filter cases\" "
         "aria-label=\"Filter cases\"><button type=\"button\" data-status=\"\" "
         "aria-pressed=\"true\">all</button><button type=\"button\" data-status=\"fail\">failed"
         "</button><button type=\"button\" data-status=\"error\">errors</button><button "
         "type=\"button\" data-status=\"skip\">not run</button></div>\n";
}

/// Errors and failures first, then what is closest to its bound, then what was not run.
std::vector<const Outcome*> worst_first(const std::vector<Outcome>& outcomes) {
  std::vector<const Outcome*> order;
  for (const Outcome& outcome : outcomes) { order.push_back(&outcome); }
  const auto rank = [](const Outcome* outcome) {
    const Quantity* tight = tightest_quantity(*outcome);
    const double share = tight != nullptr ? share_of_bound(*tight) : 0.0;
    switch (outcome->status) {
      case Status::error: return std::pair(0, 0.0);
      case Status::fail: return std::pair(1, -share);
      case Status::pass: return std::pair(2, -share);
      case Status::skip: break;
    }
    return std::pair(3, 0.0);
  };
  std::ranges::stable_sort(order, {}, rank);
  return order;
}

std::string case_row(const Outcome& outcome) {
  const std::string status(name_of(outcome.status));
  std::string row = "<tr data-status=\"" + status + "\"><td>" + html_badge(outcome.status) +
                    "</td><td class=\"name\"><a href=\"#" + anchor(outcome.name) + "\">" +
                    escape_markup(outcome.name) + "</a></td>";
  const Quantity* tight = tightest_quantity(outcome);
  if (tight == nullptr) {
    return row + "<td class=\"why\" colspan=\"5\">" + escape_markup(outcome.reason) + "</td></tr>\n";
  }
  const double share = share_of_bound(*tight);
  row += "<td>" + escape_markup(tight->name) + "</td>";
  row += "<td class=\"number\" data-label=\"measured\" title=\"" + exact_number(tight->value) + "\">" +
         with_unit(tight->value, escape_markup(tight->unit)) + "</td>";
  row += "<td class=\"number\" data-label=\"allowed\">" + escape_markup(bound_text(*tight)) + "</td>";
  row += "<td class=\"number\" data-label=\"share of bound\">" +
         (std::isfinite(share) ? short_number(std::round(1000.0 * share) / 10.0) + " %" : "–") + "</td>";
  row += "<td class=\"why\" data-label=\"bound from\">" + escape_markup(tight->bound_from) + "</td>";
  return row + "</tr>\n";
}

std::string case_table(const std::vector<Outcome>& outcomes) {
  std::string html =
      "<div class=\"scroll\"><table class=\"cases\"><thead><tr><th>verdict</th><th>case</th>"
      "<th>tightest quantity</th><th class=\"number\">measured</th><th class=\"number\">allowed</th>"
      "<th class=\"number\">share of bound</th><th>where the bound comes from</th></tr></thead>\n<tbody>\n";
  for (const Outcome* outcome : worst_first(outcomes)) { html += case_row(*outcome); }
  return html + "</tbody></table></div>\n";
}

std::string quantities_table(const Outcome& outcome) {
  std::string html =
      "<div class=\"scroll\"><table class=\"data\"><thead><tr><th>quantity</th><th "
      "class=\"number\">measured</th><th class=\"number\">allowed</th><th>verdict</th><th>where the "
      "bound comes from</th></tr></thead><tbody>\n";
  for (const Quantity& q : outcome.quantities) {
    html += "<tr><td class=\"name\">" + escape_markup(q.name) + "</td><td class=\"number\" title=\"" +
            exact_number(q.value) + "\">" + escape_markup(with_unit(q.value, q.unit)) +
            "</td><td class=\"number\">" + (q.judged() ? escape_markup(bound_text(q)) : "") + "</td><td>" +
            (q.judged() ? html_badge(q.holds() ? Status::pass : Status::fail)
                        : "<span class=\"badge info\">info</span>") +
            "</td><td class=\"why\">" + escape_markup(q.bound_from) + "</td></tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string quantities(const Outcome& outcome) {
  if (outcome.quantities.empty()) { return {}; }
  const std::string table = quantities_table(outcome);
  constexpr std::size_t few = 8;
  if (outcome.quantities.size() <= few || outcome.status == Status::fail) { return table; }
  return "<details><summary>" + std::to_string(outcome.quantities.size()) +
         " quantities</summary>\n" + table + "</details>\n";
}

std::string timings(const Outcome& outcome) {
  if (outcome.timings.empty()) { return {}; }
  Table table{.title = "Cost", .caption = "Wall time on this machine; not judged here.",
              .columns = {"what", "value", "unit"}};
  for (const Timing& timing : outcome.timings) {
    table.rows.push_back({timing.name, timing.value, timing.unit});
  }
  return "<details><summary>Cost on this machine</summary>\n" + html_table(table) + "</details>\n";
}

std::string case_section(const Outcome& outcome, const std::string*& svg) {
  std::string html = "<article id=\"" + anchor(outcome.name) + "\">\n<h3>" +
                     html_badge(outcome.status) + " " + escape_markup(outcome.name) +
                     "</h3>\n<p class=\"claim\">" + escape_markup(outcome.claim) + "</p>\n";
  if (!outcome.reason.empty()) { html += "<p><b>" + escape_markup(outcome.reason) + "</b></p>\n"; }
  if (!outcome.notes.empty()) {
    html += "<ul class=\"notes\">";
    for (const std::string& note : outcome.notes) { html += "<li>" + escape_markup(note) + "</li>"; }
    html += "</ul>\n";
  }
  html += quantities(outcome);
  if (!outcome.figures.empty()) {
    html += "<div class=\"figures\">\n";
    for (const Figure& figure : outcome.figures) { html += html_figure(figure, *svg++); }
    html += "</div>\n";
  }
  constexpr std::size_t long_table = 24;
  for (const Table& table : outcome.tables) {
    html += table.rows.size() <= long_table
                ? html_table(table)
                : "<details><summary>" + escape_markup(table.title) + " (" +
                      std::to_string(table.rows.size()) + " rows)</summary>\n" + html_table(table) +
                      "</details>\n";
  }
  return html + timings(outcome) + "</article>\n";
}

/// "oscillator" of "oscillator/order/rk4".
std::string group_of(const Outcome& outcome) { return outcome.name.substr(0, outcome.name.find('/')); }

std::string contents(const std::vector<Outcome>& outcomes) {
  std::string html = "<nav class=\"contents\" aria-label=\"Cases\"><ul>\n";
  for (const Outcome& outcome : outcomes) {
    html += "<li><a href=\"#" + anchor(outcome.name) + "\">" + escape_markup(outcome.name) + "</a></li>\n";
  }
  return "<details><summary>All cases by name</summary>\n" + html + "</ul></nav></details>\n";
}

}  // namespace

double share_of_bound(const Quantity& q) {
  if (!(q.value == q.value)) { return unbounded; }
  const bool above = std::isfinite(q.lower);
  const bool below = std::isfinite(q.upper);
  if (above && below) {
    const double half = 0.5 * (q.upper - q.lower);
    const double away = std::abs(q.value - 0.5 * (q.upper + q.lower));
    return half > 0.0 ? away / half : (away == 0.0 ? 0.0 : unbounded);  // met exactly, or not
  }
  if (below) { return q.upper > 0.0 ? std::max(0.0, q.value / q.upper) : (q.holds() ? 1.0 : unbounded); }
  if (above) {
    if (q.value <= 0.0) { return q.holds() ? 1.0 : unbounded; }
    return std::max(0.0, q.lower / q.value);
  }
  return std::isfinite(q.value) ? 0.0 : unbounded;
}

const Quantity* tightest_quantity(const Outcome& outcome) {
  const Quantity* tightest = nullptr;
  for (const Quantity& q : outcome.quantities) {
    if (!q.judged()) { continue; }
    if (tightest == nullptr || share_of_bound(q) > share_of_bound(*tightest)) { tightest = &q; }
  }
  return tightest;
}

std::string to_html(const Results& results) {
  std::vector<const Figure*> figures;
  for (const Outcome& outcome : results.outcomes) {
    for (const Figure& figure : outcome.figures) { figures.push_back(&figure); }
  }
  const std::vector<std::string> drawings = draw_figures(figures);
  const std::string* svg = drawings.data();
  std::vector<Fact> facts;
  for (const auto& [name, value] : results.provenance) { facts.push_back({name, value, {}}); }
  const auto known = [&](const char* name) {
    const auto found = results.provenance.find(name);
    return found == results.provenance.end() ? std::string("?") : found->second;
  };
  std::string body = "<header class=\"top\"><h1>" + escape_markup(results.title) +
                     "</h1>\n<p class=\"soft\">" + escape_markup(results.command) + " · version " +
                     escape_markup(known("version")) + " · " + escape_markup(known("commit")) + " · " +
                     escape_markup(known("date")) + " · <a href=\"#provenance\">provenance</a></p>\n" +
                     banner(results) + "</header>\n<main>\n";
  body += filters() + case_table(results.outcomes) + contents(results.outcomes);
  std::string group;
  for (const Outcome& outcome : results.outcomes) {
    if (group_of(outcome) != group) {
      group = group_of(outcome);
      std::string heading = group;
      heading[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(heading[0])));
      body += "<h2>" + escape_markup(heading) + "</h2>\n";
    }
    body += case_section(outcome, svg);
  }
  body += "</main>\n" + html_provenance(facts, results.command);
  return html_page(results.title, body, {assets::report_js});
}

}  // namespace palpate
